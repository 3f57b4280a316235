"""The robot's base, and what it touches."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from house.flat import ROBOT
from house.shapes import Point
from house.walkers import Dog, Person

RADIUS_M = 0.27
"""Of the base, which is round: TIAGo's has a diameter of 0.54 m by its data sheet."""

MASS_KG = 70.0
"""Of the robot with its arm, by its data sheet about 72 kg (rounded)."""

FASTEST_M_S, FASTEST_RAD_S = 1.0, 2.0
"""Limits of the motors: what is beyond is cut off. The published code drives 0.25 m/s and 0.5 rad/s (chosen)."""

PUSHES_N = 120.0
"""What the wheels push with when something is in the way: two motors of 6 N m at wheels of 0.0985 m radius, as the
maker's public description of the base has them, rounded."""


class Body(NamedTuple):
    """What is touched: effective mass (kg) and stiffness (N/m)."""

    mass_kg: float
    stiffness_n_m: float


BODIES = {
    "wall": Body(math.inf, 100_000.0),  # chosen: a plastic cover gives way by some mm
    "furniture": Body(math.inf, 100_000.0),  # as a wall: it stands against one
    "person": Body(75.0, 60_000.0),  # ISO/TS 15066:2016, table A.3: lower legs, which the base meets
    "dog": Body(10.0, 25_000.0),  # chosen: a dog of this size; as a person's chest, 25 N/mm in the same table
}


class Contact(NamedTuple):
    """What the robot touches, a key of `BODIES`, or "nothing"; and the greatest force since the last step (N)."""

    with_what: str
    force_n: float


FREE = Contact("nothing", 0.0)


class Base:
    """Where the base is, how it moves, and what it is told."""

    radius_m = RADIUS_M

    def __init__(self) -> None:
        self.at: Point = ROBOT.at
        self.heading_rad = ROBOT.heading_rad
        self.forward_m_s = self.turn_rad_s = 0.0
        """As told, within the limits."""
        self.speed_m_s = self.turning_rad_s = 0.0
        """In the last step, as it moved."""

    def told(self, forward_m_s: float, turn_rad_s: float) -> None:
        """Go on with this velocity."""
        self.forward_m_s = min(max(forward_m_s, -FASTEST_M_S), FASTEST_M_S)
        self.turn_rad_s = min(max(turn_rad_s, -FASTEST_RAD_S), FASTEST_RAD_S)

    @property
    def resting(self) -> bool:
        """Whether it does not move, and is not to."""
        return self.forward_m_s == self.turn_rad_s == self.speed_m_s == self.turning_rad_s == 0.0


class Mechanics(Protocol):
    """How the base moves: the seam between the fidelities."""

    def step(self, base: Base, person: Person, dog: Dog, duration_s: float) -> Contact:
        """Let the base move for a while as it is told; the walkers have moved already."""

    def moved(self, base: Base) -> None:
        """The base was set somewhere else."""


def impact_n(speed_m_s: float, body: Body) -> float:
    """The greatest force of an impact: ISO/TS 15066:2016, A.3.4, F = v sqrt(mu k), mu the reduced mass.

    Args:
        speed_m_s: at which both approach each other, along the normal of the contact.
        body: what the robot meets.
    """
    reduced_kg = 1.0 / (1.0 / MASS_KG + 1.0 / body.mass_kg)
    return speed_m_s * math.sqrt(reduced_kg * body.stiffness_n_m)
