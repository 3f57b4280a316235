"""Minimization: a part of the tests that covers as much as all, and no test in it is redundant."""

from __future__ import annotations

from functools import reduce

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.closure import MeasuredTest, minimal_suite, unique

several = st.lists(
    st.builds(
        MeasuredTest,
        name=st.text("abcdef", min_size=1, max_size=4),
        points=st.integers(0, 2**12 - 1),
        cost_s=st.sampled_from([0.0, 1.0, 7.5, 60.0]),
    ),
    max_size=12,
    unique_by=lambda test: test.name,
)


def together(tests: list[MeasuredTest]) -> int:
    return reduce(lambda covered, test: covered | test.points, tests, 0)


@given(several)
def test_the_minimal_suite_covers_as_much_and_no_test_in_it_is_redundant(tests: list[MeasuredTest]) -> None:
    steps = minimal_suite(tests)
    chosen = [test for test in tests if test.name in {step.name for step in steps}]
    assert together(chosen) == together(tests)
    assert all(together([other for other in chosen if other is not test]) != together(tests) for test in chosen)


@given(several, st.randoms())
def test_the_order_of_the_tests_makes_no_difference(tests: list[MeasuredTest], random: object) -> None:
    shuffled = list(tests)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert minimal_suite(shuffled) == minimal_suite(tests)
    assert unique(shuffled) == unique(tests)


@given(several)
def test_the_curve_adds_up(tests: list[MeasuredTest]) -> None:
    covered, cost_s = 0, 0.0
    by_name = {test.name: test for test in tests}
    for step in minimal_suite(tests):
        added = by_name[step.name].points & ~covered
        covered |= added
        cost_s += by_name[step.name].cost_s
        assert (step.gain, step.points, step.cost_s) == (added.bit_count(), covered.bit_count(), cost_s)
        assert step.gain > 0
    assert covered == together(tests)
