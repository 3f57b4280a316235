"""The choice among ways."""

from __future__ import annotations

from pytest_hricdv.close.bandit import LEAST, Bandit
from pytest_hricdv.generate.rng import make_rng


def test_a_way_that_pays_off_gets_most_tests_and_the_other_one_still_some() -> None:
    bandit = Bandit(("good", "bad"))
    for _ in range(10):
        bandit.learn([("good", True)] * 8 + [("bad", False)] * 8)
    shares = bandit.shares(("good", "bad"), 1000, make_rng("shares"))
    assert shares["good"] + shares["bad"] == 1000
    assert 0 < shares["bad"] < 100


def test_what_paid_off_long_ago_counts_less() -> None:
    bandit = Bandit(("early", "late"))
    bandit.learn([("early", True)] * 16 + [("late", False)] * 16)
    for _ in range(20):
        bandit.learn([("early", False)] * 4 + [("late", True)] * 4)
    assert bandit.weight("late") > 5 * bandit.weight("early") >= LEAST


def test_ways_of_which_nothing_is_known_get_equal_shares() -> None:
    shares = Bandit(("one", "two")).shares(("one", "two"), 1000, make_rng("equal"))
    assert 400 < shares["one"] < 600
