"""The robot's hand and the person's: how near they are, and how the fingers press on a hand that is between them."""

from __future__ import annotations

from sim.engine import FAR_M, Engine, bullet
from sim.fingers import Fingers
from sim.torso import Torso

FLESH_N_M = 1500.0
FLESH_MAX_N = 30.0
"""A person's hand gives way like a one-sided spring: 5 mm under the 8 N that a finger's motor presses with. Softer than
the 75 N/mm of ISO/TS 15066 for the back of a hand, which a finger of a few grams at 120 steps a second could not stand;
a finger is stopped by it all the same. The force is bounded for a finger that has a hand inside it from the start."""


class Touch:
    """Distances and forces between the robot's left hand and the person's hand (a body)."""

    def __init__(self, engine: Engine, torso: Torso, fingers: Fingers, hand: int) -> None:
        self._engine = engine
        self._torso = torso
        self._fingers = fingers
        self._hand = hand
        self.force_n = 0.0

    def distance(self) -> float:
        """Smallest distance (m, to a micrometre) between the person's hand and the robot's palm and fingers."""
        fingers = self._engine.distance_to_all(self._hand, self._fingers.body)
        return round(min(fingers, self._engine.distance(self._hand, self._torso.body, self._torso.palm)), 6)

    def press(self) -> None:
        """The person's hand pushes fingers back that are in it, for the next physics step; `force_n` is the sum (N)."""
        self.force_n = 0.0
        for link in self._fingers.links:
            depth_m, place, away = self._deepest(link)
            if depth_m > 0.0:
                force_n = min(FLESH_MAX_N, FLESH_N_M * depth_m)
                self._fingers.push_at(link, tuple(force_n * part for part in away), place)
                self.force_n += force_n

    def _deepest(self, link: int) -> tuple[float, tuple[float, ...], tuple[float, ...]]:
        """How deep (m) a finger link is in the hand, where, and which way out."""
        points = bullet.getClosestPoints(
            self._fingers.body, self._hand, FAR_M, link, -1, physicsClientId=self._engine.client
        )
        point = min(points, key=lambda each: float(each[8]))
        return -float(point[8]), point[5], point[7]
