"""`write_exports`, for `Exporter` and `hricdv report export`: writes coverage for other tools, and the markdown."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.report import files, totals
from pytest_hricdv.report.coverage_formats import cobertura, lcov, ucis
from pytest_hricdv.report.markdown import markdown
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report

OF_CODE = ("cobertura", "lcov")
"""The formats with coverage of code only. They are not written if it was not measured, as they would say 0 %."""


@dataclass(frozen=True)
class ExportTargets:
    """The files to write; None for those that were not asked for.

    `job_summary` is GitHub's, and is appended to; `github` says that the session runs in a workflow there.
    """

    cobertura: Path | None
    lcov: Path | None
    ucis: Path | None
    summary: Path | None
    job_summary: Path | None
    github: bool

    @classmethod
    def of(cls, named: Mapping[str, Path | None]) -> ExportTargets:
        """These files, and what GitHub's environment asks for."""
        job = os.environ.get("GITHUB_STEP_SUMMARY", "")
        return cls(**named, job_summary=Path(job) if job else None, github=os.environ.get("GITHUB_ACTIONS") == "true")


@dataclass(frozen=True)
class ExportResult:
    """Messages: files written or not, with the reason; and errors."""

    notes: tuple[str, ...]
    problems: tuple[str, ...]


def write_exports(report: Report, targets: ExportTargets, root: str) -> ExportResult:
    """Write the files that were asked for.

    Args:
        report: the report of a session, or merged.
        targets: which files.
        root: the folder that the report's file names are relative to.
    """
    notes: list[str] = []
    problems: list[str] = []
    texts: dict[str, tuple[Path | None, Callable[[], str]]] = {
        "cobertura": (targets.cobertura, lambda: cobertura(report, root)),
        "lcov": (targets.lcov, lambda: lcov(report)),
        "ucis": (targets.ucis, lambda: ucis(report)),
        "summary": (targets.summary, lambda: markdown(report)),
    }
    for name, (path, text) in texts.items():
        if path is None:
            continue
        if name in OF_CODE and not report.code_under_test.measured:
            notes.append(f"{name}: not written, the code was not measured: {totals.explain_no_coverage(report)}")
            continue
        try:
            notes.append(f"{name}: {files.write_text(path, text())}")
        except ReportError as error:
            problems.append(f"--hri-{name}: {error}")
    if targets.job_summary is not None:
        problems += _append(targets.job_summary, f"{markdown(report)}\n")
    return ExportResult(tuple(notes), tuple(problems))


def _append(path: Path, text: str) -> list[str]:
    """Appends: other steps may have written to the file, which GitHub reads after the step."""
    try:
        with path.open("a", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
    except OSError as error:
        return [f"GITHUB_STEP_SUMMARY={path}: {error.strerror or error}"]
    return []
