"""What is said of a search for schedules: what was run, and what was not."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.schedules.records import OTHERWISE, SCHEDULES, RaceRecord, ScheduleResult
from pytest_hricdv.extra.schedules.view import VIEW, describe_effort, title
from tests.report import sample
from tests.report.test_html import render

DONE = ScheduleResult(runs=20, tests=3, slowest_s=0.05, pairs=5, both=4)
RACE = RaceRecord(
    requirement="R1",
    test="rl-a",
    failure_kind="wrong-order",
    words="arm waits before arm.py:17",
    least_s=0.01,
    is_counted=True,
    found_after=2,
)


@pytest.mark.parametrize(
    ("result", "said"),
    [
        (DONE, "20 runs of 3 tests, 4 of 5 pairs of statements in either order, nodes held up for 0.05 s at most"),
        (replace(DONE, lost=1, left_out=2), f"1 run did not end; 2 tests left out: {OTHERWISE}"),
        (
            replace(DONE, runs=0, tests=0, left_out=2, end_reason="nothing to order"),
            "nothing was run: 2 tests left out",
        ),
        (replace(DONE, runs=0, end_reason="nothing to order"), "nothing to order: in no run did two threads"),
        (replace(DONE, end_reason="interrupted"), "; interrupted"),
    ],
)
def test_it_says_what_was_run_and_what_was_not(result: ScheduleResult, said: str) -> None:
    assert said in describe_effort(result)
    report = SCHEDULES.put(sample.report(tests=1), result)
    (line,) = VIEW.findings(report)
    is_whole = result.tests > 0 and not (result.lost or result.left_out)
    assert line.style == ("ok" if is_whole else "warn")


def test_a_race_is_titled_by_what_fails() -> None:
    assert title(RACE) == "R1 of rl-a fails in the wrong order"
    late = replace(RACE, failure_kind="late", is_counted=False)
    assert title(late).startswith("R1 of rl-a fails if the code is 0.01 s late; listed only")
    assert title(replace(RACE, requirement="", fault="deadlock: a waits")) == "rl-a: deadlock: a waits"
    page = render(SCHEDULES.put(sample.report(tests=1), replace(DONE, races=(RACE,), open=("a.py:1 before a.py:2",))))
    assert "R1 of rl-a fails in the wrong order" in page
    assert "a.py:1 before a.py:2" in page
