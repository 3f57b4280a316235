"""The robot's map of the flat: what stands where, and where its own places are. All lengths in m."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

HULL_M = 0.27
"""Radius of the base (PAL TIAGo: 54 cm across)."""

CHARGER, FRIDGE, SINK, TABLE = "charger", "fridge", "sink", "table"

PLACES = {
    CHARGER: (1.35, 0.015),
    FRIDGE: (-2.8, 0.405),
    SINK: (-2.03, 3.055),
    TABLE: (-2.4, -3.95),
}
"""Where the robot stands for its work (published)."""

SEAT = (-3.7, -4.0)
"""Where people sit: the laser cannot tell them from the sofa."""

DOORWAY = (-0.25, -0.5)
"""By which the published program drives from room to room."""

WALL_Y_M = -0.9
"""Above is the kitchen, below is the living room (published)."""


@dataclass(frozen=True)
class Box:
    """Something with four sides, along the axes; `x` and `y` of its centre."""

    x: float
    y: float
    width: float
    depth: float

    def distance_m(self, x: float, y: float) -> float:
        """From a point to it; 0 inside."""
        return hypot(
            max(abs(x - self.x) - self.width / 2, 0.0),
            max(abs(y - self.y) - self.depth / 2, 0.0),
        )


BOXES = (
    Box(-4.1, -1.0, 0.2, 10.4),  # outer walls: left, right, top, bottom with the house door
    Box(2.1, -1.0, 0.2, 10.4),
    Box(-1.0, 4.1, 6.0, 0.2),
    Box(-1.0, -6.1, 6.0, 0.2),
    Box(1.4, -0.9, 1.5, 0.2),  # walls between kitchen and living room
    Box(-3.4, -0.9, 1.5, 0.2),
    Box(-3.7, 2.5, 0.6, 3.0),  # kitchen units
    Box(-2.0, 3.7, 3.0, 0.6),
    Box(-3.7, 0.5, 0.6, 0.5),  # fridge
    Box(-3.7, -3.0, 0.6, 3.0),  # sofa
    Box(1.5, -3.0, 0.3, 1.0),  # TV stand
    Box(-3.0, -4.0, 0.4, 0.5),  # table
)
"""What the map has (published, walls without their doors)."""


class FlatMap:
    """Answers how far the next thing of the map is, and remembers what it was asked."""

    def __init__(self) -> None:
        self._near: dict[tuple[int, int], bool] = {}

    def clearance_m(self, x: float, y: float) -> float:
        """From a point to the nearest thing of the map; 0 inside of one."""
        return min(box.distance_m(x, y) for box in BOXES)

    def explains(self, x: float, y: float) -> bool:
        """Whether what the laser sees there is in the map: within 0.2 m of it, for noise and the map's own errors.

        To 5 cm: it is asked for each ray of each scan.
        """
        cell = round(x * 20), round(y * 20)
        near = self._near.get(cell)
        if near is None:
            near = self._near[cell] = self.clearance_m(cell[0] / 20, cell[1] / 20) < 0.2
        return near
