"""`gather_evidence`: rows with what a report shows for each requirement, including those that nothing checks.

`folder` calls it to write evidence and to verify it. An `EvidenceRow` has a `CheckRecord` for each test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal

from pytest_hricdv._base.record import Count, Names, PlainRecord
from pytest_hricdv.coverage.suite_coverage import list_vacuous_alternatives
from pytest_hricdv.extra.evidence.requirement_lists import ListedRequirement
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.report.totals import find_xfail_reason, is_tolerated
from pytest_hricdv.report.waivers_view import split_owner
from pytest_hricdv.results.model import Report, TestResult

EvidenceStatus = Literal["satisfied", "violated", "known violation", "not checked", "no evidence"]
"""Satisfied: the requirement passed in a test and failed in none. Known violation: it failed, and a waiver covers each
failure. Not checked: no test triggered and decided it. No evidence: it is in a list of requirements, and no requirement
of the testbench names it."""

OPEN: tuple[EvidenceStatus, ...] = ("violated", "not checked", "no evidence")
"""A requirement with one of these is open, unless it has a waiver."""
_WORST_FIRST: tuple[EvidenceStatus, ...] = ("violated", "not checked", "known violation", "satisfied")


class CheckRecord(PlainRecord, frozen=True, kw_only=True):
    """The verdict of one test on a requirement.

    Args:
        seed: the seed of its concrete parameters.
        verdict: Passed or Failed.
        margin: smallest signed distance to the bound, in the unit of the comparison.
        record_sha256: SHA-256 of the record of its run.
        replay: file that repeats it.
    """

    test: str
    suite: str
    seed: int
    verdict: str
    margin: float | None = None
    engine: str = ""
    record_sha256: str | None = None
    replay: str | None = None


class EvidenceRow(PlainRecord, frozen=True, kw_only=True):
    """A requirement and what was shown for it.

    Args:
        title: for people.
        source: the clause, standard or hazard that it comes from.
        text: the formula that is monitored, or the text of the list.
        waiver: why a violation is known, or an NC is allowed.
        owner: the owner of the waiver.
        until: last day of the waiver, `YYYY-MM-DD`.
        checks: tests that passed or failed it.
        not_checked: number of the other tests.
        triggers: over all tests.
        pending: triggers that were undecided at the end of a run.
        vacuous: alternatives of its response by which it held in no test.
        faults: mutants of the code that it detected; None if none were tried.
        only_faults: those that nothing else detected.
        checked_by: for a listed requirement, those of the testbench that name it.
        conditions: number of truth values that the conjuncts of its antecedent can have, and of those that a test gave
            them; None if they were not measured, which only a closing loop does.
        open_conditions: the values that no test gave them, as `person_near: false`.
    """

    id: str
    title: str
    source: str = ""
    text: str = ""
    status: EvidenceStatus
    waiver: str = ""
    owner: str = ""
    until: str = ""
    checks: tuple[CheckRecord, ...] = ()
    not_checked: Count = 0
    triggers: Count = 0
    pending: Count = 0
    vacuous: Names = ()
    faults: Count | None = None
    only_faults: Count | None = None
    checked_by: Names = ()
    conditions: tuple[Count, Count] | None = None
    open_conditions: Names = ()

    def count(self, verdict: str) -> int:
        """The number of tests with this verdict."""
        return sum(check.verdict == verdict for check in self.checks)

    @property
    def is_open(self) -> bool:
        """Whether something is left to do: there is no evidence, and no waiver."""
        return self.status in OPEN and not self.waiver

    @property
    def margin(self) -> float | None:
        """The least margin of all tests."""
        return min((check.margin for check in self.checks if check.margin is not None), default=None)


def gather_evidence(report: Report, listed: Sequence[ListedRequirement] = ()) -> tuple[EvidenceRow, ...]:
    """A row for each requirement: first those of the list, in its order, then those of the testbench.

    Args:
        report: the report of a session, or merged.
        listed: requirements of another tool. Each is checked by the requirements of the testbench that have its id, or
            whose source names it.
    """
    rows = []
    for entry in listed:
        checking = [
            name for name, text in report.requirements.items() if name == entry.id or names(text.source, entry.id)
        ]
        rows.append(_row(report, entry, checking, tuple(checking)))
    others = sorted(report.requirements.keys() - {entry.id for entry in listed}, key=natural)
    return (*rows, *(_row(report, ListedRequirement(id=name), [name]) for name in others))


def names(source: str, wanted: str) -> bool:
    """Whether a text names an id as a whole word: SR-1 is not in SR-12.

    >>> names("ISO 10218-2, SR-1", "SR-1"), names("SR-12", "SR-1"), names("SR-1.2", "SR-1")
    (True, False, False)
    """
    before, found, after = source.partition(wanted)
    if not (wanted and found):
        return False
    is_whole = not before[-1:].isalnum() and not after[:1].isalnum() and before[-1:] not in ("-", ".", "_")
    ends = after[:1] not in ("-", ".", "_") or not after[1:2].isalnum()
    return (is_whole and ends) or names(after, wanted)


def _row(report: Report, entry: ListedRequirement, checking: Sequence[str], checked_by: Names = ()) -> EvidenceRow:
    """The row of a requirement; its status is the worst of the requirements of the testbench that check it."""
    if not checking:
        return EvidenceRow(id=entry.id, title=entry.title, text=entry.text, source=entry.source, status="no evidence")
    states = [(*_state(report, name), report.requirements[name]) for name in checking]
    status, waiver, until, text = min(states, key=lambda state: (_WORST_FIRST.index(state[0]), state[1] != ""))
    reason, owner = split_owner(waiver)
    return EvidenceRow(
        id=entry.id,
        title=entry.title or text.title,
        source=entry.source or text.source,
        text=entry.text or text.text,
        status=status,
        waiver=reason,
        owner=owner,
        until=until,
        checked_by=checked_by,
        **_verdicts(report, checking),
        **_faults(report, checking),
        **_conditions(report, checking),
    )


def _results(report: Report, name: str) -> Iterator[tuple[TestResult, RequirementResult]]:
    """The runs that a requirement judged, each with its result."""
    for test in report.tests:
        yield from ((run, run.requirements[name]) for run in test.runs if name in run.requirements)


def _state(report: Report, name: str) -> tuple[EvidenceStatus, str, str]:
    """Status of a requirement, its waiver and the last day of that."""
    verdicts = {result.verdict for _, result in _results(report, name)}
    if "Failed" in verdicts:
        failed = (run for run, result in _results(report, name) if result.verdict == "Failed")
        if all(is_tolerated(report, name, run) for run in failed):
            return "known violation", find_xfail_reason(report, name), report.known_until.get(name, "")
        return "violated", "", ""
    if "Passed" in verdicts:
        return "satisfied", "", ""
    exemption = report.allowed_untriggered.get(name)
    return "not checked", *(("", "") if exemption is None else (exemption.reason, exemption.until))


def _verdicts(report: Report, checking: Sequence[str]) -> dict[str, Any]:
    """The tests that checked requirements, and how often these were triggered."""
    results = [pair for name in checking for pair in _results(report, name)]
    unused = [list_vacuous_alternatives(result for _, result in _results(report, name)) for name in checking]
    return {
        "checks": tuple(_check(run, result) for run, result in results if result.verdict != "NC"),
        "not_checked": sum(result.verdict == "NC" for _, result in results),
        "triggers": sum(result.triggers for _, result in results),
        "pending": sum(result.pending for _, result in results),
        "vacuous": tuple(text for texts in unused for text in sorted(texts)),
    }


def _check(run: TestResult, result: RequirementResult) -> CheckRecord:
    return CheckRecord(
        test=run.id,
        suite=run.suite,
        seed=run.seed,
        verdict=result.verdict,
        margin=result.margin,
        engine=run.engine,
        record_sha256=run.record_sha256,
        replay=run.replay,
    )


def _faults(report: Report, checking: Sequence[str]) -> dict[str, Any]:
    """The mutants that requirements detected."""
    scores = getattr(getattr(report, "mutation", None), "assertions", {})
    found = [scores[name] for name in checking if name in scores]
    if not found:
        return {}
    return {
        "faults": sum(score.killed for score in found),
        "only_faults": sum(score.killed_only_by for score in found),
    }


def _conditions(report: Report, checking: Sequence[str]) -> dict[str, Any]:
    """The truth values of conjuncts that a closing loop has seen, and those that it has not."""
    closing = getattr(report, "closing", None)
    seen, missing = (
        [f"{entry.point[2]}: {entry.point[3]}" for entry in getattr(closing, kind, ())
         if entry.point[0] == "condition" and entry.point[1] in checking]
        for kind in ("hit", "open")
    )  # fmt: skip
    if not (seen or missing):
        return {}
    return {"conditions": (len(seen) + len(missing), len(seen)), "open_conditions": tuple(missing)}
