"""Linear regression."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.closing.regression import regression

slopes = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=4)


@given(slopes, st.floats(-10.0, 10.0))
def test_the_slopes_of_a_linear_function_are_found(wanted: list[float], offset: float) -> None:
    rows = [[1000.0 * (place == number) for place in range(len(wanted))] for number in range(len(wanted))]
    rows.append([0.0] * len(wanted))
    values = [offset + sum(slope * each for slope, each in zip(wanted, row, strict=True)) for row in rows]
    found = regression(rows, values)
    assert all(abs(one - other) < 1e-3 for one, other in zip(found, wanted, strict=True))


def test_what_never_varied_and_what_nothing_depends_on_has_no_slope() -> None:
    assert regression([[1.0, 0.0], [1.0, 1.0]] * 10, [2.0, 2.0] * 10) == [0.0, 0.0]
    assert regression([], []) == []
    assert regression([[], []], [1.0, 2.0]) == []
