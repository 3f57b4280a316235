"""What came of tries, and what comes by chance."""

from __future__ import annotations

from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.significance import PRIOR, significance

RATES = st.floats(0.01, 0.5)


@given(RATES, st.integers(0, 20), st.integers(0, 20))
def test_it_is_the_rule_of_bayes(by_chance: float, came: int, vain: int) -> None:
    """With a uniform rate, each number of successes among so many tries is equally likely."""
    tries = came + vain
    effect = PRIOR / (tries + 1)
    chance = (1 - PRIOR) * comb(tries, came) * by_chance**came * (1 - by_chance) ** vain
    assert significance(came, tries, by_chance) == pytest.approx(effect / (effect + chance))


def test_without_tries_it_is_what_is_expected_of_anything() -> None:
    assert significance(0.0, 0.0, 0.05) == pytest.approx(PRIOR)


def test_one_result_of_a_sensor_that_errs_says_little_after_some_tries_in_vain() -> None:
    chances = [significance(1.0, tries, 0.05) for tries in (1.0, 2.0, 4.0, 8.0)]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] > 0.5 > 0.2 > chances[2]
    assert significance(4.0, 8.0, 0.05) > 0.9


def test_very_many_tries_are_no_error() -> None:
    assert significance(1e5, 1e5, 0.01) == pytest.approx(1.0)
    assert significance(1e3, 1e5, 0.01) < PRIOR
