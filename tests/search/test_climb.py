"""The search for a violation: within its bounds, never worse than its start, the same for the same stream."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Constant, Range
from pytest_hricdv.generate.stream import stream
from pytest_hricdv.search.budget import Budget
from pytest_hricdv.search.climb import Found, Reached, climb
from pytest_hricdv.search.mutate import mutated
from tests.search.test_shrink import SPACE, TESTS, is_inside

PLACE = {name: Range(0.0, 1.0, "m") for name in ("x_m", "y_m", "z_m")}
REACH = Concretization(commands={"reach": PLACE, "wait": {"s": Constant(1.0)}})


def reaching(x_m: float, y_m: float, z_m: float) -> ConcreteTest:
    """A person reaches to a place."""
    return ConcreteTest("t", "s", 7, (ConcreteAction("reach", {"x_m": x_m, "y_m": y_m, "z_m": z_m}),))


def distance(test: ConcreteTest) -> Reached:
    """How far the hand is from a small ball in a corner of the room."""
    (action,) = test.actions
    away = max(abs(value - 0.83) for value in action.parameters.values())
    return Reached(away - 0.04, violated=away < 0.04)


def search(starts: list[ConcreteTest], runs: int, seed: int = 0) -> Found:
    return climb([(test, distance(test)) for test in starts], REACH, distance, Budget(runs), stream("test", seed))


PLACES = st.builds(reaching, *[st.floats(0.0, 1.0)] * 3)


@given(starts=st.lists(PLACES, min_size=1, max_size=4), runs=st.integers(0, 40), seed=st.integers(0, 99))
def test_it_is_never_worse_than_its_starts_and_keeps_to_its_budget(
    starts: list[ConcreteTest], runs: int, seed: int
) -> None:
    found = search(starts, runs, seed)
    assert found.runs <= runs
    assert found.reached == distance(found.test)
    assert found.reached.height <= min(distance(test).height for test in starts)
    assert found.reached.violated == (found.ended == "done")
    again = search(starts, runs, seed)
    assert (again.test, again.reached, again.runs) == (found.test, found.reached, found.runs)


def test_steering_finds_what_sampling_would_not() -> None:
    # The ball takes 0.08 ** 3 of the room: one sample in two thousand.
    found = [search([reaching(0.1, 0.2, 0.1)], runs=200, seed=seed).reached.violated for seed in range(10)]
    assert sum(found) >= 9


@given(test=TESTS, step=st.floats(0.01, 0.5), seed=st.integers(0, 99))
def test_a_neighbour_has_the_same_actions_and_parameters_in_their_ranges(
    test: ConcreteTest, step: float, seed: int
) -> None:
    other = mutated(test, SPACE, step, stream(seed))
    assert (other.id, other.suite, other.seed) == (test.id, test.suite, test.seed)
    assert [action.command for action in other.actions] == [action.command for action in test.actions]
    for action in other.actions:
        samplers = SPACE.commands[action.command]
        assert action.parameters.keys() == samplers.keys()
        assert all(is_inside(value, samplers[name]) for name, value in action.parameters.items())
    assert is_inside(other.run["timeout_s"], SPACE.run["timeout_s"])


def test_where_nothing_can_be_varied_nothing_is_run() -> None:
    still = ConcreteTest("t", "s", 7, (ConcreteAction("wait", {"s": 1.0}),))

    def run(test: ConcreteTest) -> Reached:
        raise AssertionError("there is nothing to run")

    found = climb([(still, Reached(0.5, violated=False))], REACH, run, Budget(20), stream(0))
    assert (found.test, found.ended) == (still, "runs")


def test_without_a_margin_it_goes_on_looking() -> None:
    def run(test: ConcreteTest) -> Reached:
        return Reached(None, violated=test.actions[0].parameters["x_m"] > 0.9)

    found = climb([(reaching(0.1, 0.2, 0.1), Reached(None, violated=False))], REACH, run, Budget(200), stream(0))
    assert found.reached.violated


def test_ctrl_c_keeps_the_nearest_so_far() -> None:
    calls: list[Reached] = []

    def run(test: ConcreteTest) -> Reached:
        if len(calls) == 20:
            raise KeyboardInterrupt
        calls.append(distance(test))
        return calls[-1]

    start = reaching(0.1, 0.2, 0.1)
    found = climb([(start, distance(start))], REACH, run, Budget(200), stream(0))
    assert found.ended == "interrupted"
    assert found.reached.height == min(each.height for each in calls)
