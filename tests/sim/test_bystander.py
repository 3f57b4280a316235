"""Somebody in the arm's way: ways are refused, and a moving arm stops."""

from __future__ import annotations

import pytest

from controller.ports import PlanningError
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP, TO_RESUPPLY
from sim.bystander import ROOM_M, STOP_M
from sim.disturbances import PLACES
from sim.planner import CLEARANCE_M, find_path

from .stage import Stage


def test_no_way_leads_through_people_or_around_them() -> None:
    start = TO_PICKUP[-1]
    assert find_path(start, TO_HANDOVER) == TO_HANDOVER
    with pytest.raises(PlanningError, match=r"comes within 0\.\d+ m of a person"):
        find_path(start, TO_HANDOVER, [PLACES["pickup"]])
    between = (0.42, 0.40, 0.80)
    assert find_path(TO_HANDOVER[-1], TO_RESUPPLY) == TO_RESUPPLY
    with pytest.raises(PlanningError, match="no way leads around people"):
        find_path(TO_HANDOVER[-1], TO_RESUPPLY, [between])
    assert find_path(start, TO_HANDOVER, [PLACES["resupply"]]) == TO_HANDOVER
    assert ROOM_M > CLEARANCE_M > STOP_M


def test_nobody_leans_in_where_the_arm_is() -> None:
    with Stage() as stage:
        bystander = stage.world.bystander
        assert not bystander.lean_in(PLACES["home"])
        assert not bystander.places
        assert bystander.lean_in(PLACES["pickup"])
        assert bystander.places == (PLACES["pickup"],)


def test_an_arm_stops_before_somebody_who_leans_in_and_goes_on_when_nobody_is_there() -> None:
    with Stage() as stage:
        arm, world = stage.robot.arm, stage.world

        def body() -> None:
            way = arm.plan(TO_PICKUP, 0.25)
            world.bystander.lean_in(PLACES["pickup"])
            assert not arm.follow(way)
            stopped = world.torso.arm_angles()
            stage.kernel.sleep(5.0)
            assert world.torso.stands_at(stopped, 1e-3)
            with pytest.raises(PlanningError, match="a person"):
                arm.plan(TO_PICKUP, 0.25)
            world.bystander.lean_out()
            assert arm.follow(arm.plan([HOME], 0.25))

        assert stage.run(body) == "over"
        speeds = stage.recorder.finish().signals["arm_speed"][1]
    assert max(speeds) < 0.25
