"""What decides: the nearest neighbour of a failing test that passes."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.diagnosis.minimal_pair import PRECISION, NeighborSearch
from pytest_hricdv.extra.diagnosis.records import Decision
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Uniform

PAUSE = {"pause_s": Uniform(0.0, 4.0, "s")}
SPACE = Concretization(
    commands={
        "ask": PAUSE,
        "look left": {},
        "look right": {},
        "go": {},
        "disturb step_in": {"gap_m": Uniform(0.0, 2.0, "m")},
    },
    run={"patience_s": Uniform(1.0, 9.0, "s")},
)
PEOPLE = Concretization(commands={"child: ask": {}, "nurse: call": {}}).with_turns(("child", "nurse"))


def concrete(*actions: tuple[str, dict[str, float]], **run: float) -> ConcreteTest:
    made = tuple(ConcreteAction(command, parameters) for command, parameters in actions)
    return ConcreteTest("t", "suite", 0, made, run)


STEPS = concrete(("ask", {"pause_s": 1.0}), ("look left", {}), ("disturb step_in", {"gap_m": 0.5}), patience_s=5.0)


def decision(
    fails: Callable[[ConcreteTest], bool],
    test: ConcreteTest = STEPS,
    space: Concretization = SPACE,
    budget: int = 100,
    checks: Callable[[ConcreteTest], bool] = lambda test: True,
) -> Decision:
    """What decides for a robot whose R1 fails like this."""

    def run(tried: ConcreteTest) -> RunSummary:
        begun = []
        time_s = 0.0
        for number, action in enumerate(tried.actions):
            time_s += action.parameters.get("pause_s", 0.0)
            begun.append((time_s, number))
            time_s += 1.0
        is_violated = fails(tried)
        checked = ("R1",) if checks(tried) and not is_violated else ()
        return RunSummary(violated=("R1",) if is_violated else (), checked=checked, begun=tuple(begun))

    made = NeighborSearch(test, space, run(test), {"R1"}, run, budget).decision()
    assert made is not None
    return made


def commands(test: ConcreteTest) -> list[str]:
    return [action.command for action in test.actions]


def test_a_disturbance_that_has_to_be_there() -> None:
    made = decision(lambda test: "disturb step_in" in commands(test))
    assert (made.words, made.kind) == ("without the disturbance step_in", "disturbance")


def test_a_disturbance_and_when_it_may_come() -> None:
    def fails(test: ConcreteTest) -> bool:
        return "disturb step_in" in commands(test) and test.actions[0].parameters.get("pause_s", 0.0) < 3.1

    made = decision(fails)
    assert made.words.startswith("without the disturbance step_in, or when ask comes 2.1")
    assert "s later (pause_s of ask 3.1" in made.words


def test_what_is_not_checked_any_more_comes_last_and_says_so() -> None:
    made = decision(
        lambda test: "ask" in commands(test) and test.run["patience_s"] < 7.0,
        checks=lambda test: "ask" in commands(test),
    )
    assert made.words.startswith("with patience_s of the run 7")
    made = decision(lambda test: "ask" in commands(test), checks=lambda test: "ask" in commands(test))
    assert made.words == "without the action 1, ask, but only because R1 is then never triggered"


def test_the_order_of_two_actors() -> None:
    test = concrete(("child: ask", {"turn": 0.7}), ("nurse: call", {"turn": 0.3}), turn_wait_s=5.0)

    def fails(tried: ConcreteTest) -> bool:
        turns = {action.command: action.parameters["turn"] for action in tried.actions}
        return len(turns) == 2 and turns["nurse: call"] < turns["child: ask"]

    made = decision(fails, test, PEOPLE)
    assert (made.words, made.kind) == ("when child: ask comes before nurse: call", "order")


@given(st.floats(0.55, 1.95))
def test_a_threshold_is_between_what_is_said(threshold_m: float) -> None:
    test = concrete(("disturb step_in", {"gap_m": 0.5}))
    tried: list[tuple[float, bool]] = []

    def fails(one: ConcreteTest) -> bool:
        gap_m = [action.parameters["gap_m"] for action in one.actions if action.parameters]
        is_failing = bool(gap_m) and gap_m[0] < threshold_m
        tried.extend((value, is_failing) for value in gap_m)
        return is_failing

    decision(fails, test)
    fails_with = max(value for value, is_failing in tried if is_failing)
    passes_with = min(value for value, is_failing in tried if not is_failing)
    assert fails_with < threshold_m <= passes_with
    assert passes_with - fails_with <= PRECISION * 1.5 + 1e-9
