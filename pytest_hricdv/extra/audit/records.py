"""Records of the audit in a report: which tests ran again, which of them differed (`Unrepeatable`), and why.

`Auditor` makes them; `sentence` puts one into words, for the terminal and the report.
"""

from __future__ import annotations

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord
from pytest_hricdv.results.section import Section, TestSection


class Unrepeatable(PlainRecord, frozen=True, kw_only=True):
    """How a test gave another result when it reran.

    Args:
        cause: in words: "state that ... leaves", "hash order", "random numbers", ...; "not found" where no experiment
            showed it.
        detail: a sentence on the cause: which experiment showed it, and where it is in the code.
        left_by: node id of the test that left what makes the difference; empty for other causes.
        outcome_alone: the outcome alone, in a fresh process; "none" if it had none.
        in_session: the first event that differs, in the session.
        alone: the same, alone.
        hash_seed: the hash seed of the fresh process.
        is_violation_unconfirmed: whether it failed in the session, and not so alone: what it violated is not counted.
    """

    cause: str
    detail: str
    left_by: str = ""
    outcome: str
    outcome_alone: str
    in_session: str
    alone: str
    hash_seed: str
    is_violation_unconfirmed: bool = False


def sentence(record: Unrepeatable) -> str:
    """The sentence on a test that does not repeat, after its id."""
    if record.is_violation_unconfirmed:
        alone = {"passed": "passes alone", "none": "leaves no result alone"}.get(
            record.outcome_alone, f"{record.outcome_alone} alone, and for something else"
        )
        begin = f"is not repeatable: {alone}"
    else:
        begin = "is not repeatable: alone in a fresh process, its run differs"
    events = f"; first difference: {record.in_session} in the session, {record.alone} alone" if record.alone else ""
    return f"{begin}; cause: {record.cause} ({record.detail}){events}"


class AuditResult(PlainRecord, frozen=True, kw_only=True):
    """The result of an audit.

    Args:
        tests: node ids of the tests that ran again, in order.
        differing: those that gave another result.
        hash_seed: the hash seed of the fresh process, and that of the session's own or "random".
        runs: how many runs it took, with all experiments.
        problem: why it was not done, or not to its end.
    """

    tests: Names = ()
    differing: Names = ()
    hash_seed: str = ""
    session_hash_seed: str = ""
    runs: Count = 0
    wall_s: NotNegative = 0.0
    problem: str = ""


AUDIT: Section[AuditResult | None] = Section("audit", AuditResult | None, None)
"""The result of a session that audited; a merged report has the differences of its tests."""

UNREPEATABLE: TestSection[Unrepeatable | None] = TestSection("unrepeatable", Unrepeatable | None, None)
"""The difference of a test that gave another result when it reran."""

SECTIONS = (AUDIT,)
TEST_SECTIONS = (UNREPEATABLE,)
