"""Rows of evidence: what a report shows for each requirement, including those that nothing checks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import msgspec

from pytest_hricdv._base.record import Count, Names, PlainRecord
from pytest_hricdv.extra.evidence.requirement_lists import ListedRequirement
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.model import Report, TestResult

EvidenceStatus = Literal["satisfied", "violated", "known violation", "not checked", "no evidence"]
"""Satisfied: it passed in a test and failed in none. Known violation: it failed, and a waiver covers each failure.
Not checked: no test triggered and decided it. No evidence: it is in a list, and no requirement of the testbench names
it."""

OPEN: tuple[EvidenceStatus, ...] = ("violated", "not checked", "no evidence")


class CheckRecord(PlainRecord, frozen=True, kw_only=True):
    """The verdict of one test on a requirement.

    Args:
        test: its id.
        suite: of the test.
        seed: of its concrete parameters.
        verdict: Passed, Failed or NC.
        margin: least signed distance to the bound, in the unit of the comparison.
        engine: of physics.
        record_sha256: of the record of its run.
        replay: file that runs it again.
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
    """A requirement and what was shown of it.

    Args:
        id: of the requirement.
        title: for people.
        source: the clause, standard or hazard that it comes from.
        text: the formula that is monitored, or the text of the list.
        status: see `EvidenceStatus`.
        waiver: why a violation is known, or an NC allowed.
        until: last day of the waiver, `YYYY-MM-DD`.
        checks: tests that triggered it, or violated it.
        not_checked: how many tests did not.
        triggers: over all tests.
        pending: triggers that were undecided at the end of a run.
        vacuous: alternatives of its response by which it held in no test.
        faults: mutants of the code that it noticed; None if no mutants were tried.
        only_faults: those that nothing else noticed.
        checked_by: of a listed requirement, those of the testbench that name it.
        conditions: how often each conjunct of its antecedent had to be true and false, and how often some test made it
            so; None if no closing loop ran, which is what counts them.
        open_conditions: the others, as `person_near: false`.
    """

    id: str
    title: str
    source: str = ""
    text: str = ""
    status: EvidenceStatus
    waiver: str = ""
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

    @property
    def owner(self) -> str:
        """The owner of the waiver, which may end with it in brackets."""
        match = re.search(r"\[([^\[\]]*)\]\s*\Z", self.waiver)
        return match[1] if match else ""

    def count(self, verdict: str) -> int:
        """The number of tests with this verdict."""
        return sum(check.verdict == verdict for check in self.checks)

    @property
    def is_open(self) -> bool:
        """Whether something has to be done about it: no waiver says why it may be so."""
        return self.status in OPEN and not self.waiver

    @property
    def margin(self) -> float | None:
        """The least of all tests."""
        return min((check.margin for check in self.checks if check.margin is not None), default=None)


def gather_evidence(report: Report, listed: Sequence[ListedRequirement] = ()) -> tuple[EvidenceRow, ...]:
    """A row for each requirement: first those of the list, in its order, then those of the testbench.

    Args:
        report: of a session, or merged.
        listed: requirements of another tool. One is checked by those of the testbench that have its id, or whose
            source names it.
    """
    mutation: dict[str, Any] = msgspec.to_builtins(getattr(report, "mutation", None)) or {}
    own = {name: _Row(report, mutation.get("assertions", {}), name).make() for name in report.requirements}
    rows = []
    for entry in listed:
        naming = [row for row in own.values() if row.id == entry.id or names(row.source, entry.id)]
        rows.append(_join(entry, naming))
    others = own.keys() - {entry.id for entry in listed}
    return (*rows, *(own[name] for name in sorted(others, key=natural)))


def names(source: str, wanted: str) -> bool:
    """Whether a text names an id: as a word of its own, so that SR-1 is not in SR-12.

    >>> names("ISO 10218-2, SR-1", "SR-1"), names("SR-12", "SR-1"), names("SR-1.2", "SR-1")
    (True, False, False)
    """
    before, found, after = source.partition(wanted)
    if not (wanted and found):
        return False
    is_whole = not before[-1:].isalnum() and not after[:1].isalnum() and before[-1:] not in ("-", ".", "_")
    ends = after[:1] not in ("-", ".", "_") or not after[1:2].isalnum()
    return (is_whole and ends) or names(after, wanted)


def _join(entry: ListedRequirement, naming: Sequence[EvidenceRow]) -> EvidenceRow:
    """The row of a listed requirement, which is as good as the worst of those that check it."""
    if not naming:
        return EvidenceRow(id=entry.id, title=entry.title, text=entry.text, source=entry.source, status="no evidence")
    order: tuple[EvidenceStatus, ...] = ("violated", "not checked", "known violation", "satisfied")
    worst = min(naming, key=lambda row: (order.index(row.status), not row.is_open))
    return EvidenceRow(
        id=entry.id,
        title=entry.title or worst.title,
        source=entry.source or worst.source,
        text=entry.text or worst.text,
        status=worst.status,
        waiver=worst.waiver,
        until=worst.until,
        checks=tuple(check for row in naming for check in row.checks),
        not_checked=sum(row.not_checked for row in naming),
        triggers=sum(row.triggers for row in naming),
        pending=sum(row.pending for row in naming),
        vacuous=tuple(text for row in naming for text in row.vacuous),
        faults=_sum(row.faults for row in naming),
        only_faults=_sum(row.only_faults for row in naming),
        checked_by=tuple(row.id for row in naming),
        conditions=_add_up(row.conditions for row in naming),
        open_conditions=tuple(text for row in naming for text in row.open_conditions),
    )


def _add_up(counts: Iterable[tuple[int, int] | None]) -> tuple[int, int] | None:
    known = [count for count in counts if count is not None]
    return (sum(wanted for wanted, _ in known), sum(done for _, done in known)) if known else None


def _sum(counts: Iterator[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return sum(known) if known else None


@dataclass(frozen=True)
class _Row:
    """Makes the row of a requirement of the testbench.

    Args:
        report: of the tests.
        scores: oracle -> its score with mutants.
        name: id of the requirement.
    """

    report: Report
    scores: Mapping[str, Mapping[str, int]]
    name: str

    def make(self) -> EvidenceRow:
        """The row."""
        text, tallies = self.report.requirements[self.name], self._tallies()
        status, waiver, until = self._status()
        score = self.scores.get(self.name)
        held = [set(tally.vacuous_alternatives) for tally in tallies if tally.triggers]
        return EvidenceRow(
            id=self.name,
            title=text.title,
            source=text.source,
            text=text.text,
            status=status,
            waiver=waiver,
            until=until,
            checks=tuple(self._checks()),
            not_checked=sum(tally.nc for tally in tallies),
            triggers=sum(tally.triggers for tally in tallies),
            pending=sum(tally.pending for tally in tallies),
            vacuous=tuple(sorted(set.intersection(*held))) if held else (),
            faults=None if score is None else score["killed"],
            only_faults=None if score is None else score["killed_only_by"],
            conditions=self._conditions(),
            open_conditions=tuple(f"{name}: {value}" for name, value in self._points("open")),
        )

    def _conditions(self) -> tuple[int, int] | None:
        hit, left = len(self._points("hit")), len(self._points("open"))
        return (hit + left, hit) if hit + left else None

    def _points(self, kind: str) -> list[tuple[str, str]]:
        """Conjuncts and their truths that a closing loop has hit, or left open."""
        closing = getattr(self.report, "closing", None)
        points = [entry.point for entry in getattr(closing, kind, ())]
        return [(point[2], point[3]) for point in points if point[:2] == ("condition", self.name)]

    def _tallies(self) -> list[Any]:
        return [suite.requirements[self.name] for suite in self.report.suites if self.name in suite.requirements]

    def _runs(self) -> Iterator[TestResult]:
        for test in self.report.tests:
            yield from (run for run in test.runs if self.name in run.requirements)

    def _checks(self) -> Iterator[CheckRecord]:
        for run in self._runs():
            result = run.requirements[self.name]
            if result.verdict != "NC":
                yield CheckRecord(
                    test=run.id,
                    suite=run.suite,
                    seed=run.seed,
                    verdict=result.verdict,
                    margin=result.margin,
                    engine=run.engine,
                    record_sha256=run.record_sha256,
                    replay=run.replay,
                )

    def _status(self) -> tuple[EvidenceStatus, str, str]:
        report, name = self.report, self.name
        results = [run.requirements[name] for run in self._runs()]
        failed = [result for result in results if result.verdict == "Failed"]
        if failed:
            is_known = name in report.known_violations and not report.strict
            if is_known and (name not in report.known_when or not any(result.outside for result in failed)):
                return "known violation", report.known_violations[name], report.known_until.get(name, "")
            return "violated", "", ""
        if any(result.verdict == "Passed" for result in results):
            return "satisfied", "", ""
        exemption = report.allowed_untriggered.get(name)
        return "not checked", *(("", "") if exemption is None else (exemption.reason, exemption.until))
