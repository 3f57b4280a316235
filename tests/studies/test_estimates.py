"""Intervals and rank correlation."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.results.proportion import share
from studies.estimates import mean

FLOATS = st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: round(value, 3))
PARTS = st.integers(1, 5000).flatmap(lambda whole: st.tuples(st.integers(0, whole), st.just(whole)))


@given(PARTS)
def test_a_share_lies_in_its_interval_and_the_interval_between_0_and_1(trial: tuple[int, int]) -> None:
    found = share(*trial)
    assert found is not None
    assert 0.0 <= found.low <= found.value <= found.high <= 1.0
    assert found.low < found.high


def test_wilson_s_interval_is_the_textbook_s() -> None:
    found = share(10, 100)  # Wilson (1927), z = 1.96
    assert found is not None
    assert [found.low, found.high] == pytest.approx([0.0552, 0.1744], abs=5e-5)
    assert share(0, 0) is None


@settings(max_examples=20)  # each draws 4,000 samples
@given(st.lists(FLOATS, min_size=1, max_size=12))
def test_a_mean_lies_in_its_interval_which_does_not_leave_the_values(values: list[float]) -> None:
    found = mean(values)
    assert min(values) - 1e-6 <= found.low <= found.value <= found.high <= max(values) + 1e-6
    assert mean(values) == found
