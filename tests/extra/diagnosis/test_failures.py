"""Failures of a test of several people: what had begun before, and in which order, whatever the order of its lines."""

from __future__ import annotations

import random

from msgspec import convert
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.causes import in_order_begun
from pytest_hricdv.extra.diagnosis.failures import failures_of
from pytest_hricdv.results.model import TestResult
from tests.report import sample_tests

LINES = ("nurse: load", "disturb draught", "porter: open", "disturb unseen")


def result_of(action_times_s: tuple[float, ...], acted: tuple[int, ...] | None) -> TestResult:
    """A test that violates R1 at 51.5 s."""
    made = sample_tests.test(random.Random(1), "rl")
    made["requirements"] = {"R1": sample_tests.requirement_result("Failed", 1.0)}
    result = convert(made, TestResult)
    return replace(result, abstract=LINES, action_times_s=action_times_s, action_indices=acted)


def disturbances(action_times_s: tuple[float, ...], acted: tuple[int, ...] | None) -> tuple[str, ...]:
    (failure,) = failures_of(result_of(action_times_s, acted), "state.name", {})
    return failure.disturbances


def test_of_one_person_lines_begin_in_their_order() -> None:
    assert disturbances((1.0, 2.0, 3.0, 60.0), None) == ("draught",)
    assert disturbances((1.0, 2.0, 3.0, 51.5), None) == ("draught", "unseen")


def test_of_several_people_a_later_line_may_have_begun_before() -> None:
    assert disturbances((1.0, 2.0, 60.0, 61.0), (4, 1, 2, 3)) == ("unseen",)
    assert disturbances((1.0, 2.0), (3, 1)) == ()


def test_lines_are_told_as_they_began_and_those_that_never_did_last() -> None:
    assert in_order_begun(LINES, [(0.0, 2), (1.5, 0)]) == (LINES[2], LINES[0], LINES[1], LINES[3])
    assert in_order_begun(LINES, []) == LINES
