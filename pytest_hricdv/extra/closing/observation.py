"""`observe`: the points that a run hits, how each interaction ended, and how close it came to other points.

The process of a closing loop (`process`) calls it after each run and sends the `RunObservation` to the session. A
point is a tuple of strings that begins with its kind (see `pytest_hricdv.coverage.closure.Point`):

    ("statement", file, line)  ("branch", file, line, line)  ("plan", agent, label)  ("bin", cross product, *bin)
    ("verdict", requirement, "Passed" | "Failed")            ("antecedent", requirement, "true" | "false")
    ("condition", requirement, conjunct of its antecedent, "true" | "false")
    ("transition", state of the code under test, next state)

and kinds of violations, by requirement and part of it, state of the code under test, and how the interaction ended:

    ("violation", requirement, part, state, outcome)      one that is not known
    ("known violation", requirement, part, state, outcome)
    ("fault", text without numbers)                       what was wrong with a run besides its requirements

As they are points, the archive keeps the shortest run of each kind, and a suite has a test for it.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import msgspec

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.judge import list_undeclared_violations
from pytest_hricdv.execution.outcome import is_declared
from pytest_hricdv.execution.run_monitors import log_of
from pytest_hricdv.experiments.failure_signature import failure_signature
from pytest_hricdv.extra.closing.records import ViolationKind
from pytest_hricdv.generate.abstract import AbstractTest, disturbance_of
from pytest_hricdv.monitor import Criterion, NearMiss, Requirement, Verdict
from pytest_hricdv.monitor.antecedent import conjunct_outcomes

NEW, KNOWN, FAULT = "violation", "known violation", "fault"
KINDS = (NEW, KNOWN, FAULT)
"""The kinds of points that say what was wrong with a run."""

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
        lines: the lines of the test that was run.
        cross, requirements, known_violations, state: as of `observe`.
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
    """The states that the code under test reported in a run: read once, as each event may be a violation."""

    def __init__(self, result: CaseResult, state: str) -> None:
        topic, _, name = state.partition(".")
        messages = [message for message in result.record.messages if message.topic == topic]
        self._times_s = [message.time_s for message in messages]  # ascending, as they were recorded
        self._names = [str(message.fields[name]) for message in messages]

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
        point: a point of this kind.
        runs: number of runs that had one.
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


class RunObservation(msgspec.Struct, frozen=True):
    """The observations of one run.

    Args:
        test: the test that was run, as `AbstractTest.to_data` gives it.
        points: the points that it hits, sorted.
        hits: cross product -> the bins of its interactions, in their order.
        distances: (a point that it does not hit, how far it was from it); 0 is a hit, and points are compared with
            themselves only.
        near_misses: requirement that nothing triggered -> when it was nearest to that, and what was false then.
        margins: requirement -> its least margin, where something was compared.
        unused: requirement that was triggered -> the alternatives of its response by which it never held.
        sim_s: simulated time (s).
        record_sha256: SHA-256 of its record.
        failed: requirements that it violates and that are not known to fail; then its faults.
        begun: where there are several actors: its actions as they began, by their numbers from 0.
        error: why it did not end; empty if it did. Then it hits nothing.
    """

    test: dict[str, Any]
    points: tuple[Point, ...] = ()
    hits: dict[str, tuple[Bin, ...]] = {}
    distances: tuple[tuple[Point, float], ...] = ()
    near_misses: dict[str, NearMiss] = {}
    margins: dict[str, float] = {}
    unused: dict[str, tuple[str, ...]] = {}
    sim_s: float = 0.0
    record_sha256: str = ""
    failed: tuple[str, ...] = ()
    begun: tuple[int, ...] = ()
    error: str = ""


def observe(
    test: AbstractTest,
    result: CaseResult,
    *,
    code: CodeMap,
    cross: Mapping[str, CrossProduct],
    requirements: Sequence[Criterion],
    known_violations: Container[str],
    state: str = "",
) -> RunObservation:
    """Observe a run.

    Args:
        test: the test that was run.
        code: the code under test.
        cross: the cross products of the testbench.
        requirements: the requirements that the run was judged by.
        known_violations: the requirements that are known to fail.
        state: the field that names the state of the code under test (see `Testbench`).
    """
    points = {*code_points(code, result.code), *plan_points(test), *_bin_points(result, cross)}
    points.update(_requirement_points(result))
    points.update(_condition_points(result, requirements))
    points.update(_transition_points(result, state))
    points.update(
        violation_points(
            test.lines, result, cross=cross, requirements=requirements, known_violations=known_violations, state=state
        )
    )
    return RunObservation(
        test=test.to_data(),
        points=tuple(sorted(points)),
        hits={name: tuple(tuple(bin_) for bin_ in hits) for name, hits in result.outcome.cross.items()},
        distances=tuple(_distances(result.verdicts)),
        near_misses={verdict.requirement: verdict.near_miss for verdict in result.verdicts if verdict.near_miss},
        margins={verdict.requirement: verdict.margin for verdict in result.verdicts if verdict.margin is not None},
        unused={verdict.requirement: verdict.vacuous_alternatives for verdict in result.verdicts if verdict.triggers},
        sim_s=result.sim_s,
        record_sha256=result.record.sha256,
        failed=(*list_undeclared_violations(result, known_violations), *result.errors),
        begun=result.begun if result.test.actors else (),
    )


def code_points(code: CodeMap, bits: Bits | None) -> Iterator[Point]:
    """The statements and branches of a set of bits."""
    if bits is None:
        return
    statement = branch = 0
    for file in code.files:
        for place, line in enumerate(file.statements, statement):
            if bits.statements >> place & 1:
                yield "statement", file.name, str(line)
        for place, (begin, end) in enumerate(file.branches, branch):
            if (bits.branches or 0) >> place & 1:
                yield "branch", file.name, str(begin), str(end)
        statement += len(file.statements)
        branch += len(file.branches)


def plan_points(test: AbstractTest) -> Iterator[Point]:
    """The plans that the model executed for a test."""
    for agent, labels in test.plans.items():
        yield from (("plan", agent, label) for label in labels)


def _bin_points(result: CaseResult, cross: Mapping[str, CrossProduct]) -> Iterator[Point]:
    for name, hits in result.cross.items():
        yield from (("bin", name, *hit) for hit in hits if hit not in cross[name].forbidden)


def _requirement_points(result: CaseResult) -> Iterator[Point]:
    for verdict in result.verdicts:
        name = verdict.requirement
        yield "antecedent", name, "true" if verdict.triggers else "false"
        if verdict.verdict != "NC":
            yield "verdict", name, verdict.verdict


def _condition_points(result: CaseResult, requirements: Iterable[Criterion]) -> Iterator[Point]:
    log = log_of(result.record, result.sim_s)
    for requirement in requirements:
        if isinstance(requirement, Requirement):
            for text, outcomes in conjunct_outcomes(requirement.formula.antecedent, log).items():
                yield from (("condition", requirement.id, text, str(outcome).lower()) for outcome in outcomes)


def _transition_points(result: CaseResult, state: str) -> Iterator[Point]:
    topic, _, name = state.partition(".")
    states = [str(message.fields[name]) for message in result.record.messages if message.topic == topic]
    yield from (("transition", *step) for step in pairwise(states))


def _distances(verdicts: Sequence[Verdict]) -> Iterator[tuple[Point, float]]:
    for verdict in verdicts:
        miss = verdict.near_miss
        if miss is not None:
            yield ("verdict", verdict.requirement, "Passed"), _distance(miss)
            yield from ((("condition", verdict.requirement, text, "true"), _distance(miss)) for text in miss.missing)


def _distance(miss: NearMiss) -> float:
    """The number of conditions that were false; of a single one that compares numbers, how far it was, below 1."""
    if len(miss.missing) == 1 and miss.distance is not None:
        return abs(miss.distance) / (1.0 + abs(miss.distance))
    return float(len(miss.missing))
