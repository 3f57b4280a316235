"""What the robot's fingers feel: the change of the held leg's force on the palm."""

from __future__ import annotations

import math

from sim.engine import Vector
from sim.leg_supply import LegSupply

PRESSURE_N = 3.0
"""A change of more than this is a person who pulls: half of the lightest pull (6 N)."""


class PressureSensor:
    """Force change at the palm, tared whenever the arm or the hand has come to rest with a leg."""

    def __init__(self, legs: LegSupply) -> None:
        self._legs = legs
        self._rest: Vector = (0.0, 0.0, 0.0)

    def tare(self) -> None:
        """Take what is felt now as the rest value; without effect when no leg is held."""
        leg = self._legs.in_hand
        if leg is not None:
            self._rest = leg.reaction()

    def change_n(self) -> float:
        """How much the reaction (N) differs from its rest value; 0 when no leg is held."""
        leg = self._legs.in_hand
        return 0.0 if leg is None else math.dist(leg.reaction(), self._rest)
