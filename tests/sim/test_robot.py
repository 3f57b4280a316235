"""Measured joint speeds, arrival, and the ports of the robot."""

from __future__ import annotations

from itertools import pairwise

import pytest

from controller import waypoints
from controller.ports import JointPose
from sim.timing import MAX_ACCELERATION_RAD_S2, SPEED_SHARE

from .stage import Stage


@pytest.mark.parametrize("allowed_rad_s", [0.10, 0.25, 0.30])
def test_measured_speed_is_the_planned_one(allowed_rad_s: float) -> None:
    with Stage() as stage:
        stage.run(lambda: assert_true(stage.fetch(allowed_rad_s)))
        speeds = stage.recorder.finish().signals["arm_speed"][1]
    assert max(speeds) == pytest.approx(SPEED_SHARE * allowed_rad_s, rel=0.01)
    assert (max(speeds) < 0.25) == (allowed_rad_s <= 0.25)


def test_the_arm_speeds_up_and_slows_down_within_the_planned_acceleration() -> None:
    with Stage(freeze=False) as stage:
        arm = stage.robot.arm
        stage.run(lambda: assert_true(arm.follow(arm.plan(waypoints.TO_PICKUP, 0.25))))
        speeds = stage.recorder.finish().signals["arm_speed"][1]
    rises = [(b - a) * 120 for a, b in pairwise(speeds)]
    assert max(rises) == pytest.approx(MAX_ACCELERATION_RAD_S2, rel=0.1)
    assert min(rises) > -2.0 * MAX_ACCELERATION_RAD_S2  # the last bit is the position control's own


def test_a_detour_is_followed_below_the_speed_limit() -> None:
    goal: JointPose = (-0.95, 0.04, 0.5, 0.0, 0.81, 0.44, 0.32, 0.05, -0.77)
    with Stage() as stage:
        arm = stage.robot.arm

        def around() -> None:
            assert arm.follow(arm.plan(waypoints.TO_HANDOVER, 0.25))
            path = arm.plan((goal,), 0.25)
            assert len(path.segments) > 1
            assert arm.follow(path)
            assert stage.world.torso.stands_at(goal, 0.001)

        assert stage.run(around) == "over"
        assert max(stage.recorder.finish().signals["arm_speed"][1]) < 0.245


def test_follow_blocks_until_the_arm_stands_at_the_end() -> None:
    with Stage() as stage:
        arm, torso = stage.robot.arm, stage.world.torso

        def there_and_back() -> None:
            path = arm.plan(waypoints.TO_PICKUP, 0.25)
            began_s = stage.kernel.now_s
            assert arm.follow(path)
            assert torso.stands_at(waypoints.TO_PICKUP[-1], 0.001)
            assert stage.kernel.now_s - began_s == pytest.approx(path.duration_s, abs=0.5)
            assert arm.follow(arm.plan((waypoints.HOME,), 0.25))
            assert torso.stands_at(waypoints.HOME, 0.001)

        assert stage.run(there_and_back) == "over"


def test_an_arm_that_is_held_up_does_not_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    with Stage() as stage:
        arm, torso = stage.robot.arm, stage.world.torso
        slow_motors = torso.move_arm

        def held_up() -> None:
            path = arm.plan((waypoints.TO_PICKUP[0],), 0.25)
            monkeypatch.setattr(
                torso, "move_arm", lambda goal, duration_s, ramp_s: slow_motors(goal, 100 * duration_s, ramp_s)
            )
            assert not arm.follow(path)

        assert stage.run(held_up) == "over"


def test_a_path_is_followed_only_from_its_start() -> None:
    """From elsewhere the arm would have further to go in the same time: too fast."""
    with Stage() as stage:
        arm, torso = stage.robot.arm, stage.world.torso

        def from_elsewhere() -> None:
            back = arm.plan((waypoints.HOME,), 0.25)
            assert arm.follow(arm.plan((waypoints.TO_PICKUP[0],), 0.25))
            assert not arm.follow(back)
            assert torso.stands_at(waypoints.TO_PICKUP[0], 0.001)

        assert stage.run(from_elsewhere) == "over"


def assert_true(value: bool) -> None:
    assert value
