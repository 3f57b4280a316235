"""Makes the texts of evidence files: tables, ReqIF and `needs.json` with results, and an in-toto statement.

`folder` calls one function for each file, with the rows and the `SessionFacts` of a report (`facts_of`).
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec.structs import asdict

from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.extra.evidence.rows import EvidenceRow
from pytest_hricdv.report.html import standalone
from pytest_hricdv.results.model import Report

STATEMENT = "statement.json"
"""File name of the in-toto statement, which has the hashes of all other files."""

STATEMENT_TYPE = "https://in-toto.io/Statement/v1"
PREDICATE_TYPE = "https://in-toto.io/attestation/test-result/v0.1"


class SessionFacts(PlainRecord, frozen=True, kw_only=True):
    """Facts about the session that ran the tests.

    Args:
        began: date and time (UTC).
        revision: the project's revision; it ends with `+` if tracked files had local changes.
        code: SHA-256 of the code under test.
        versions: name -> version, of packages, simulators and Python.
        suites: name, seed and number of tests of each.
        problems: everything besides requirements that failed the session, a sentence each.
        faults: number of mutants tried; None if none were.
        schedules: number of runs with another schedule; None if there were none.
        changes: differences from the baseline, as a sentence; empty without a baseline.
    """

    testbench: str
    began: str
    revision: str
    code: str
    versions: Mapping[str, str]
    suites: tuple[str, ...]
    engines: tuple[str, ...]
    problems: tuple[str, ...]
    faults: int | None
    schedules: int | None
    changes: str


def facts_of(report: Report) -> SessionFacts:
    """The facts of a session, or of the first session of a merged report."""
    origin = report.origin or next((part.origin for part in report.sessions if part.origin is not None), None)
    mutation, schedules = getattr(report, "mutation", None), getattr(report, "schedules", None)
    return SessionFacts(
        testbench=report.testbench,
        began="" if origin is None else origin.began,
        revision="" if origin is None else origin.revision + "+" * origin.dirty,
        code=report.code_under_test.sha256,
        versions={"pytest-hricdv": report.version, **({} if origin is None else origin.versions), **report.environment},
        suites=tuple(f"{suite.name}, seed {suite.seed}, {suite.tests} tests" for suite in report.suites),
        engines=tuple(sorted({engine for test in report.tests for engine in test.engines})),
        problems=tuple(_problems(report)),
        faults=None if mutation is None else len(mutation.mutants),
        schedules=None if schedules is None else schedules.runs,
        changes=_changes(report),
    )


def _problems(report: Report) -> Iterator[str]:
    if report.not_run:
        yield f"{report.not_run} of {report.selected} tests were not run"
    for test in report.tests:
        if test.fails and not any(map(test.violates, test.requirements)):
            yield f"{test.id}: {test.outcome}, without a violated requirement"
    yield from report.problems
    if report.gates is None:
        yield "no gates were checked: the report is of a shard, or of a session that did not end"
    else:
        yield from report.gates.failed


def _changes(report: Report) -> str:
    changes = report.changes
    if changes is None or changes.against != "baseline":
        return ""
    if not (changes.changed or changes.new or changes.removed):
        return f"this update changed nothing else: all {changes.compared} tests behave as in the baseline"
    parts = [f"{len(changes.changed)} of {changes.compared} tests behave differently from the baseline"]
    parts += [f"{len(names)} {what}" for names, what in ((changes.new, "new"), (changes.removed, "removed")) if names]
    return ", ".join(parts)


def requirements_csv(rows: Sequence[EvidenceRow]) -> str:
    """A line for each requirement."""
    return _csv(
        {
            "id": row.id,
            "title": row.title,
            "source": row.source,
            "status": row.status,
            "passed": row.count("Passed"),
            "failed": row.count("Failed"),
            "not checked": row.not_checked,
            "triggers": row.triggers,
            "undecided": row.pending,
            "margin": row.margin,
            "vacuous alternatives": "; ".join(row.vacuous),
            "mutants detected": row.faults,
            "by nothing else": row.only_faults,
            "conditions": "not measured" if row.conditions is None else "{1} of {0}".format(*row.conditions),
            "open conditions": "; ".join(row.open_conditions),
            "waiver": row.waiver,
            "owner": row.owner,
            "until": row.until,
            "checked by": " ".join(row.checked_by),
        }
        for row in rows
    )


def checks_csv(rows: Sequence[EvidenceRow]) -> str:
    """A line for each test that passed or failed a requirement."""
    return _csv(
        {"requirement": row.id, **{name.replace("_", " "): value for name, value in asdict(check).items()}}
        for row in rows
        for check in row.checks
    )


def _csv(lines: Iterable[Mapping[str, object]]) -> str:
    """A table; the keys of the first line are its header."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    for number, line in enumerate(lines):
        if number == 0:
            writer.writerow(line)
        # Spreadsheets read a text that begins like this as a formula.
        writer.writerow([f"'{cell}" if str(cell)[:1] in tuple("=+@") else cell for cell in line.values()])
    return file.getvalue()


def needs_json(rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """`needs.json` for sphinx-needs (`needimport`): a need for each requirement, with its status."""
    needs = {
        row.id: {
            "id": row.id,
            "type": "req",
            "title": row.title or row.id,
            "content": row.text,
            "status": row.status,
            "tags": [],
            "links": [name for name in row.checked_by if name != row.id],
        }
        for row in rows
    }
    version = facts.revision or "1"
    current = {"needs": needs, "needs_amount": len(needs), "created": facts.began}
    data = {
        "created": facts.began,
        "current_version": version,
        "project": facts.testbench,
        "versions": {version: current},
    }
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


def reqif(rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """A ReqIF file: an object for each requirement, with its id, title, text, status and counts.

    Its header says version 1.0: the schema of ReqIF 1.2 allows no other.
    """
    objects = [
        (row.id, row.title, row.text, row.status,
         f"{row.count('Passed')} passed, {row.count('Failed')} failed, {row.not_checked} not checked")
        for row in rows
    ]  # fmt: skip
    when = facts.began or "1970-01-01T00:00:00Z"
    return standalone(__package__, "requirements.reqif.jinja", when=when, title=facts.testbench, objects=objects)


def statement(files: Mapping[str, bytes], rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """An in-toto statement about these files, with the predicate `test-result`, ready to be signed.

    Source: in-toto attestation framework, Statement v1 and test-result v0.1.
    """
    failed = [row.id for row in rows if row.is_open]
    warned = [row.id for row in rows if not row.is_open and row.status != "satisfied"]
    result = "FAILED" if failed or facts.problems else "WARNED" if warned else "PASSED"
    data = {
        "_type": STATEMENT_TYPE,
        "subject": [{"name": name, "digest": {"sha256": sha256(files[name])}} for name in sorted(files)],
        "predicateType": PREDICATE_TYPE,
        "predicate": {
            "result": result,
            "configuration": [{"name": "code under test", "digest": {"sha256": facts.code}}],
            "passedTests": [row.id for row in rows if row.status == "satisfied"],
            "warnedTests": warned,
            "failedTests": failed,
        },
    }
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


def sha256(data: bytes) -> str:
    """The hash in hexadecimal."""
    return hashlib.sha256(data).hexdigest()
