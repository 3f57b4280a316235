"""The table's known violations: no crush prevention while it fetches, and a release that a person's grip delays."""

from __future__ import annotations

import pytest

from controller import finishing, machine
from controller.robot import Robot
from pytest_hricdv.execution.case import CaseResult
from sim.layout import PICKUP_M
from tests.hri import bench


def marks(result: CaseResult, requirement: str) -> list[bool]:
    """Of each violation, whether it is outside of the condition under which it is known."""
    assert requirement in result.failed
    return [violation.outside for violation in result.verdict(requirement).violations]


def test_a_hand_that_closes_on_the_person_while_it_fetches_is_known() -> None:
    x, y, z = PICKUP_M
    result = bench.run(bench.concrete(bench.leg(), rest_x_m=x, rest_y_m=y, rest_z_m=z))
    assert marks(result, "R3") == [False]


def test_a_hand_that_closes_on_the_person_after_a_release_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    retreat = finishing.retreat

    def closing(robot: Robot) -> None:
        robot.hand.close()
        retreat(robot)

    monkeypatch.setattr(finishing, "retreat", closing)
    result = bench.run(bench.concrete(bench.leg(), dx_m=0.0, dy_m=0.0, dz_m=0.0))
    assert marks(result, "R3") == [True]


@pytest.mark.parametrize("grip_s", [9.8, 14.0])
def test_a_release_that_a_grip_delays_is_known(grip_s: float) -> None:
    result = bench.run(bench.concrete(bench.leg(), grip_s=grip_s))
    assert marks(result, "R1") == [False]
    assert [bool(gripped) for gripped in result.record.signals["hand_gripped"][1]] == [False, True, False]


def test_a_robot_that_is_slow_without_a_grip_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    release = finishing.release

    def slow(robot: Robot) -> str:
        robot.clock.sleep(11.0)
        return release(robot)

    monkeypatch.setitem(machine.STATES, "Release", slow)
    assert marks(bench.run(bench.concrete(bench.leg())), "R1") == [True]
