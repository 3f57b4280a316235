"""The subsets a policy leads to."""

from __future__ import annotations

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.learner import learn
from pytest_hricdv.generate.policy import policy_subsets, rankings
from pytest_hricdv.generate.qlearning import QLearning, QTable
from tests.generate.table import SPACE
from tests.generate.toy import FakeRunner

SMALL = BeliefSpace(("s", "t"), {"g": ("x", "y", "z")})
Q: QTable = {
    "s": {"x": 3.0, "y": 2.0, "z": 1.0},
    "t": {"x": 1.0, "y": 2.0, "z": 3.0},
    "x": {"y": 1.0, "z": 2.0},
    "y": {"x": 1.0, "z": 2.0},
    "z": {"x": 1.0, "y": 2.0},
}


def test_the_ranking_is_by_value() -> None:
    assert rankings(Q, SMALL, 0)["s"] == ("x", "y", "z")
    assert rankings(Q, SMALL, 0)["t"] == ("z", "y", "x")


def test_ties_are_broken_by_the_seed() -> None:
    level: QTable = {state: {belief: 0.0 for belief in SPACE.others if belief != state} for state in SPACE.beliefs}
    assert rankings(level, SPACE, 1) == rankings(level, SPACE, 1)
    assert rankings(level, SPACE, 1) != rankings(level, SPACE, 2)
    assert len({ranking[0] for ranking in rankings(level, SPACE, 1).values()}) > 10


def test_the_policy_takes_the_two_best_beliefs_and_finds_all_their_subsets() -> None:
    """Of two beliefs, s leads to x or y and t to z or y; of three, s to any two and t to any two; then to all."""
    found = policy_subsets(Q, SMALL, QLearning(), count=100, seed=0)
    pairs = {subset for subset in found if len(subset) == 2}
    assert pairs == {("s", "x"), ("s", "y"), ("t", "y"), ("t", "z")}
    triples = {subset for subset in found if len(subset) == 3}
    assert triples == {(start, *two) for start in "st" for two in (("x", "y"), ("x", "z"), ("y", "z"))}
    assert {subset for subset in found if len(subset) == 4} == {("s", "x", "y", "z"), ("t", "x", "y", "z")}
    assert len(found) == 12


def test_sizes_are_respected() -> None:
    found = policy_subsets(Q, SMALL, QLearning(min_beliefs=3, max_beliefs=3), count=100, seed=0)
    assert {len(subset) for subset in found} == {3}


def test_at_least_100_distinct_subsets_for_the_table() -> None:
    learned = learn(FakeRunner(lambda subset: {"a": set(subset)}), SPACE, QLearning(), seed=0)
    found = policy_subsets(learned.q, SPACE, QLearning(), count=134, seed=0)
    assert len(found) == len(set(found)) == 134
    assert {subset[0] for subset in found} == set(SPACE.start)
    assert found[:50] == policy_subsets(learned.q, SPACE, QLearning(), count=50, seed=0)
    assert found != policy_subsets(learned.q, SPACE, QLearning(), count=134, seed=1)
