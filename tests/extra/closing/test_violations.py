"""Kinds of violations: what tells them apart, and what does not."""

from __future__ import annotations

from array import array
from collections.abc import Container, Sequence
from itertools import pairwise

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.closing.observation import describe, violation_points
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Requirement, Vocabulary, parse_formula
from pytest_hricdv.monitor.verdict import Verdict, Violation
from pytest_hricdv.runtime import Record, RecordedMessage
from pytest_hricdv.testbench import Outcome
from tests.steps import steps_of


def _planned(lines: Sequence[str]) -> list[Bin]:
    begins = [place for place, line in enumerate(lines) if line == "ask"]
    parts = [lines[begin:end] for begin, end in pairwise([*begins, len(lines)])]
    return [("slow" if "wait" in part else "quick",) for part in parts]


CROSS = {
    "handover": CrossProduct({"pace": ("quick", "slow"), "outcome": ("given", "kept")}, planned=_planned),
    "decision": CrossProduct({"outcome": ("given", "kept")}),
}
VOCABULARY = Vocabulary(signals={"moving": bool, "speed": float, "force": float})
FORMULA = "always(moving -> speed < 1 & force < 5)"
R1 = Requirement("R1", "", "", FORMULA, parse_formula(FORMULA, VOCABULARY))
LINES = ("disturb dark", "ask", "wait", "disturb noise", "ask")
ACTION_TIMES_S = (0.5, 1.0, 3.0, 5.0, 6.0)
STATES = ((0.0, "Idle"), (2.0, "Fetch"), (6.5, "Offer"))


def violation(time_s: float, speed: float = 2.0, force: float = 0.0, *, outside: bool = False) -> Violation:
    """Of R1."""
    return Violation(time_s, time_s, {"speed": speed, "force": force}, -1.0, outside=outside)


def points(
    *violations: Violation,
    states: Sequence[tuple[float, str]] = STATES,
    known_violations: Container[str] = (),
    state: str = "state.name",
    faults: tuple[str, ...] = (),
) -> list[Point]:
    """The kinds of the violations of a run with two interactions: the first was given, the second kept."""
    count = len(violations)
    result = CaseResult(
        test=ConcreteTest("t", "s", 1, ()),
        outcome=Outcome("done", ("given", "kept")),
        record=Record(
            tuple(RecordedMessage(time_s, "robot", "state", {"name": name}) for time_s, name in states),
            {"speed": (array("d"), array("d"))},
            "hash",
        ),
        sim_s=9.0,
        verdicts=(
            Verdict(
                requirement="R1",
                verdict="Failed",
                triggers=count,
                passes=0,
                failures=count,
                untriggered=0,
                pending=0,
                violations=violations,
                margin=-1.0,
                margin_time_s=None,
            ),
        ),
        code=None,
        action_times_s=ACTION_TIMES_S,
        begun=tuple(range(len(ACTION_TIMES_S))),
        ending_faults=faults,
    )
    kinds = violation_points(
        LINES, result, cross=CROSS, requirements=(R1,), known_violations=known_violations, state=state
    )
    return list(kinds)


def test_parts_of_a_requirement_states_and_outcomes_of_interactions_are_kept_apart() -> None:
    assert points(violation(3.5), violation(3.5, force=6.0), violation(5.5), violation(7.0)) == [
        ("violation", "R1", "speed < 1", "Fetch", "given"),
        ("violation", "R1", "speed < 1 & force < 5", "Fetch", "given"),
        ("violation", "R1", "speed < 1", "Fetch", "given"),
        ("violation", "R1", "speed < 1", "Offer", "kept"),
    ]


def test_before_the_first_interaction_there_is_no_outcome_and_without_a_named_state_no_state() -> None:
    assert points(violation(0.7)) == [("violation", "R1", "speed < 1", "Idle", "")]
    assert points(violation(3.5), state="") == [("violation", "R1", "speed < 1", "", "given")]


def test_times_and_values_do_not_tell_violations_apart() -> None:
    assert len(set(points(violation(3.5, 2.0), violation(4.5, 9.0)))) == 1


def test_a_known_violation_is_of_its_own_kind_unless_it_is_outside_of_its_condition() -> None:
    kinds = [point[0] for point in points(violation(3.5), violation(3.5, outside=True), known_violations={"R1"})]
    assert kinds == ["known violation", "violation"]


def test_faults_are_alike_but_for_numbers() -> None:
    assert set(points(faults=("late by 3.5 s", "late by 41 s"))) == {("fault", "late by # s")}


def test_a_kind_is_described_by_its_parts() -> None:
    found = describe(("known violation", "R1", "speed < 1", "Fetch", "given"), 3, "t-1")
    assert (found.requirement, found.part, found.state, found.outcome) == ("R1", "speed < 1", "Fetch", "given")
    assert (found.known, found.runs, found.test) == (True, 3, "t-1")
    fault = describe(("fault", "late by # s"), 1, "t-1")
    assert (fault.requirement, fault.part, fault.known) == ("", "late by # s", False)


def test_each_violation_takes_as_many_steps_in_a_long_run_as_in_a_short_one() -> None:
    def steps(count: int) -> float:
        states = [(number / 10, f"s{number}") for number in range(count)]
        violations = [violation(0.1 * number + 0.05) for number in range(count)]
        assert points(*violations, states=states)[-1][3] == f"s{count - 1}"
        return steps_of(lambda: points(*violations, states=states)) / count

    assert steps(400) < 2 * steps(40)
