"""The files of evidence: tables for people and tools, ReqIF and `needs.json` with results, and an in-toto statement."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from xml.sax.saxutils import escape, quoteattr

from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.extra.evidence.rows import EvidenceRow
from pytest_hricdv.results.model import Report

STATEMENT = "statement.json"
"""The in-toto statement, which names all other files with their hashes."""

STATEMENT_TYPE = "https://in-toto.io/Statement/v1"
PREDICATE_TYPE = "https://in-toto.io/attestation/test-result/v0.1"


class SessionFacts(PlainRecord, frozen=True, kw_only=True):
    """Facts about the session of the tests.

    Args:
        testbench: its name.
        began: date and time (UTC).
        revision: of the project, `+` behind it where tracked files differed.
        code: SHA-256 of the code under test.
        versions: name -> version, of what runs, measures and simulates.
        suites: name, seed and number of tests of each.
        engines: of physics.
        problems: what else failed, so that it is no evidence of a whole session, a sentence each.
        faults: how many mutants were tried; None for no mutants.
        schedules: how many runs had another schedule; None for none.
        changes: what behaves differently from the baseline, as a sentence; empty if there is none to compare with.
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
            yield f"{test.id}: {test.outcome}, and no requirement says why"
    yield from report.problems
    if report.gates is None:
        yield "no gates were checked: it is a part of a session, or one that did not end"
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
            "mutants noticed": row.faults,
            "by nothing else": row.only_faults,
            "conditions": "" if row.conditions is None else f"{row.conditions[1]} of {row.conditions[0]}",
            "open conditions": "; ".join(row.open_conditions),
            "waiver": row.waiver,
            "owner": row.owner,
            "until": row.until,
            "checked by": " ".join(row.checked_by),
        }
        for row in rows
    )


def checks_csv(rows: Sequence[EvidenceRow]) -> str:
    """A line for each verdict that is not NC."""
    return _csv(
        {
            "requirement": row.id,
            "test": check.test,
            "suite": check.suite,
            "seed": check.seed,
            "verdict": check.verdict,
            "margin": check.margin,
            "engine": check.engine,
            "record sha256": check.record_sha256,
            "replay": check.replay,
        }
        for row in rows
        for check in row.checks
    )


def _csv(lines: Iterable[Mapping[str, object]]) -> str:
    """A table with the keys of the first line as its head."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    for number, line in enumerate(lines):
        if number == 0:
            writer.writerow(line)
        # A spreadsheet takes a text that begins so for a formula.
        writer.writerow([f"'{cell}" if str(cell)[:1] in tuple("=+@") else cell for cell in line.values()])
    return file.getvalue()


def needs_json(rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """`needs.json` for sphinx-needs (`needimport`): a need for each requirement, with its status and checks."""
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


_COLUMNS = ("ReqIF.ForeignID", "ReqIF.Name", "ReqIF.Text", "Status", "Evidence")


def reqif(rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """A ReqIF file: an object for each requirement, with its id, title, text, status and counts.

    Its header has the version 1.0, which is the only one in the schema of ReqIF 1.2, too.
    """
    when = facts.began if facts.began else "1970-01-01T00:00:00Z"
    stamp = f'LAST-CHANGE="{when}"'
    definitions = "".join(
        f'<ATTRIBUTE-DEFINITION-STRING IDENTIFIER="a{number}" {stamp} LONG-NAME="{name}"><TYPE>'
        "<DATATYPE-DEFINITION-STRING-REF>text</DATATYPE-DEFINITION-STRING-REF></TYPE></ATTRIBUTE-DEFINITION-STRING>"
        for number, name in enumerate(_COLUMNS)
    )
    objects = "".join(_reqif_object(number, row, stamp) for number, row in enumerate(rows))
    places = "".join(
        f'<SPEC-HIERARCHY IDENTIFIER="h{number}" {stamp}><OBJECT><SPEC-OBJECT-REF>o{number}</SPEC-OBJECT-REF></OBJECT>'
        "</SPEC-HIERARCHY>"
        for number in range(len(rows))
    )
    title = escape(facts.testbench)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<REQ-IF xmlns="http://www.omg.org/spec/ReqIF/20110401/reqif.xsd">
<THE-HEADER><REQ-IF-HEADER IDENTIFIER="header"><CREATION-TIME>{when}</CREATION-TIME><REQ-IF-TOOL-ID>pytest-hricdv\
</REQ-IF-TOOL-ID><REQ-IF-VERSION>1.0</REQ-IF-VERSION><SOURCE-TOOL-ID>pytest-hricdv</SOURCE-TOOL-ID><TITLE>{title}\
</TITLE></REQ-IF-HEADER></THE-HEADER>
<CORE-CONTENT><REQ-IF-CONTENT>
<DATATYPES><DATATYPE-DEFINITION-STRING IDENTIFIER="text" {stamp} LONG-NAME="text" MAX-LENGTH="1000000"/></DATATYPES>
<SPEC-TYPES><SPEC-OBJECT-TYPE IDENTIFIER="requirement" {stamp} LONG-NAME="Requirement"><SPEC-ATTRIBUTES>{definitions}\
</SPEC-ATTRIBUTES></SPEC-OBJECT-TYPE><SPECIFICATION-TYPE IDENTIFIER="list" {stamp} LONG-NAME="List"/></SPEC-TYPES>
<SPEC-OBJECTS>{objects}</SPEC-OBJECTS>
<SPECIFICATIONS><SPECIFICATION IDENTIFIER="all" {stamp} LONG-NAME="Evidence"><TYPE><SPECIFICATION-TYPE-REF>list\
</SPECIFICATION-TYPE-REF></TYPE><CHILDREN>{places}</CHILDREN></SPECIFICATION></SPECIFICATIONS>
</REQ-IF-CONTENT></CORE-CONTENT>
</REQ-IF>
"""


def _reqif_object(number: int, row: EvidenceRow, stamp: str) -> str:
    counts = f"{row.count('Passed')} passed, {row.count('Failed')} failed, {row.not_checked} not checked"
    values = "".join(
        f"<ATTRIBUTE-VALUE-STRING THE-VALUE={quoteattr(_printable(value))}><DEFINITION>"
        f"<ATTRIBUTE-DEFINITION-STRING-REF>a{column}</ATTRIBUTE-DEFINITION-STRING-REF></DEFINITION>"
        "</ATTRIBUTE-VALUE-STRING>"
        for column, value in enumerate((row.id, row.title, row.text, row.status, counts))
    )
    return (
        f'<SPEC-OBJECT IDENTIFIER="o{number}" {stamp}><TYPE><SPEC-OBJECT-TYPE-REF>requirement</SPEC-OBJECT-TYPE-REF>'
        f"</TYPE><VALUES>{values}</VALUES></SPEC-OBJECT>\n"
    )


def _printable(text: str) -> str:
    """The text without control characters, which XML lacks."""
    return "".join(letter for letter in text if letter >= " " or letter in "\t\n")


def statement(files: Mapping[str, bytes], rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """An in-toto statement about these files, with the predicate `test-result`; it can be signed.

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
