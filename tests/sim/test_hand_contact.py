"""Fingers that close on a person's hand are stopped by it, and the force shows; beside it they close as ever."""

from __future__ import annotations

import pytest

from controller import waypoints
from sim.fingers import CLOSED, HAND_MAX_FORCE_N
from sim.geometry import Vector

from .stage import Stage

BETWEEN: Vector = (0.38, -0.30, 0.62)
OWN_SIDE: Vector = (0.70, 0.0, 0.60)
LINKS = 10


def closing_with_a_hand_at(place: Vector) -> tuple[Stage, bool, bool]:
    """The stage after closing with the person's hand at a place and once more when it is away; was a leg held then?"""
    held: list[bool] = []
    with Stage() as stage:

        def body() -> None:
            arm, hand = stage.robot.arm, stage.world.person.hand
            assert arm.follow(arm.plan(waypoints.TO_PICKUP, 0.25))
            stage.kernel.sleep(hand.move(place))
            held.append(stage.robot.hand.close())
            if not held[0]:
                assert max(abs(a - c) for a, c in zip(stage.world.fingers.angles(), CLOSED, strict=True)) > 0.1
                stage.robot.hand.open()
            stage.kernel.sleep(hand.move(OWN_SIDE))
            held.append(stage.robot.hand.close())

        assert stage.run(body) == "over"
        return stage, held[0], held[1]


def test_a_hand_between_the_fingers_stops_them_and_its_force_shows_while_they_close() -> None:
    stage, held, held_then = closing_with_a_hand_at(BETWEEN)
    assert not held
    assert held_then  # nothing is left of it
    signals = stage.recorder.finish().signals
    times, forces = signals["hand_contact_force"]
    assert 5.0 < max(forces) <= LINKS * HAND_MAX_FORCE_N
    began_s, ended_s = signals["hand_closing"][0][1:3]
    assert all(began_s <= at <= ended_s for at, force in zip(times, forces, strict=True) if force > 0.0)
    assert forces[-1] == 0.0
    assert min(signals["hand_distance"][1]) < 0.0


@pytest.mark.parametrize("place", [(0.40, -0.28, 0.62), (0.41, -0.3, 0.64), (0.30, -0.30, 0.60), (0.20, -0.30, 0.62)])
def test_wherever_the_hand_is_the_forces_stay_those_of_fingers(place: Vector) -> None:
    stage, _, held_then = closing_with_a_hand_at(place)
    assert held_then
    assert 0.0 < max(stage.recorder.finish().signals["hand_contact_force"][1]) < 40.0
