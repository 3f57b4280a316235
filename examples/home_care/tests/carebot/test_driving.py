"""Driving past those who stand close to the robot."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from math import cos, hypot, inf, pi, sin, sqrt

import pytest
from carebot import driving
from carebot.config import Config
from carebot.driving import Driver
from carebot.flatmap import CHARGER, HULL_M, PLACES, SEAT, SINK, FlatMap
from carebot.messages import Pose, Scan, Velocity

PERIOD_S = 0.001
FASTER = 200
"""By so much, for a period that is so much shorter than the robot's own: each period's way stays what it is."""

PERSON, PERSON_M = (-1.218, 1.002), 0.22
"""Who has walked up to the robot, and their radius."""

IN_THE_DOORWAY = (((-1.0, -0.9), 0.22), ((0.43, -0.7), 0.2))
"""A person and a dog, with their radii: the way beside the one leads past the other, or around the first."""

RAYS = 720


class PlainBase:
    """It does at once what it is told for one period, and sees people, as discs, and nothing else."""

    def __init__(self, pose: Pose, people: Sequence[tuple[tuple[float, float], float]]) -> None:
        self.at = pose
        self.driven_m = 0.0
        self.speeds_m_s: list[tuple[Pose, float]] = []
        self._people = people

    def pose(self) -> Pose:
        return self.at

    def drive(self, velocity: Velocity) -> None:
        x, y, heading = self.at.x, self.at.y, self.at.heading + velocity.turn * PERIOD_S
        ahead_m = velocity.forward * PERIOD_S
        self.at = Pose(x + ahead_m * cos(heading), y + ahead_m * sin(heading), heading)
        self.driven_m += ahead_m
        self.speeds_m_s.append((self.at, velocity.forward / FASTER))

    def scan(self) -> Scan:
        return Scan(tuple(self._range_m(self.at.heading - pi + 2 * pi * ray / RAYS) for ray in range(RAYS)))

    def _range_m(self, bearing: float) -> float:
        return min(self._range_to(*person, bearing) for person in self._people)

    def _range_to(self, at: tuple[float, float], radius_m: float, bearing: float) -> float:
        dx, dy = at[0] - self.at.x, at[1] - self.at.y
        ahead_m, aside_m = dx * cos(bearing) + dy * sin(bearing), dx * sin(bearing) - dy * cos(bearing)
        if ahead_m <= 0 or abs(aside_m) >= radius_m:
            return inf
        return ahead_m - sqrt(radius_m**2 - aside_m**2)


@pytest.mark.parametrize("heading", [1.75, 2.0, 2.16, 2.24, 2.5, 3.0])
def test_it_turns_from_somebody_ahead_to_a_way_beside_them(monkeypatch: pytest.MonkeyPatch, heading: float) -> None:
    """Half turned to its way it took the person for in it, stood, and found the same way again."""
    drive(PlainBase(Pose(-0.664, 0.999, heading), [(PERSON, PERSON_M)]), SINK, monkeypatch)


@pytest.mark.parametrize("heading", [0.0, 1.5, 3.0])
def test_it_does_not_go_back_and_forth_between_two(monkeypatch: pytest.MonkeyPatch, heading: float) -> None:
    """Near to the one it forgot the other, to whom its way led then."""
    base = PlainBase(Pose(-0.95, -1.74, heading), IN_THE_DOORWAY)
    drive(base, CHARGER, monkeypatch)
    assert base.driven_m < 8.0  # it was 10.5 m: back to the person, and to the dog once more


def test_it_is_slow_beside_the_seat(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who sits there is a part of the sofa to the laser; it drove off at full speed."""
    monkeypatch.setattr(driving, "SLOW_AFTER_S", 5 * PERIOD_S)
    base = PlainBase(Pose(-2.95, -3.3, 0.5), [(PERSON, PERSON_M)])
    drive(base, CHARGER, monkeypatch)
    beside = [speed for at, speed in base.speeds_m_s if hypot(at.x - SEAT[0], at.y - SEAT[1]) < 0.6 + HULL_M + 0.23]
    assert 0.0 < max(beside) < 0.15
    assert max(speed for _, speed in base.speeds_m_s) > 0.2


def drive(base: PlainBase, place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It arrives at a place, within the time for it."""
    monkeypatch.setattr(driving, "STOPS_S", 5 * PERIOD_S)
    monkeypatch.setattr(driving, "LOOK_AGAIN_S", 10 * PERIOD_S)
    config = Config(
        speed_m_s=0.24 * FASTER,
        near_speed_m_s=0.12 * FASTER,
        turn_rad_s=0.5 * FASTER,
        period_s=PERIOD_S,
        patience_s=5 * PERIOD_S,
        give_up_s=10.0,
    )
    asyncio.run(Driver(base, FlatMap(), config).drive_to(PLACES[place]))
    assert hypot(base.at.x - PLACES[place][0], base.at.y - PLACES[place][1]) < 0.1
