"""Which tests a mutant is tried on, and in which order."""

from __future__ import annotations

from pytest_hricdv.extra.mutation.mutating import TrialCandidate, TrialOrder

NEAR = TrialCandidate("near", "s", statements=0b0001, points=0b00001, sim_s=5.0)
RICH = TrialCandidate("rich", "s", statements=0b0111, points=0b01111, sim_s=10.0)
SAME = TrialCandidate("same", "s", statements=0b0111, points=0b01111, sim_s=20.0)
RARE = TrialCandidate("rare", "s", statements=0b0011, points=0b10001, sim_s=90.0)
ELSEWHERE = TrialCandidate("elsewhere", "t", statements=0b1001, points=0b1, sim_s=1.0)
TESTS = [SAME, RARE, ELSEWHERE, RICH, NEAR]


def test_only_tests_that_execute_the_statement_are_tried() -> None:
    order = TrialOrder(TESTS, None)
    assert set(order.tests(2)) == {"rich", "same"}
    assert (order.tests(3), order.tests(4)) == (("elsewhere",), ())
    assert order.suites_of(0) == {"s": 4, "t": 1}


def test_the_nearest_is_first_then_what_adds_most_then_what_is_like_others() -> None:
    assert TrialOrder(TESTS, None).tests(0) == ("near", "rich", "rare", "same", "elsewhere")


def test_at_most_so_many_of_each_suite_are_tried() -> None:
    assert TrialOrder(TESTS, 2).tests(0) == ("near", "rich", "elsewhere")
