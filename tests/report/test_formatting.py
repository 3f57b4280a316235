"""Formatted figures and names, and thinned curves."""

import itertools
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.formatting import (
    fit_list,
    line_ranges,
    natural,
    percent,
)
from pytest_hricdv.report.plot_data import thin_curve


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (0.0, "0.0 %"), (0.01, "0.1 %"), (80.46, "80.5 %"), (99.99, "99.9 %"), (100.0, "100.0 %")],
)
def test_per_cent_never_rounds_to_nothing_or_everything(value: float | None, text: str) -> None:
    assert percent(value) == text


@given(st.sets(st.integers(1, 300)))
def test_ranges_hold_exactly_the_lines(lines: set[int]) -> None:
    ranges = [
        (int(first), int(last or first)) for first, _, last in (text.partition("-") for text in line_ranges(lines))
    ]
    assert {line for first, last in ranges for line in range(first, last + 1)} == lines
    assert all(last + 1 < first for (_, last), (first, _) in itertools.pairwise(ranges))


def test_names_are_sorted_as_people_count() -> None:
    assert sorted(["R10", "R2", "plan10", "R", "plan9", "2"], key=natural) == ["2", "R", "R2", "R10", "plan9", "plan10"]


@given(st.integers(0, 5000), st.integers(1, 50))
def test_a_thinned_curve_keeps_its_ends_and_extremes(count: int, columns: int) -> None:
    rng = random.Random(count)
    points = [(float(n), rng.random()) for n in range(count)]
    thin = thin_curve(points, columns)
    assert len(thin) <= 2 * columns + 2
    assert list(thin) == sorted(thin)
    if points:
        assert (thin[0], thin[-1]) == (points[0], points[-1])
        assert max(up for _, up in thin) == max(up for _, up in points)


@pytest.mark.parametrize(
    ("columns", "shown"),
    [(30, "12 statements, 3 branches"), (25, "12 statements, 3 branches"), (24, "15 open"), (7, "15 open"), (3, "15 ")],
)
def test_of_several_texts_the_fullest_that_fits_is_taken(columns: int, shown: str) -> None:
    assert fit_list(("12 statements, 3 branches", "15 open"), columns) == shown
