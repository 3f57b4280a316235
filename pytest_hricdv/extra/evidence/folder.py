"""A folder of evidence: `write_evidence` makes it from a report, and `verify_evidence` verifies it later.

`hricdv evidence` calls both. Verification checks hashes and rows, and reruns a sample of the tests.
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from msgspec import Struct

from pytest_hricdv._base.atomic_file import write_bytes
from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, MalformedError, from_json, read_bytes, read_text
from pytest_hricdv.extra.evidence import outputs
from pytest_hricdv.extra.evidence.requirement_lists import ListedRequirement, read_requirements
from pytest_hricdv.extra.evidence.rows import EvidenceRow, gather_evidence
from pytest_hricdv.report.html import standalone
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, load
from pytest_hricdv.results.model import Report, TestResult

LIST = "listed"
"""Name, without suffix, of the copy of the list of requirements."""

TIMEOUT_S = 3600.0
"""Time limit (s) for rerunning the sample of tests. Chosen: a test takes seconds."""

SHOWN_CHECKS = 12
"""Maximum number of tests of a requirement on the page; `checks.csv` has all."""


def write_evidence(
    source: Path, folder: Path, listed: Path | None = None
) -> tuple[tuple[EvidenceRow, ...], tuple[str, ...]]:
    """Write what a report shows for each requirement.

    Args:
        source: a report, or its folder.
        folder: created if it is missing.
        listed: requirements of another tool.

    Returns:
        The rows, and other failures of the session, a sentence each.

    Raises:
        ReportError: the report or the list cannot be used, or the folder cannot be written.
    """
    report = load(source)
    file = source / REPORT_NAME if source.is_dir() else source
    copies = {REPORT_NAME: read_bytes(file, MAX_REPORT_BYTES)}
    if listed is not None:
        read_requirements(listed)
        copies[f"{LIST}{listed.suffix.lower()}"] = read_bytes(listed)
    rows = _rows(report, listed)
    if not rows:
        raise ReportError(f"{file}: has no requirements, so there is nothing to show")
    files = {**copies, **_derive(report, rows)}
    facts = outputs.facts_of(report)
    files[outputs.STATEMENT] = outputs.statement(files, rows, facts).encode()
    try:
        for name, data in files.items():
            write_bytes(folder / name, data)
    except OSError as error:
        raise ReportError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return rows, facts.problems


def _rows(report: Report, listed: Path | None) -> tuple[EvidenceRow, ...]:
    entries: Sequence[ListedRequirement] = () if listed is None else read_requirements(listed)
    return gather_evidence(report, entries)


def _derive(report: Report, rows: Sequence[EvidenceRow]) -> dict[str, bytes]:
    """The files derived from the report: name -> content."""
    facts = outputs.facts_of(report)
    return {
        name: text.encode()
        for name, text in (
            ("index.html", _page(rows, facts)),
            ("requirements.csv", outputs.requirements_csv(rows)),
            ("checks.csv", outputs.checks_csv(rows)),
            ("needs.json", outputs.needs_json(rows, facts)),
            ("requirements.reqif", outputs.reqif(rows, facts)),
        )
    }


def _page(rows: Sequence[EvidenceRow], facts: outputs.SessionFacts) -> str:
    """The evidence for screen and print: one file without scripts."""
    counts = Counter(row.status for row in rows)
    return standalone(__package__, "evidence.html.jinja", rows=rows, facts=facts, counts=counts, shown=SHOWN_CHECKS)


def verify_evidence(folder: Path, project: Path, rerun: int) -> Iterator[str]:
    """Check a folder of evidence; yields what is wrong with it, a sentence each.

    Args:
        project: the folder to rerun tests in.
        rerun: number of tests to rerun, evenly spread over the report.

    Raises:
        ReportError: there is no statement, or no report to check the files against.
    """
    hashes = _hashes(folder / outputs.STATEMENT)
    found = {path.name: path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")}
    for name in sorted(hashes.keys() | found.keys() - {outputs.STATEMENT}):
        if name not in found:
            yield f"{name}: is missing"
        elif name not in hashes:
            yield f"{name}: is not in {outputs.STATEMENT}"
        elif outputs.sha256(read_bytes(found[name], MAX_REPORT_BYTES)) != hashes[name]:
            yield f"{name}: was changed: its SHA-256 is not that of {outputs.STATEMENT}"
    report = load(folder / REPORT_NAME)
    rows = _rows(report, next((path for name, path in found.items() if name.rpartition(".")[0] == LIST), None))
    for name, data in _derive(report, rows).items():
        if name in found and read_bytes(found[name], MAX_REPORT_BYTES) != data:
            yield f"{name}: contradicts {REPORT_NAME}"
    if rerun:
        yield from _run_again(report, project, rerun)


class _Subject(Struct):
    name: str
    digest: dict[str, str]


class _Statement(Struct):
    """The parts read from an in-toto statement."""

    subject: list[_Subject]


def _hashes(path: Path) -> Mapping[str, str]:
    try:
        statement = from_json(read_text(path), _Statement)
    except FileNotFoundError:
        raise ReportError(f"{path}: no such statement; `evidence` writes one") from None
    except MalformedError as error:
        raise ReportError(f"{path}{error}") from None
    return {subject.name: subject.digest.get("sha256", "") for subject in statement.subject}


def _run_again(report: Report, project: Path, count: int) -> Iterator[str]:
    """Rerun a sample of tests: the code and each record have to be the same, bit for bit."""
    able = [test for test in report.tests if test.record_sha256 is not None]
    chosen = [able[place * len(able) // min(count, len(able))] for place in range(min(count, len(able)))]
    if not chosen:
        yield "no test of the report has a record, so none was rerun"
        return
    with TemporaryDirectory() as temporary:
        target = Path(temporary, "report")
        problem = _run(report, chosen, project, target)
        if problem:
            yield problem
            return
        again = load(target)
    if again.code_under_test.sha256 != report.code_under_test.sha256:
        yield "the code under test is not that of the evidence: its SHA-256 differs"
    now = {test.nodeid: test.record_sha256 for test in again.tests}
    for test in chosen:
        if test.nodeid not in now:
            yield f"{test.id}: was not rerun"
        elif now[test.nodeid] != test.record_sha256:
            yield f"{test.id}: rerun, its record has another SHA-256"


def _run(report: Report, chosen: Sequence[TestResult], project: Path, target: Path) -> str:
    """Run tests in the project; returns what went wrong, or an empty string."""
    seeds = {suite.name: suite.seed for suite in report.suites}
    options = [f"--hri-suite={report.rerun_options.suite}", *report.rerun_options.options]
    options += [f"--hri-seed={seeds[chosen[0].suite]}", f"--hri-report={target}", "--hri-audit=off", "--hri-diagnose=0"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    try:
        ended = subprocess.run(
            [*command, *(test.nodeid for test in chosen)],
            cwd=project,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"the tests could not be rerun in {project}: {error}"
    if not (target / REPORT_NAME).is_file():
        last = ended.stdout.decode("utf-8", "replace").strip().splitlines()[-1:] or ["no output"]
        return f"the tests could not be rerun in {project}: pytest ended with {ended.returncode}: {last[0]}"
    return ""
