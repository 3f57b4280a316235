"""Which violations a film is about."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.film.film_maker import alarms_of
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor.verdict import Verdict, Violation
from pytest_hricdv.runtime import Record
from pytest_hricdv.testbench import Outcome


def verdict(requirement: str, times_s: Sequence[float], outside: bool = False) -> Verdict:
    violations = tuple(Violation(time_s, time_s, {}, None, outside=outside) for time_s in times_s)
    return Verdict(
        requirement=requirement,
        verdict="Failed" if times_s else "Passed",
        triggers=1,
        passes=0,
        failures=len(times_s),
        untriggered=0,
        pending=0,
        violations=violations,
        margin=None,
        margin_time_s=None,
    )


@pytest.mark.parametrize(
    ("known", "outside", "shown"),
    [
        ((), False, [("A4", 2.0), ("R1", 5.0), ("A4", 8.0)]),
        (("A4",), False, [("R1", 5.0)]),  # what is known is not what the test failed for
        (("A4",), True, [("A4", 2.0), ("R1", 5.0), ("A4", 8.0)]),  # outside of its condition, it is
        (("A4", "R1"), False, [("A4", 2.0), ("R1", 5.0), ("A4", 8.0)]),  # there is nothing else to show
    ],
)
def test_known_violations_are_shown_only_where_there_are_no_others(
    known: tuple[str, ...], outside: bool, shown: list[tuple[str, float]]
) -> None:
    result = CaseResult(
        test=ConcreteTest("t", "s", 1, ()),
        outcome=Outcome("done"),
        record=Record((), {}, "hash"),
        sim_s=9.0,
        verdicts=(verdict("A4", (8.0, 2.0), outside), verdict("R1", (5.0,)), verdict("R2", ())),
        code=None,
    )
    assert [(alarm.requirement, alarm.time_s) for alarm in alarms_of(result, known)] == shown
