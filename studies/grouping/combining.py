"""Faults, alone and two at once, and whether a session with them names as many causes."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from pytest_hricdv.extra.diagnosis.failures import failures_of
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence
from pytest_hricdv.extra.diagnosis.records import CAUSES
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.results.model import Report
from studies.localization.faults import Fault

Failing = frozenset[tuple[str, str, str]]
"""Of what fails and is not known: node id, requirement, and what was said where no formula says it."""


@dataclass(frozen=True)
class Counted:
    """What a session with faults came to.

    Args:
        faults: their ids.
        failing: what fails.
        causes: what fails for each cause: ids of tests, and requirements.
    """

    faults: tuple[str, ...]
    failing: Failing
    causes: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]

    @property
    def is_right(self) -> bool:
        """As many causes as faults."""
        return len(self.causes) == len(self.faults)


def counted(faults: Sequence[Fault], report: Report) -> Counted:
    """The causes of a report that are not known; of a session without a diagnosis those by association alone."""
    causes = tuple((cause.tests, cause.requirements) for cause in CAUSES.of(report) if not cause.is_known)
    groups = (
        [] if causes else [group for group in Subject.of(report).groups(ExperimentEvidence()) if not group.is_known]
    )
    return Counted(
        tuple(fault.id for fault in faults),
        frozenset(_failing(report)),
        causes or tuple((group.nodeids, group.requirements) for group in groups),
    )


def _failing(report: Report) -> Iterator[tuple[str, str, str]]:
    for test in report.tests:
        for failure in failures_of(test, report.state, report.known_violations):
            if not failure.is_known:
                yield failure.nodeid, failure.requirement, failure.said


def both_show(first: Failing, second: Failing, together: Failing) -> bool:
    """Whether something fails for each fault alone: where one hides the other, nobody can see two causes."""
    return bool((first - second) & together) and bool((second - first) & together)


def combined(first: Fault, second: Fault) -> tuple[Fault, ...]:
    """Both faults at once; nothing where they change the same lines, or lines next to each other."""
    if first.file != second.file:
        return first, second
    before = first.before.splitlines(keepends=True)
    changes = [*_changes(before, first), *_changes(before, second)]
    if not _are_apart(changes):
        return ()
    for begin, end, lines in sorted(changes, reverse=True):
        before[begin:end] = lines
    return (Fault(f"{first.id}+{second.id}", "both", first.file, first.before, "".join(before)),)


_Change = tuple[int, int, list[str]]


def _changes(before: Sequence[str], fault: Fault) -> Iterator[_Change]:
    after = fault.text.splitlines(keepends=True)
    for tag, begin, end, begin_after, end_after in difflib.SequenceMatcher(None, before, after, False).get_opcodes():
        if tag != "equal":
            yield begin, end, after[begin_after:end_after]


def _are_apart(changes: Collection[_Change]) -> bool:
    ordered = sorted(changes)
    return all(end < begin for (_, end, _), (begin, _, _) in pairwise(ordered))
