"""Faults that no requirement of the paper speaks of, each caught by the requirement that does."""

from __future__ import annotations

import pytest

from controller import fetching, machine, waypoints
from controller.robot import Robot
from tests.hri import bench


def test_a_leg_that_is_swung_along_the_table_fails_r29(monkeypatch: pytest.MonkeyPatch) -> None:
    brings = waypoints.TO_HANDOVER[1:]
    assert bench.run(bench.concrete(bench.leg())).verdict("R29").verdict == "Passed"
    monkeypatch.setattr(fetching, "TO_HANDOVER", brings)
    verdict = bench.run(bench.concrete(bench.leg())).verdict("R29")
    (violation,) = verdict.violations
    assert (verdict.verdict, verdict.triggers) == ("Failed", 1)
    assert bench.number(violation, "leg_height") < 0.65
    assert violation.values["leg_offset"] == pytest.approx(0.45, abs=0.02)


@pytest.mark.slow
def test_a_table_whose_reported_duration_is_not_the_observed_one_fails_r30(monkeypatch: pytest.MonkeyPatch) -> None:
    four = bench.concrete(["tell leg", "receivesignal"] * 4)
    assert bench.run(four).verdict("R30").verdict == "Passed"

    def begins_at_the_first_request(robot: Robot) -> str:
        if not robot.journal.turns:
            robot.journal.began_s = robot.clock.now_s()
        return fetching.move_hand(robot)

    monkeypatch.setitem(machine.STATES, "Move_hand", begins_at_the_first_request)
    verdict = bench.run(four).verdict("R30")
    assert (verdict.verdict, verdict.triggers) == ("Failed", 1)
    assert verdict.margin is not None
    assert -5.0 < verdict.margin < -2.0  # a person asks after 3 to 5 s
