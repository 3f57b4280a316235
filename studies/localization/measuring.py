"""Measuring: each fault is tried in a session, and what the rankings say of it is kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path

import msgspec

from pytest_hricdv._base.record import Count, PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from studies import session
from studies.localization import sessions
from studies.localization.faults import Drawn, Fault, Truth
from studies.localization.projects import Project
from studies.localization.ranking import Hit, hits, shown_right
from studies.session import SessionError

RESULTS = "results.jsonl"
_DIAGNOSIS = session.ROOT / "pytest_hricdv" / "extra" / "diagnosis"


class Measured(PlainRecord, frozen=True, kw_only=True):
    """A fault that was tried.

    Args:
        project: name of the testbench.
        fault: its id.
        kind: `planted`, or the operator of a mutant.
        code: digest of the diagnosis, of the options and of the faulty file.
        is_omission: something is missing, and nothing stands in its place.
        failing: tests that fail with it.
        hits: ranking -> how well it does; empty where no test fails.
        shown: whether the first statement that is shown is in the faulty function; None where none is shown.
    """

    project: str
    fault: str
    kind: str
    code: str
    is_omission: bool = False
    failing: Count = 0
    hits: Mapping[str, Hit] = {}
    shown: bool | None = None


def measured(
    project: Project, folder: Path, drawn: Drawn, options: tuple[str, ...], *, again: bool
) -> Iterator[Measured]:
    """Try faults of a testbench; what was tried before is not tried again.

    Args:
        project: the testbench.
        folder: of the study.
        drawn: which faults.
        options: further ones, of pytest.
        again: try none: what was tried before only.

    Raises:
        SessionError: tests fail without a fault, or did not run.
        FaultError: a planted fault does not fit.
    """
    results = folder / f"{project.name}-{RESULTS}"
    before = {line.code: line for line in _read(results)}
    home = folder / project.name
    sessions.prepared(project, home)
    code = project.map(home)
    is_checked = False
    for fault in drawn.of(project.name, code):
        key = _key(fault, options)
        if key in before:
            yield before[key]
        elif not again:
            if not is_checked:
                _check(project, home, options)
                is_checked = True
            made = _tried(project, home, fault, options, key)
            with results.open("ab") as file:
                file.write(msgspec.json.encode(made) + b"\n")
            yield made


def _read(results: Path) -> list[Measured]:
    if not results.is_file():
        return []
    return [msgspec.json.decode(line, type=Measured) for line in results.read_bytes().splitlines()]


def _key(fault: Fault, options: Sequence[str]) -> str:
    digest = sha256(repr((fault.id, fault.file, fault.text, *options)).encode())
    for path in sorted(_DIAGNOSIS.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _check(project: Project, home: Path, options: tuple[str, ...]) -> None:
    report = sessions.ran(project, home, None, options)
    failing = [test.id for test in report.tests if test.fails] if report is not None else []
    if failing:
        raise SessionError(f"{project.name}: {failing[0]} fails without a fault")


def _tried(project: Project, home: Path, fault: Fault, options: tuple[str, ...], key: str) -> Measured:
    report = sessions.ran(project, home, fault, options)
    listed = CodeMap.of(report.code_under_test) if report is not None else None
    if report is None or listed is None:  # the code cannot be imported: no test has run
        return Measured(project=project.name, fault=fault.id, kind=fault.kind, code=key)
    truth = Truth.of(fault, next(file for file in listed.files if file.name == fault.file))
    return Measured(
        project=project.name,
        fault=fault.id,
        kind=fault.kind,
        is_omission=truth.is_omission,
        failing=sum(test.fails for test in report.tests),
        hits=hits(report, truth) or {},
        shown=shown_right(report, truth),
        code=key,
    )
