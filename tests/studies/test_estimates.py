"""Intervals and rank correlation."""

from __future__ import annotations

import math
from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.results.proportion import share
from studies.estimates import mean, ranks, spearman

FLOATS = st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: round(value, 3))
PARTS = st.integers(1, 5000).flatmap(lambda whole: st.tuples(st.integers(0, whole), st.just(whole)))


@given(PARTS)
def test_a_share_lies_in_its_interval_and_the_interval_between_0_and_1(trial: tuple[int, int]) -> None:
    found = share(*trial)
    assert found is not None
    assert 0.0 <= found.low <= found.value <= found.high <= 1.0
    assert found.low < found.high


@given(PARTS)
def test_the_interval_of_the_others_is_the_mirror_image(trial: tuple[int, int]) -> None:
    part, whole = trial
    found, others = share(part, whole), share(whole - part, whole)
    assert found is not None
    assert others is not None
    assert found.low == pytest.approx(1.0 - others.high, abs=1e-12)


@given(PARTS)
def test_more_trials_of_the_same_share_say_more(trial: tuple[int, int]) -> None:
    part, whole = trial
    few, many = share(part, whole), share(10 * part, 10 * whole)
    assert few is not None
    assert many is not None
    assert many.high - many.low < few.high - few.low


def test_wilson_s_interval_is_the_textbook_s() -> None:
    found = share(10, 100)  # Wilson (1927), z = 1.96
    assert found is not None
    assert [found.low, found.high] == pytest.approx([0.0552, 0.1744], abs=5e-5)
    assert share(0, 0) is None


@pytest.mark.parametrize(("part", "whole"), [(-1, 3), (4, 3)])
def test_a_part_that_is_none_is_refused(part: int, whole: int) -> None:
    with pytest.raises(ValueError, match="expected a part of a whole"):
        share(part, whole)


@settings(max_examples=20)  # each draws 4,000 samples
@given(st.lists(FLOATS, min_size=1, max_size=12))
def test_a_mean_lies_in_its_interval_which_does_not_leave_the_values(values: list[float]) -> None:
    found = mean(values)
    assert min(values) - 1e-6 <= found.low <= found.value <= found.high <= max(values) + 1e-6
    assert mean(values) == found


def test_the_interval_of_a_mean_is_about_two_standard_errors_wide() -> None:
    values = [float(value % 7) for value in range(70)]
    found = mean(values)
    error = math.sqrt(4.0 / 70)  # the values 0 to 6, equally often, have the variance 4
    assert found.high - found.low == pytest.approx(2 * 1.96 * error, rel=0.1)
    with pytest.raises(ValueError, match="no values"):
        mean([])


@given(st.lists(FLOATS, max_size=30))
def test_ranks_keep_order_and_sum(values: list[float]) -> None:
    found = ranks(values)
    assert sum(found) == len(values) * (len(values) + 1) / 2
    for a, rank_a in zip(values, found, strict=True):
        for b, rank_b in zip(values, found, strict=True):
            assert (a < b) == (rank_a < rank_b)


@given(st.lists(st.tuples(FLOATS, FLOATS), min_size=2, max_size=30))
def test_rank_correlation_is_symmetric_and_bounded_and_sees_ranks_only(pairs: list[tuple[float, float]]) -> None:
    first, second = [a for a, _ in pairs], [b for _, b in pairs]
    found = spearman(first, second)
    if found is None:
        assert len(set(first)) == 1 or len(set(second)) == 1
        return
    assert -1.0 - 1e-9 <= found <= 1.0 + 1e-9
    assert spearman(second, first) == pytest.approx(found)
    assert spearman([math.atan(a / 1e3) * 5 for a in first], second) == pytest.approx(found)
    assert spearman([-a for a in first], second) == pytest.approx(-found)


def test_without_ties_it_is_the_formula_of_squared_differences() -> None:
    first = [1.0, 2.0, 3.0, 4.0, 5.0]
    for second in permutations(first):
        squares = sum((a - b) ** 2 for a, b in zip(first, second, strict=True))
        assert spearman(first, second) == pytest.approx(1 - 6 * squares / (5 * (25 - 1)))


def test_pairs_must_be_pairs() -> None:
    with pytest.raises(ValueError, match="expected pairs"):
        spearman([1.0], [1.0, 2.0])
    assert spearman([1.0], [2.0]) is None
