"""Learning, against small examples worked out by hand, and the subsets that a policy leads to."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.learner import learn, policy_subsets, softmax
from pytest_hricdv.generate.qlearning import QLearning, QTable, WarmStart
from tests.generate.toy import FakeRunner

ONE_WAY = BeliefSpace(("s",), {"only": ("x",)})
TWO = BeliefSpace(("s",), {"only": ("x", "y")})


def test_two_steps_by_hand() -> None:
    """Three plans with all of s, x, y, else one: the second step reaches the maximum, the first falls two short."""
    fake = FakeRunner(lambda subset: {"a": {"1", "2", "3"} if len(subset) == 3 else {"1"}})
    learned = learn(fake, TWO, QLearning(min_beliefs=3, max_beliefs=3, iterations=2), seed=3)
    assert [len(subset) for subset in fake.asked] == [1, 2, 3, 1, 2, 3]
    (first, second), (again, last) = fake.asked[2][1:], fake.asked[5][1:]
    # Iteration 0, alpha 0.1: coverage 1 of 1 gives 100 (next state still all 0), then 3 of 1 gives 100.
    q = {"s": {"x": 0.0, "y": 0.0}, "x": {"y": 0.0}, "y": {"x": 0.0}}
    q["s"][first] = 0.1 * 100
    q[first][second] = 0.1 * 100
    # Iteration 1, alpha 0.09: coverage 1 of 3 gives 1 plus a tenth of the best in the next state; then 3 of 3.
    q["s"][again] = 0.91 * q["s"][again] + 0.09 * (1 + 0.1 * q[again][last])
    q[again][last] = 0.91 * q[again][last] + 0.09 * 100
    for state, row in q.items():
        assert learned.q[state] == pytest.approx(row)


def test_one_quiet_iteration_is_not_convergence() -> None:
    """The rewards of two agents cancel at first (+100 - 100): nothing changes, but nothing is learned either."""
    runs = iter(range(10**6))

    def plans(subset: frozenset[str]) -> dict[str, set[str]]:
        first = next(runs) < 4
        return {"a": {"p"}, "b": set() if first and len(subset) == 2 else {"p", "q", "r", "s"}}

    learned = learn(FakeRunner(plans), ONE_WAY, QLearning(), seed=0)
    assert learned.q_delta[0] == 0.0
    assert learned.converged_at is not None
    assert learned.converged_at > 50


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40), st.floats(1e-3, 1e3))
def test_softmax_is_a_distribution_in_the_order_of_the_values(values: list[float], temperature_kt: float) -> None:
    probabilities = softmax(values, temperature_kt)
    assert math.fsum(probabilities) == pytest.approx(1.0)
    assert all(math.isfinite(p) and p >= 0.0 for p in probabilities)
    ranked = [p for _, p in sorted(zip(values, probabilities, strict=True))]
    assert ranked == sorted(ranked)


def test_learning_continues_from_a_learned_table() -> None:
    fake = FakeRunner(lambda subset: {"a": {"p", "q"}, "b": {"p"}})
    learned = learn(fake, ONE_WAY, QLearning(iterations=1), 0, start=WarmStart(q={"s": {"x": 100.0}}, maxima={"a": 3}))
    assert learned.q["s"]["x"] == pytest.approx(0.9 * 100 + 0.1 * (5 + 100))
    assert learned.maxima == {"a": 3, "b": 1}


def test_a_space_without_a_choice_is_an_error() -> None:
    with pytest.raises(GenerateError, match="start beliefs only"):
        learn(FakeRunner(lambda subset: {}), BeliefSpace(("s",), {}), QLearning(), 0)


SMALL = BeliefSpace(("s", "t"), {"g": ("x", "y", "z")})
Q: QTable = {
    "s": {"x": 3.0, "y": 2.0, "z": 1.0},
    "t": {"x": 1.0, "y": 2.0, "z": 3.0},
    "x": {"y": 1.0, "z": 2.0},
    "y": {"x": 1.0, "z": 2.0},
    "z": {"x": 1.0, "y": 2.0},
}


def test_the_policy_takes_the_two_best_beliefs_and_finds_all_their_subsets() -> None:
    """Of two beliefs, s leads to x or y and t to z or y; of three, s to any two and t to any two; then to all."""
    found = policy_subsets(Q, SMALL, QLearning(), count=100, seed=0)
    pairs = {subset for subset in found if len(subset) == 2}
    assert pairs == {("s", "x"), ("s", "y"), ("t", "y"), ("t", "z")}
    triples = {subset for subset in found if len(subset) == 3}
    assert triples == {(start, *two) for start in "st" for two in (("x", "y"), ("x", "z"), ("y", "z"))}
    assert {subset for subset in found if len(subset) == 4} == {("s", "x", "y", "z"), ("t", "x", "y", "z")}
    assert len(found) == 12
