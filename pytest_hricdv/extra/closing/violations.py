"""Kinds of violations: by requirement and part of it, state of the code under test, and how the interaction ended.

    ("violation", requirement, part, state, outcome)      one that is not known
    ("known violation", requirement, part, state, outcome)
    ("fault", text without numbers)                       what was wrong with a run besides its requirements

As they are points, the archive keeps the shortest run of each kind, and a suite has a test for it.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Container, Iterator, Mapping, Sequence

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.outcome import is_declared
from pytest_hricdv.experiments.failure_signature import failure_signature
from pytest_hricdv.extra.closing.records import ViolationKind
from pytest_hricdv.generate.abstract import disturbance_of
from pytest_hricdv.monitor import Criterion

NEW, KNOWN, FAULT = "violation", "known violation", "fault"
KINDS = (NEW, KNOWN, FAULT)

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def violation_points(
    lines: Sequence[str],
    result: CaseResult,
    *,
    cross: Mapping[str, CrossProduct],
    requirements: Sequence[Criterion],
    known_violations: Container[str],
    state: str = "",
) -> Iterator[Point]:
    """The kinds of a run's violations and faults.

    Args:
        lines: of the test that was run.
        cross, requirements, known_violations, state: as of `pytest_hricdv.extra.closing.observation.observe`.
    """
    states = _StateTimeline(result, state)
    by_id = {requirement.id: requirement for requirement in requirements}
    for verdict in result.verdicts:
        for violation in verdict.violations:
            kind = KNOWN if is_declared(verdict.requirement, known_violations, outside=violation.outside) else NEW
            part = " & ".join(failure_signature(by_id[verdict.requirement], verdict, violation))
            outcome = _interaction(lines, result, violation.time_s, cross)
            yield kind, verdict.requirement, part, states.at(violation.time_s), outcome
    yield from ((FAULT, _NUMBER.sub("#", fault)) for fault in result.errors)


class _StateTimeline:
    """The states that the code under test reported over a run: read once, as a run may have a violation per event."""

    def __init__(self, result: CaseResult, state: str) -> None:
        topic, _, name = state.partition(".")
        said = [message for message in result.record.messages if message.topic == topic]
        self._times_s = [message.time_s for message in said]  # ascending, as they were recorded
        self._names = [str(message.fields[name]) for message in said]

    def at(self, time_s: float) -> str:
        """The state at a time (s); empty if it had named none."""
        count = bisect_right(self._times_s, time_s)
        return self._names[count - 1] if count else ""


def _interaction(lines: Sequence[str], result: CaseResult, time_s: float, cross: Mapping[str, CrossProduct]) -> str:
    """The end of the person's interaction at a time; empty before the first one, and if it did not end.

    Cross products with `planned` tell with which action an interaction begins.
    """
    numbers_begun = result.begun[: bisect_right(result.action_times_s, time_s)]
    begun = [lines[number] for number in numbers_begun]
    commands = [line for line in begun if disturbance_of(line) is None]
    numbers = [len([*product.planned(commands)]) for product in cross.values() if product.planned is not None]
    number = max(numbers, default=0)
    return result.outcome.outcomes[number - 1] if 0 < number <= len(result.outcome.outcomes) else ""


def describe(point: Point, runs: int, test: str) -> ViolationKind:
    """The record of a kind of violations.

    Args:
        point: of the kind.
        runs: that had one.
        test: the id of one that has it.
    """
    if point[0] == FAULT:
        return ViolationKind(requirement="", part=point[1], runs=runs, test=test)
    _, requirement, part, state, outcome = point
    return ViolationKind(
        requirement=requirement,
        part=part,
        state=state,
        outcome=outcome,
        known=point[0] == KNOWN,
        runs=runs,
        test=test,
    )
