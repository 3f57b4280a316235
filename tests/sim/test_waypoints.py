"""The taught poses meet the places of the workshop."""

from __future__ import annotations

import math

import pytest

from controller import waypoints
from sim.layout import HANDOVER_M, PICKUP_M, in_bin
from sim.rotation import matrix_of

from .stage import Stage


def test_the_leg_is_upright_at_the_handover_place_and_over_the_bin() -> None:
    with Stage() as stage:
        leg = stage.world.legs.current

        def look() -> None:
            assert stage.fetch()
            assert math.dist(leg.pose()[0], HANDOVER_M) < 0.002
            assert _tilt_deg(leg.pose()[1]) < 1.0
            arm = stage.robot.arm
            assert arm.follow(arm.plan(waypoints.TO_RESUPPLY, 0.25))
            x, y, z = leg.pose()[0]
            assert in_bin((x, y, z - 0.4))
            assert z == pytest.approx(HANDOVER_M[2], abs=0.01)

        assert stage.run(look) == "over"


def test_the_leg_stays_upright_on_its_way_up_from_the_pickup_place() -> None:
    with Stage() as stage:
        leg = stage.world.legs.current

        def lift() -> None:
            arm = stage.robot.arm
            assert arm.follow(arm.plan(waypoints.TO_PICKUP, 0.25))
            assert stage.robot.hand.close()
            assert leg.pose()[0] == pytest.approx(PICKUP_M, abs=1e-3)
            path = arm.plan(waypoints.TO_HANDOVER[:1], 0.25)

            def rise() -> None:
                arm.follow(path)

            stage.kernel.spawn("arm", rise)
            for _ in range(16):
                stage.kernel.sleep(path.duration_s / 16)
                assert _tilt_deg(leg.pose()[1]) < 2.0

        assert stage.run(lift) == "over"


def _tilt_deg(turn: tuple[float, float, float, float]) -> float:
    return math.degrees(math.acos(min(1.0, matrix_of(turn)[8])))
