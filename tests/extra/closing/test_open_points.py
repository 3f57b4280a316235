"""Which runs came near to a point."""

from __future__ import annotations

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.open_points import closest_runs
from pytest_hricdv.generate.abstract import AbstractTest

LINES: list[Point] = [("statement", "robot.py", str(line)) for line in range(1, 9)]
EXIT: Point = ("branch", "robot.py", "2", "8")


def archive(*runs: tuple[int, ...]) -> Archive:
    """After runs that executed these lines."""
    found = Archive([*LINES, EXIT, ("plan", "person", "asks")])
    for number, lines in enumerate(runs):
        test = AbstractTest(f"test-{number}", "closure", "robot", (), ("go",), seed=number)
        found.add(RunObservation(test.to_data(), tuple(LINES[line - 1] for line in lines)))
    return found


def order(point: Point, *runs: tuple[int, ...]) -> list[int]:
    """The numbers of the runs that came near, the nearest first."""
    return [entry.number for _, entry in closest_runs(point, archive(*runs))]


def test_near_to_a_branch_are_runs_that_executed_the_line_it_leads_away_from() -> None:
    assert order(EXIT, (1,), (1, 2), (1, 2)) == [1, 2]


def test_near_to_a_statement_are_runs_that_executed_the_last_one_before_it() -> None:
    assert order(LINES[6], (1, 2), (1, 2, 5), (1, 2, 8)) == [1]


def test_from_a_plan_no_distance_is_known() -> None:
    assert not order(("plan", "person", "asks"), (1, 2))
