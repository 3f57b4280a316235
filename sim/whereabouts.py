"""Where arm, hand and leg are, as signals for requirements: the world's own view, whatever the controller reports."""

from __future__ import annotations

import math
from collections.abc import Callable

from sim.geometry import UPRIGHT, Vector
from sim.gripper import GRASP_HEIGHT_M, GRASP_POINT_M, offset_of
from sim.layout import BIN_HEIGHT_M, BIN_M, HANDOVER_M, PICKUP_M, in_bin
from sim.leg_supply import LegSupply
from sim.torso import Torso

NEAR_M = 0.05
"""The hand is at a place when the middle of its grasp is this near to where it is meant to be."""

HOME_RAD = 0.02
"""The arm is at home when every joint is this near to 0."""

HEIGHT_DIGITS = 3
"""Heights are recorded to a millimetre."""

PICKUP, HANDOVER, RESUPPLY, ELSEWHERE = "pickup", "handover", "resupply", "elsewhere"
HAND_PLACES = (PICKUP, HANDOVER, RESUPPLY, ELSEWHERE)
"""Values of the signal `hand_place`."""

GRASP_PLACES = tuple(
    (name, (x, y, z + GRASP_HEIGHT_M)) for name, (x, y, z) in ((PICKUP, PICKUP_M), (HANDOVER, HANDOVER_M))
)
"""Where the grasp point is (m) when the hand is at a place."""

Signal = Callable[[str, float | bool | str], None]


class Whereabouts:
    """Records the signals `arm_home`, `hand_place`, `leg_offset`, `leg_height`, `leg_in_bin`, `leg_taken`."""

    def __init__(self, torso: Torso, legs: LegSupply, signal: Signal) -> None:
        self._torso = torso
        self._legs = legs
        self._signal = signal

    def tick(self) -> None:
        """Record what has changed; once every control tick while anything moves."""
        leg = self._legs.current
        place = leg.pose()[0]
        self._signal("arm_home", all(abs(angle) < HOME_RAD for angle in self._torso.arm_angles()))
        self._signal("hand_place", hand_place(self.grasp_point()))
        self._signal("leg_offset", offset_of(place))
        self._signal("leg_height", round(place[2], HEIGHT_DIGITS))
        self._signal("leg_in_bin", in_bin(place))
        self._signal("leg_taken", self._legs.carried is not None)

    def grasp_point(self) -> Vector:
        """Middle of the hand's grasp (m)."""
        return self._torso.from_palm((GRASP_POINT_M, UPRIGHT))[0]


def hand_place(grasp_point: Vector) -> str:
    """The place in the workshop, one of `HAND_PLACES`, where a hand with this grasp point (m) is."""
    for name, place in GRASP_PLACES:
        if math.dist(grasp_point, place) < NEAR_M:
            return name
    # Over the bin, however high: what it lets go of falls inside.
    return RESUPPLY if in_bin((grasp_point[0], grasp_point[1], BIN_M[2] + BIN_HEIGHT_M / 2)) else ELSEWHERE
