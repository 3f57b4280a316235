"""How often a hand that rests over the shared table is too near to the robot's closing hand."""

from __future__ import annotations

import random

import pytest

from controller import waypoints
from pytest_hricdv.runtime import Recorder
from sim.fingers import CLOSED, OPEN
from sim.geometry import UPRIGHT
from sim.layout import REST_HIGH_M, REST_LOW_M, TABLE_TOP_M
from sim.person import HAND_HALF_M
from sim.world import World

from .stage import Stage, handover, one_leg

TOO_CLOSE_M = 0.05


def test_about_three_in_a_hundred_rest_within_5_cm_of_the_closing_hand_and_none_inside_it() -> None:
    draw = random.Random(2)
    nearest = []
    with World(Recorder()) as world:
        torso, hand = world.torso, world.person.hand.body
        torso.set_arm(waypoints.TO_PICKUP[-1])
        world.fingers.follow(torso.palm_pose())
        places = [
            tuple(draw.uniform(low, high) for low, high in zip(REST_LOW_M, REST_HIGH_M, strict=True))
            for _ in range(4000)
        ]
        for share in (0.0, 0.5, 1.0):
            world.fingers.drive.reset([a + share * (b - a) for a, b in zip(OPEN, CLOSED, strict=True)])
            distances = []
            for x, y, z in places:
                world.engine.place(hand, ((x, y, z), UPRIGHT))
                distances.append(world.gripper.human_distance())
            nearest.append(distances)
    smallest = [min(each) for each in zip(*nearest, strict=True)]
    assert 0.02 < sum(distance < TOO_CLOSE_M for distance in smallest) / len(smallest) < 0.04
    assert min(smallest) > 0.0
    assert REST_LOW_M[2] - HAND_HALF_M[2] > TABLE_TOP_M


@pytest.mark.parametrize(
    ("rest", "near"), [((0.475, -0.30, 0.62), True), ((0.70, 0.05, 0.47), False)], ids=["stray", "own side"]
)
def test_a_stray_hand_shows_as_a_small_distance_while_the_robot_closes(
    rest: tuple[float, float, float], near: bool
) -> None:
    where = dict(zip(("rest_x_m", "rest_y_m", "rest_z_m"), rest, strict=True))
    record, _ = handover(one_leg(rest=where), turns=1)
    times, distances = record.signals["hand_distance"]
    began_s, ended_s = record.signals["hand_closing"][0][1:]
    closing = [d for t, d in zip(times, distances, strict=True) if began_s <= t <= ended_s]
    assert (min(closing) < TOO_CLOSE_M) == near


def test_a_hand_far_away_does_not_count() -> None:
    with Stage() as stage:
        assert stage.world.gripper.human_distance() > 0.5
