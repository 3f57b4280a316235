"""Exports: files for other tools, written after the session. Registered in the controlling process only."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.report import ci_formats, coverage_files, files, totals
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report

if TYPE_CHECKING:
    from pytest_hricdv.session.export_options import ExportOptions
    from pytest_hricdv.session.reporting import Reporting


@dataclass(frozen=True)
class Written:
    """Messages: files written or not, with the reason; and errors."""

    notes: tuple[str, ...]
    problems: tuple[str, ...]


def write_exports(report: Report, exports: ExportOptions, root: str) -> Written:
    """Write the files that were asked for.

    Args:
        report: of a session, or merged.
        exports: which files.
        root: the folder that the report's file names are relative to.
    """
    notes: list[str] = []
    problems: list[str] = []
    texts: dict[str, tuple[Path | None, Callable[[], str]]] = {
        "cobertura": (exports.cobertura, lambda: coverage_files.cobertura(report, root)),
        "lcov": (exports.lcov, lambda: coverage_files.lcov(report)),
        "summary": (exports.summary, lambda: ci_formats.markdown(report)),
    }
    for name, (path, text) in texts.items():
        if path is None:
            continue
        if name != "summary" and not report.code_under_test.measured:  # a file would say 0 %
            notes.append(f"{name}: not written, the code was not measured: {totals.unmeasured(report)}")
            continue
        try:
            notes.append(f"{name}: {files.write_text(path, text())}")
        except ReportError as error:
            problems.append(f"--hri-{name}: {error}")
    if exports.job_summary is not None:
        problems += _appended(exports.job_summary, f"{ci_formats.markdown(report)}\n")
    return Written(tuple(notes), tuple(problems))


def _appended(path: Path, text: str) -> list[str]:
    """Appends: other steps may have written to the file, which GitHub reads after the step."""
    try:
        with path.open("a", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
    except OSError as error:
        return [f"GITHUB_STEP_SUMMARY={path}: {error.strerror or error}"]
    return []


class Exporting:
    """Writes the files after the report, also of a stopped session; a file that cannot be written fails it."""

    def __init__(self, config: pytest.Config, reporting: Reporting, exports: ExportOptions) -> None:
        self._config = config
        self._reporting = reporting
        self._exports = exports
        self._places: dict[str, ci_formats.Place] = {}
        self._notes: list[str] = []
        self._problems: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Checks before the first test that the files can be written after the last."""
        exports = self._exports
        if self._config.getoption("collectonly"):
            return
        for path in (exports.cobertura, exports.lcov, exports.summary):
            if path is not None:
                try:
                    files.prepare(path.parent)
                except ReportError as error:
                    raise pytest.UsageError(f"{path}: {error}") from None

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Stores the place of the test function."""
        file, line, _ = report.location
        self._places[report.nodeid] = (self._in_repository(file), (line or 0) + 1)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Iterator[None]:
        """The outermost wrapper: the report exists when the others have ended."""
        try:
            return (yield)
        finally:
            if self._reporting.report is not None:
                self._export(self._reporting.report)
                session.testsfailed += bool(self._problems)

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Writes where the files are, errors, and GitHub's annotations."""
        for note in self._notes:
            terminalreporter.write_line(note, light=True)
        for problem in self._problems:
            terminalreporter.write_line(f"FAILED {problem}", red=True, bold=True)
        if self._exports.github and self._reporting.report is not None:
            for annotation in ci_formats.annotations(self._reporting.report, self._places):
                terminalreporter.write_line(annotation)

    def _export(self, report: Report) -> None:
        self._tell_junit(report)
        written = write_exports(report, self._exports, str(self._config.rootpath))
        self._notes += written.notes
        self._problems += written.problems

    def _tell_junit(self, report: Report) -> None:
        # pytest's documented way, `record_testsuite_property`, is a fixture: with xdist, fixtures run in workers, where
        # no XML is written.
        for plugin in self._config.pluginmanager.get_plugins():
            if hasattr(plugin, "add_global_property"):
                for name, value in ci_formats.junit_suite_properties(report):
                    plugin.add_global_property(name, value)

    def _in_repository(self, file: str) -> str:
        """A file's name as GitHub expects it: relative to the checked-out repository, with slashes."""
        root = os.environ.get("GITHUB_WORKSPACE") or self._config.invocation_params.dir
        return Path(os.path.relpath(self._config.rootpath / file, root)).as_posix()
