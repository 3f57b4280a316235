"""The parameters of Q-learning against the published constants, and the rewards on examples worked out by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import permutations
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.qlearning import REWARDS, ROUNDS, PublishedReward, QLearning, UncoveredReward
from pytest_hricdv.generate.rng import make_rng

PLANS = st.frozensets(st.sampled_from("pqrst"))
RUNS = st.lists(st.fixed_dictionaries({"a": PLANS, "b": PLANS}), min_size=1, max_size=6)
SUITE = st.dictionaries(st.tuples(st.sampled_from("ab"), st.sampled_from("pqrst")), st.integers(0, 50))


def test_the_defaults_are_those_of_the_paper() -> None:
    paper = QLearning()
    assert (paper.gamma, paper.alpha0, paper.alpha_decay, paper.temperature_kt) == (0.1, 0.1, 0.9, 10.0)
    assert (paper.max_beliefs, paper.iterations, paper.tolerance, paper.suite_size) == (11, 1000, 1e-4, 134)
    assert [paper.alpha(j) for j in range(3)] == pytest.approx([0.1, 0.09, 0.081])


@pytest.mark.parametrize(
    ("covered", "reward"), [(13, 100.0), (12, 100.0), (11, 5.0), (10, 1.0), (9, -100.0), (0, -100.0)]
)
def test_reward_tiers(covered: int, reward: float) -> None:
    assert QLearning().tier(covered, maximum=12) == reward


def test_subsets_have_six_and_a_half_beliefs_on_average() -> None:
    rng = make_rng("sizes")
    sizes = [QLearning().subset_size(rng) for _ in range(5000)]
    assert set(sizes) == set(range(2, 12))
    assert sum(sizes) / len(sizes) == pytest.approx(6.5, abs=0.15)


@pytest.mark.parametrize(
    "parameters",
    [
        {"gamma": 1.0}, {"gamma": -0.1}, {"alpha0": 0.0}, {"alpha0": 1.1}, {"alpha_decay": 0.0},
        {"temperature_kt": 0.0}, {"temperature_kt": math.inf}, {"rewards": ()}, {"rewards": (math.nan,)},
        {"reward_otherwise": math.inf},
        {"min_beliefs": 1}, {"max_beliefs": 1}, {"iterations": 0}, {"tolerance": -1.0}, {"tolerance": math.nan},
        {"quiet_iterations": 0}, {"suite_size": 0}, {"candidates": 0}, {"model_runs": -1}, {"rounds": -1},
        {"alternatives": 0}, {"patience": 0},
    ],
)  # fmt: skip
def test_parameters_out_of_range_are_errors(parameters: dict[str, Any]) -> None:
    (name,) = parameters
    with pytest.raises(GenerateError, match=f"QLearning: {name} = .*; expected"):
        QLearning(**parameters)


def test_an_unknown_reward_names_the_nearest() -> None:
    with pytest.raises(GenerateError, match="no reward 'uncoverd'; nearest: uncovered"):
        QLearning(reward="uncoverd")


def test_rounds_share_runs_and_tests() -> None:
    shares = QLearning(reward="uncovered", model_runs=25).in_rounds(134)
    assert len(shares) == 10
    assert sum(each.model_runs for each in shares) == 25
    assert sum(each.suite_size for each in shares) == 134
    assert [each.suite_size for each in QLearning(reward="uncovered").in_rounds(3)] == [1, 1, 1]
    assert QLearning().in_rounds(134) == (QLearning(),)


def _executed(**plans: str) -> Mapping[str, frozenset[str]]:
    return {agent: frozenset(labels) for agent, labels in plans.items()}


def test_each_reward_has_its_number_of_rounds() -> None:
    assert REWARDS.keys() == ROUNDS.keys()


def test_the_published_reward_is_added_over_agents_and_against_the_maxima() -> None:
    reward = PublishedReward(QLearning().tier, {}, {})
    assert reward.of(_executed(a="pq", b="p")) == 200.0
    assert reward.of(_executed(a="p", b="p")) == 5.0 + 100.0
    assert reward.of(_executed(a="", b="")) == 1.0 + 5.0
    assert reward.of(_executed(a="pqrst", b="")) == 100.0 + 5.0
    assert reward.of(_executed(a="p", b="")) == -100.0 + 5.0
    assert reward.maxima == {"a": 5, "b": 1}


def test_a_plan_that_no_test_executes_has_the_highest_value() -> None:
    reward = UncoveredReward(QLearning().tier, {("a", "p"): 1, ("a", "q"): 3}, {})
    reward.begin()
    assert reward.of(_executed(a="q")) == pytest.approx(100 / 16)
    assert reward.of(_executed(a="qp")) == pytest.approx(100 / 4)
    assert reward.of(_executed(a="qpr")) == pytest.approx(100)
    assert reward.of(_executed(a="qpr")) == 0.0
    assert reward.of(_executed(a="q")) == pytest.approx(-125)
    reward.begin()
    assert reward.of(_executed(a="q")) == pytest.approx(100 / 16)


@given(SUITE, RUNS)
def test_rewards_add_up_to_the_value_of_the_last_run(
    suite: Mapping[tuple[str, str], int], runs: list[Mapping[str, frozenset[str]]]
) -> None:
    *way, last = runs
    totals = []
    for order in list(permutations(way))[:4]:
        reward = UncoveredReward(QLearning().tier, suite, {})
        reward.begin()
        totals.append(sum(reward.of(executed) for executed in (*order, last)))
    direct = UncoveredReward(QLearning().tier, suite, {}).of(last)
    assert totals == pytest.approx([direct] * len(totals), abs=1e-9)
