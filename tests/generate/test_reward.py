"""Rewards, by hand."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.generate.reward import REWARDS, ROUNDS, Published, Uncovered

PLANS = st.frozensets(st.sampled_from("pqrst"))
RUNS = st.lists(st.fixed_dictionaries({"a": PLANS, "b": PLANS}), min_size=1, max_size=6)
SUITE = st.dictionaries(st.tuples(st.sampled_from("ab"), st.sampled_from("pqrst")), st.integers(0, 50))


def _executed(**plans: str) -> Mapping[str, frozenset[str]]:
    return {agent: frozenset(labels) for agent, labels in plans.items()}


def test_each_reward_has_its_number_of_rounds() -> None:
    assert REWARDS.keys() == ROUNDS.keys()


def test_the_published_reward_is_added_over_agents_and_against_the_maxima() -> None:
    reward = Published(QLearning(), {}, {})
    assert reward.of(_executed(a="pq", b="p")) == 200.0
    assert reward.of(_executed(a="p", b="p")) == 5.0 + 100.0
    assert reward.of(_executed(a="", b="")) == 1.0 + 5.0
    assert reward.of(_executed(a="pqrst", b="")) == 100.0 + 5.0
    assert reward.of(_executed(a="p", b="")) == -100.0 + 5.0
    assert reward.maxima == {"a": 5, "b": 1}


def test_a_plan_that_no_test_executes_is_worth_most() -> None:
    reward = Uncovered(QLearning(), {("a", "p"): 1, ("a", "q"): 3}, {})
    reward.begin()
    assert reward.of(_executed(a="q")) == pytest.approx(100 / 16)
    assert reward.of(_executed(a="qp")) == pytest.approx(100 / 4)
    assert reward.of(_executed(a="qpr")) == pytest.approx(100)
    assert reward.of(_executed(a="qpr")) == 0.0
    assert reward.of(_executed(a="q")) == pytest.approx(-125)
    reward.begin()
    assert reward.of(_executed(a="q")) == pytest.approx(100 / 16)


@given(SUITE, RUNS)
def test_rewards_add_up_to_the_worth_of_the_last_run(
    suite: Mapping[tuple[str, str], int], runs: list[Mapping[str, frozenset[str]]]
) -> None:
    *way, last = runs
    totals = []
    for order in list(permutations(way))[:4]:
        reward = Uncovered(QLearning(), suite, {})
        reward.begin()
        totals.append(sum(reward.of(executed) for executed in (*order, last)))
    direct = Uncovered(QLearning(), suite, {}).of(last)
    assert totals == pytest.approx([direct] * len(totals), abs=1e-9)
