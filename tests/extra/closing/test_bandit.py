"""The choice among strategies."""

from __future__ import annotations

from pytest_hricdv.extra.closing.loop import Bandit, StrategyReward
from pytest_hricdv.generate.rng import make_rng

KINDS = ("bin", "statement", "branch", "plan")
BIN, CODE = frozenset({"bin"}), frozenset({"statement", "branch"})


def test_a_way_that_pays_off_gets_most_tests_and_the_other_one_still_some() -> None:
    bandit = Bandit(("good", "bad"), KINDS)
    for _ in range(10):
        bandit.learn(
            [StrategyReward("good", BIN)] * 4
            + [StrategyReward("good")] * 4
            + [StrategyReward("bad")] * 7
            + [StrategyReward("bad", BIN)]
        )
    shares = bandit.shares(("good", "bad"), 1000, {"bin": 3}, make_rng("shares"))
    assert shares["good"] + shares["bad"] == 1000
    assert 0 < shares["bad"] < 250


def test_each_kind_of_open_points_has_the_ways_that_reach_such_points() -> None:
    bandit = Bandit(("bins", "code"), KINDS)
    for _ in range(10):
        bandit.learn([StrategyReward("bins", BIN)] * 4 + [StrategyReward("code", CODE)] * 4)
    for kinds, low, high in (({"bin": 5}, 0.9, 1.0), ({"branch": 5}, 0.0, 0.1), ({"bin": 2, "statement": 2}, 0.4, 0.6)):
        shares = bandit.shares(("bins", "code"), 1000, kinds, make_rng("kinds"))
        assert low <= shares["bins"] / 1000 <= high


def test_what_paid_off_long_ago_counts_less() -> None:
    bandit = Bandit(("early", "late"), KINDS)
    bandit.learn([StrategyReward("early", BIN)] * 16 + [StrategyReward("late")] * 16)
    for _ in range(40):
        bandit.learn([StrategyReward("early")] * 4 + [StrategyReward("late", BIN)] * 4)
    assert bandit.weight("late", "bin") > 5 * bandit.weight("early", "bin") > 0.0


def test_ways_of_which_nothing_is_known_get_equal_shares() -> None:
    shares = Bandit(("one", "two"), KINDS).shares(("one", "two"), 1000, {"plan": 1}, make_rng("equal"))
    assert 400 < shares["one"] < 600


def test_while_nothing_pays_off_it_is_not_forgotten_what_did() -> None:
    bandit = Bandit(("once", "never"), KINDS)
    bandit.learn([StrategyReward("once", CODE)] * 2 + [StrategyReward("once")] * 20 + [StrategyReward("never")] * 20)
    before = bandit.weight("once", "branch") / bandit.weight("never", "branch")
    for _ in range(40):
        bandit.learn([StrategyReward("once", BIN)] * 4 + [StrategyReward("never", BIN)] * 4)
    assert bandit.weight("once", "branch") > 2 * bandit.weight("never", "branch")
    assert before > 2


def test_what_is_aimed_at_one_kind_says_nothing_of_another_one() -> None:
    bandit = Bandit(("both", "none"), KINDS)
    bandit.learn(
        [StrategyReward("both", BIN, BIN)] * 4
        + [StrategyReward("both", targeted=CODE)] * 40
        + [StrategyReward("none", targeted=BIN)] * 4
    )
    shares = bandit.shares(("both", "none"), 1000, {"bin": 1}, make_rng("aimed"))
    assert shares["both"] > 800
