"""Shrinking: the result fails, shrinking ends within its budget, and it is deterministic."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.shrink import Shrunk, shrink
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Constant, Sometimes, Uniform

SPACE = Concretization(
    commands={
        "ask": {"voice_s": Uniform(3.0, 5.0, "s"), "rest_m": Uniform(-0.5, 0.1, "m")},
        "look": {"angle_deg": Uniform(15.0, 40.0, "deg", open_high=True)},
        "pull": {"grip_s": Sometimes(0.1, Uniform(4.0, 14.0, "s"))},
        "go": {"fixed": Constant(2.5)},
    },
    run={"timeout_s": Uniform(10.0, 100.0, "s")},
)
PLENTY = 10_000


def drawn(sampler: object) -> st.SearchStrategy[float]:
    """A value that the sampler might give."""
    if isinstance(sampler, Constant):
        return st.just(sampler.value)
    if isinstance(sampler, Sometimes):
        return st.one_of(st.just(0.0), drawn(sampler.then))
    assert isinstance(sampler, Uniform)
    return st.floats(sampler.low, sampler.high, exclude_max=sampler.open_high)


ACTIONS = st.sampled_from(sorted(SPACE.commands)).flatmap(
    lambda command: st.builds(
        ConcreteAction,
        st.just(command),
        st.fixed_dictionaries({name: drawn(each) for name, each in SPACE.commands[command].items()}),
    )
)
TESTS = st.builds(
    ConcreteTest,
    id=st.just("t"),
    suite=st.just("s"),
    seed=st.just(7),
    actions=st.lists(ACTIONS, max_size=12).map(tuple),
    run=st.fixed_dictionaries({"timeout_s": drawn(SPACE.run["timeout_s"])}),
)


def contains(needed: list[str], above_m: float) -> Callable[[ConcreteTest], bool]:
    """Fails where these commands come in this order, and no `ask` rests lower than that."""

    def fails(test: ConcreteTest) -> bool:
        left = list(needed)
        for action in test.actions:
            if left and action.command == left[0]:
                del left[0]
            if action.parameters.get("rest_m", 1.0) < above_m:
                return False
        return not left

    return fails


def odd_hash(test: ConcreteTest) -> bool:
    """An irregular predicate: neighbours of a failing test may fail or not."""
    return sum(test.to_json().encode()) % 3 == 0


FAILURES = st.one_of(
    st.builds(contains, st.lists(st.sampled_from(["ask", "look", "pull"]), max_size=3), st.floats(-0.5, 0.1)),
    st.just(odd_hash),
)


def shrunk(test: ConcreteTest, fails: Callable[[ConcreteTest], bool], runs: int = PLENTY) -> Shrunk:
    return shrink(test, SPACE, fails, Budget(runs))


@given(test=TESTS, fails=FAILURES, runs=st.integers(0, 60))
def test_the_result_fails_and_the_budget_is_not_exceeded(
    test: ConcreteTest, fails: Callable[[ConcreteTest], bool], runs: int
) -> None:
    if not fails(test):
        return
    calls = []

    def counted(candidate: ConcreteTest) -> bool:
        calls.append(candidate)
        return fails(candidate)

    found = shrunk(test, counted, runs)
    assert fails(found.test)
    assert found.runs == len(calls) <= runs
    assert found.ended in ("done", "runs")
    assert len({each.to_json() for each in calls}) == len(calls), "a run was repeated"
    assert (found.test.id, found.test.suite, found.test.seed) == (test.id, test.suite, test.seed)


@given(test=TESTS, fails=FAILURES)
def test_shrinking_is_deterministic_and_idempotent(test: ConcreteTest, fails: Callable[[ConcreteTest], bool]) -> None:
    if not fails(test):
        return
    once = shrunk(test, fails)
    assert once.ended == "done"
    assert shrunk(test, fails).test == once.test
    assert shrunk(once.test, fails).test == once.test


@given(test=TESTS, fails=FAILURES)
def test_actions_are_only_left_out_and_parameters_stay_in_their_ranges(
    test: ConcreteTest, fails: Callable[[ConcreteTest], bool]
) -> None:
    if not fails(test):
        return
    found = shrunk(test, fails).test
    left = iter(action.command for action in test.actions)
    assert all(action.command in left for action in found.actions), "not a subsequence"
    for action in found.actions:
        for name, value in action.parameters.items():
            assert value == 0.0 or is_inside(value, SPACE.commands[action.command][name])


def is_inside(value: float, sampler: object) -> bool:
    if isinstance(sampler, Constant):
        return value == sampler.value
    if isinstance(sampler, Sometimes):
        return value == 0.0 or is_inside(value, sampler.then)
    assert isinstance(sampler, Uniform)
    return sampler.contains(value)


@given(test=TESTS)
def test_exactly_the_needed_actions_remain(test: ConcreteTest) -> None:
    fails = contains(["ask", "pull"], -0.5)
    if not fails(test):
        return
    found = shrunk(test, fails).test
    assert [action.command for action in found.actions] == ["ask", "pull"]
    assert found.actions[0].parameters == {"voice_s": 4.0, "rest_m": -0.2}
    assert found.actions[1].parameters == {"grip_s": 0.0}
    assert found.run == {"timeout_s": 55.0}


def turns(count: int) -> ConcreteTest:
    """So many turns of four actions each."""
    turn = [
        ConcreteAction("ask", {"voice_s": 3.217, "rest_m": 0.0317}),
        ConcreteAction("look", {"angle_deg": 33.1}),
        ConcreteAction("pull", {"grip_s": 0.0}),
        ConcreteAction("go", {"fixed": 2.5}),
    ]
    return ConcreteTest("t", "s", 7, tuple(turn * count), {"timeout_s": 71.3})


def test_four_turns_become_one_action_in_a_few_runs() -> None:
    found = shrunk(turns(4), contains(["ask"], -0.1))
    assert [action.command for action in found.test.actions] == ["ask"]
    assert found.runs <= 20


def test_other_values_than_the_middle_and_the_ends_are_rounded() -> None:
    def fails(test: ConcreteTest) -> bool:
        return any(0.03 <= action.parameters.get("rest_m", 1.0) < 0.05 for action in test.actions)

    (action,) = shrunk(turns(1), fails).test.actions
    assert action.parameters == {"voice_s": 4.0, "rest_m": 0.03}


@pytest.mark.parametrize("after", [1, 3, 7])
def test_ctrl_c_returns_the_shortest_test_so_far(after: int) -> None:
    calls = 0
    kept: list[ConcreteTest] = []

    def fails(test: ConcreteTest) -> bool:
        nonlocal calls
        calls += 1
        if calls > after:
            raise KeyboardInterrupt
        return contains(["ask"], -0.1)(test)

    found = shrink(turns(4), SPACE, fails, Budget(PLENTY), kept.append)
    assert found.ended == "interrupted"
    assert found.test == (kept[-1] if kept else turns(4))
