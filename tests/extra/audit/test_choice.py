"""Which tests run again."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import pytest

from pytest_hricdv.extra.audit.auditor import choose_tests
from pytest_hricdv.results.model import TestResult
from tests.report import sample


@dataclass(frozen=True)
class Kind:
    """Of tests: what they have in common."""

    outcome: str = "passed"
    ended: str = "goal"
    sim_s: float = 10.0
    wall_s: float = 1.0
    errors: tuple[str, ...] = ()


def in_order(*kinds: Kind) -> list[TestResult]:
    """A test of each kind, in the order in which they ran: t0, t1, ..."""
    model = msgspec.convert(sample.data(tests=1)["tests"][0], TestResult)
    return [
        msgspec.structs.replace(
            model,
            nodeid=f"t{number}",
            id=f"t{number}",
            outcome=kind.outcome,
            end_reason=kind.ended,
            sim_s=kind.sim_s,
            wall_s=kind.wall_s,
            errors=kind.errors,
        )
        for number, kind in enumerate(kinds)
    ]


def names(results: list[TestResult], number: int | None = None) -> list[str]:
    """Of the tests that are chosen, where all ran in one process."""
    place = {result.nodeid: number for number, result in enumerate(results)}
    return [result.nodeid for result in choose_tests(results, place, number)]


def test_failures_come_first_then_each_way_to_end_the_longest_first() -> None:
    short, long = Kind(ended="at once", sim_s=1.0), Kind(ended="late", sim_s=50.0)
    assert names(in_order(short, long, Kind("failed"), short, Kind("error"), long), 4) == ["t2", "t4", "t5", "t3"]


def test_of_equal_tests_the_one_with_most_before_it_is_taken() -> None:
    assert names(in_order(Kind(), Kind(), Kind()), 1) == ["t2"]


@pytest.mark.parametrize(("count", "expected"), [(2, 2), (50, 3), (200, 6), (1_000, 30)])
def test_three_run_again_or_as_many_as_took_three_per_cent_of_the_time(count: int, expected: int) -> None:
    assert len(names(in_order(*[Kind()] * count))) == expected


def test_what_did_not_run_in_this_session_is_left_out() -> None:
    results = in_order(Kind(), Kind(), Kind("not-run"))
    assert [result.nodeid for result in choose_tests(results, {"t0": 0, "t2": 1}, None)] == ["t0"]


def test_what_was_ended_by_real_time_is_audited_only_if_asked_for() -> None:
    hangs = Kind("error", errors=("no time has passed for 8 s of work, at arm.py:12",))
    assert names(in_order(hangs, Kind(), hangs, hangs)) == ["t1"]
    assert len(names(in_order(hangs, Kind(), hangs, hangs), 4)) == 4
