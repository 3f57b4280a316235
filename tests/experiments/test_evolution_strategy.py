"""The search for a violation: within its budget, never worse than its starts, deterministic."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.evolution_strategy import Evaluation, SearchOutcome, mutate, search_violation
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import Constant, Uniform
from tests.experiments.test_shrink import SPACE, TESTS, is_inside

PLACE = {name: Uniform(0.0, 1.0, "m") for name in ("x_m", "y_m", "z_m")}
REACH = Concretization(commands={"reach": PLACE, "wait": {"s": Constant(1.0)}})


def reaching(x_m: float, y_m: float, z_m: float) -> ConcreteTest:
    """A person reaches to a place."""
    return ConcreteTest("t", "s", 7, (ConcreteAction("reach", {"x_m": x_m, "y_m": y_m, "z_m": z_m}),))


def distance(test: ConcreteTest) -> Evaluation:
    """How far the hand is from a small ball in a corner of the room."""
    (action,) = test.actions
    away = max(abs(value - 0.83) for value in action.parameters.values())
    return Evaluation(away - 0.04, violated=away < 0.04)


def search(starts: list[ConcreteTest], runs: int, seed: int = 0) -> SearchOutcome:
    return search_violation(
        [(test, distance(test)) for test in starts], REACH, distance, Budget(runs), make_rng("test", seed)
    )


PLACES = st.builds(reaching, *[st.floats(0.0, 1.0)] * 3)


@given(starts=st.lists(PLACES, min_size=1, max_size=4), runs=st.integers(0, 40), seed=st.integers(0, 99))
def test_the_result_is_never_worse_than_the_starts_and_within_the_budget(
    starts: list[ConcreteTest], runs: int, seed: int
) -> None:
    found = search(starts, runs, seed)
    assert found.runs <= runs
    assert found.evaluation == distance(found.test)
    assert found.evaluation.objective <= min(distance(test).objective for test in starts)
    assert found.evaluation.violated == (found.ended == "done")
    again = search(starts, runs, seed)
    assert (again.test, again.evaluation, again.runs) == (found.test, found.evaluation, found.runs)


def test_the_search_finds_a_violation_that_sampling_hardly_finds() -> None:
    # The ball takes 0.08 ** 3 of the room: one sample in two thousand.
    found = [search([reaching(0.1, 0.2, 0.1)], runs=200, seed=seed).evaluation.violated for seed in range(10)]
    assert sum(found) >= 9


@given(test=TESTS, step=st.floats(0.01, 0.5), seed=st.integers(0, 99))
def test_a_neighbour_has_the_same_actions_and_parameters_in_their_ranges(
    test: ConcreteTest, step: float, seed: int
) -> None:
    other = mutate(test, SPACE, step, make_rng(seed))
    assert (other.id, other.suite, other.seed) == (test.id, test.suite, test.seed)
    assert [action.command for action in other.actions] == [action.command for action in test.actions]
    for action in other.actions:
        samplers = SPACE.commands[action.command]
        assert action.parameters.keys() == samplers.keys()
        assert all(is_inside(value, samplers[name]) for name, value in action.parameters.items())
    assert is_inside(other.run["timeout_s"], SPACE.run["timeout_s"])


def test_ctrl_c_returns_the_best_test_so_far() -> None:
    calls: list[Evaluation] = []

    def run(test: ConcreteTest) -> Evaluation:
        if len(calls) == 20:
            raise KeyboardInterrupt
        calls.append(distance(test))
        return calls[-1]

    start = reaching(0.1, 0.2, 0.1)
    found = search_violation([(start, distance(start))], REACH, run, Budget(200), make_rng(0))
    assert found.ended == "interrupted"
    assert found.evaluation.objective == min(each.objective for each in calls)
