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
from pytest_hricdv.generate.qlearning import PublishedReward, QLearning, UncoveredReward

PLANS = st.frozensets(st.sampled_from("pqrst"))
RUNS = st.lists(st.fixed_dictionaries({"a": PLANS, "b": PLANS}), min_size=1, max_size=6)
SUITE = st.dictionaries(st.tuples(st.sampled_from("ab"), st.sampled_from("pqrst")), st.integers(0, 50))


@pytest.mark.parametrize(
    ("covered", "reward"), [(13, 100.0), (12, 100.0), (11, 5.0), (10, 1.0), (9, -100.0), (0, -100.0)]
)
def test_reward_tiers(covered: int, reward: float) -> None:
    assert QLearning().tier(covered, maximum=12) == reward


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


def _executed(**plans: str) -> Mapping[str, frozenset[str]]:
    return {agent: frozenset(labels) for agent, labels in plans.items()}


def test_the_published_reward_is_added_over_agents_and_against_the_maxima() -> None:
    reward = PublishedReward(QLearning().tier, {}, {})
    assert reward.of(_executed(a="pq", b="p")) == 200.0
    assert reward.of(_executed(a="p", b="p")) == 5.0 + 100.0
    assert reward.of(_executed(a="", b="")) == 1.0 + 5.0
    assert reward.of(_executed(a="pqrst", b="")) == 100.0 + 5.0
    assert reward.of(_executed(a="p", b="")) == -100.0 + 5.0
    assert reward.maxima == {"a": 5, "b": 1}


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
