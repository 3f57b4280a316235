"""Driving past somebody who stands close to the robot."""

from __future__ import annotations

import asyncio
from math import cos, hypot, inf, pi, sin, sqrt

import pytest
from carebot import driving
from carebot.config import Config
from carebot.driving import Driver
from carebot.flatmap import PLACES, SINK, FlatMap
from carebot.messages import Pose, Scan, Velocity

PERIOD_S = 0.001
FASTER = 200
"""By so much, for a period that is so much shorter than the robot's own: each period's way stays what it is."""

PERSON, PERSON_M = (-1.218, 1.002), 0.22
"""Who has walked up to the robot, and their radius."""

RAYS = 720


class PlainBase:
    """It does at once what it is told for one period, and sees the person and nothing else."""

    def __init__(self, pose: Pose) -> None:
        self.at = pose

    def pose(self) -> Pose:
        return self.at

    def drive(self, velocity: Velocity) -> None:
        x, y, heading = self.at.x, self.at.y, self.at.heading + velocity.turn * PERIOD_S
        ahead_m = velocity.forward * PERIOD_S
        self.at = Pose(x + ahead_m * cos(heading), y + ahead_m * sin(heading), heading)

    def scan(self) -> Scan:
        return Scan(tuple(self._range_m(self.at.heading - pi + 2 * pi * ray / RAYS) for ray in range(RAYS)))

    def _range_m(self, bearing: float) -> float:
        dx, dy = PERSON[0] - self.at.x, PERSON[1] - self.at.y
        ahead_m, aside_m = dx * cos(bearing) + dy * sin(bearing), dx * sin(bearing) - dy * cos(bearing)
        if ahead_m <= 0 or abs(aside_m) >= PERSON_M:
            return inf
        return ahead_m - sqrt(PERSON_M**2 - aside_m**2)


@pytest.mark.parametrize("heading", [1.75, 2.0, 2.16, 2.24, 2.5, 3.0])
def test_it_turns_from_somebody_ahead_to_a_way_beside_them(monkeypatch: pytest.MonkeyPatch, heading: float) -> None:
    """Half turned to its way it took the person for in it, stood, and found the same way again."""
    monkeypatch.setattr(driving, "STOPS_S", 5 * PERIOD_S)
    config = Config(
        speed_m_s=0.24 * FASTER,
        near_speed_m_s=0.12 * FASTER,
        turn_rad_s=0.5 * FASTER,
        period_s=PERIOD_S,
        patience_s=5 * PERIOD_S,
        give_up_s=10.0,
    )
    base = PlainBase(Pose(-0.664, 0.999, heading))
    asyncio.run(Driver(base, FlatMap(), config).drive_to(PLACES[SINK]))
    assert hypot(base.at.x - PLACES[SINK][0], base.at.y - PLACES[SINK][1]) < 0.1
