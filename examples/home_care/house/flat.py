"""The flat: walls, furniture and goals, by the dimensions of the published case.

Frame: m, as published; x to the right, y up in a view from above. The kitchen is above y = -0.8, the living room below
y = -1.0. All dimensions are from the published world but for those that say otherwise. Where they do not fit together:

- The dividing walls reach 0.15 m into the outer walls: kept, nothing can be there.
- Both kitchen units fill the same 0.1 m x 0.6 m of the corner: kept, as one L-shaped unit.
- The doorway by which the robot is said to go, (-0.25, -0.5), is no doorway: the opening is 3.3 m wide, its middle is
  x = -1.0, and the point lies 0.3 m on the kitchen's side of the wall. It is kept as a way-point.
- A robot of 0.27 m has 0.075 m of room between it and the unit at the goal "sink", and 0.13 m to the table.
- The table has a top at 0.65 m and no legs are given: it is a solid box, for the laser as well (chosen).
- The person is "at a table" and has no body. The only seat at the table is the sofa behind it: there it sits (chosen).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from house.shapes import Box, Point, box_around, gap_to_box

Kind = Literal["wall", "furniture"]


@dataclass(frozen=True)
class Solid:
    """Something that stays where it is: what it is called, whether it is a wall, its outline, and its height (m)."""

    name: str
    kind: Kind
    box: Box
    height_m: float


@dataclass(frozen=True)
class Start:
    """Where something is in the beginning: m, m, rad."""

    at: Point
    heading_rad: float


WALL_M = 1.0
"""Height of walls."""

SOLIDS = (
    # The length of the outer walls at x is 10.4: from -6.2 to 4.2, so that they close the corners.
    Solid("west wall", "wall", box_around((-4.1, -1.0), (0.2, 10.4)), WALL_M),
    Solid("east wall", "wall", box_around((2.1, -1.0), (0.2, 10.4)), WALL_M),
    Solid("north wall", "wall", box_around((-1.0, 4.1), (6.0, 0.2)), WALL_M),
    Solid("south wall, west", "wall", box_around((-2.0, -6.1), (4.0, 0.2)), WALL_M),
    Solid("south wall, east", "wall", box_around((1.4, -6.1), (1.2, 0.2)), WALL_M),
    Solid("house door", "wall", box_around((0.4, -6.1), (0.8, 0.1)), 2.0),
    Solid("dividing wall, east", "wall", box_around((1.4, -0.9), (1.5, 0.2)), WALL_M),
    Solid("dividing wall, west", "wall", box_around((-3.4, -0.9), (1.5, 0.2)), WALL_M),
    Solid("kitchen unit, west", "furniture", box_around((-3.7, 2.5), (0.6, 3.0)), 0.6),
    Solid("kitchen unit, north", "furniture", box_around((-2.0, 3.7), (3.0, 0.6)), 0.6),
    Solid("fridge", "furniture", box_around((-3.7, 0.5), (0.6, 0.5)), 0.6),
    Solid("sofa", "furniture", box_around((-3.7, -3.0), (0.6, 3.0)), 0.4),
    Solid("TV stand", "furniture", box_around((1.5, -3.0), (0.3, 1.0)), 1.2),
    Solid("table", "furniture", box_around((-3.0, -4.0), (0.4, 0.5)), 0.65),
)

BOXES = tuple(solid.box for solid in SOLIDS)
INSIDE = Box(-4.0, -6.0, 2.0, 4.0)
"""Within the outer walls."""

ROBOT = Start((0.0, 0.0), 0.0)
DOG = Start((0.0, -4.0), 0.0)
SEAT: Point = (-3.7, -4.0)
"""Where the person sits: on the sofa, opposite the table (chosen)."""

STANDS: Point = (-3.1, -3.3)
"""Where the person stands after getting up: beside the table, before the sofa (chosen)."""

CHARGER: Point = (1.35, 0.015)
GOALS: dict[str, Point] = {
    "charger": CHARGER,
    "fridge": (-2.8, 0.405),
    "sink": (-2.03, 3.055),
    "table": (-2.4, -3.95),
}
"""Where the robot goes."""

DOORWAY: Point = (-0.25, -0.5)
"""By which the robot goes from room to room."""

PLACES: dict[str, Point] = {
    "table": STANDS,
    "tv": (0.9, -3.0),
    "doorway": (-1.0, -0.9),
    "kitchen": (-1.0, 1.5),
    "fridge": (-2.9, 0.5),
    "sink": (-2.0, 2.9),
    "charger": (1.2, 0.1),
}
"""Where the person may go (chosen). At the last three the robot cannot come to its goal; beside the table it can."""

DOG_AREA = Box(-2.5, -5.5, 0.5, -0.5)
"""The dog stays in there, as published. Nothing stands in it."""

AT_CHARGER_M = 0.15
"""In x and in y: as requirement A2 measures it."""

SINK = box_around((-2.03, 3.7), (0.5, 0.5))
"""The basin in the northern unit, opposite the goal (its size is chosen)."""

USES: dict[str, Box] = {
    "fridge": SOLIDS[10].box,
    "sink": SINK,
    "table": SOLIDS[13].box,
}
"""Where the gripper takes or leaves something."""

REACH_M = 0.75
"""From the middle of the base: within it, the gripper is above a thing. Goals are 0.6 m, 0.4 m and 0.4 m from theirs;
an arm of this robot reaches about 0.87 m (chosen)."""


@lru_cache(maxsize=8)
def clearance_m(at: Point) -> float:
    """From a point to the nearest wall or furniture (m); 0 inside of one.

    The last ones are kept: at each step of a run both the base and the record ask for the same place.
    """
    x, y = at
    least = math.inf
    for x1, y1, x2, y2 in _SIDES:  # spelt out: it is asked for at each step of a run
        dx = x1 - x if x < x1 else x - x2 if x > x2 else 0.0
        dy = y1 - y if y < y1 else y - y2 if y > y2 else 0.0
        square = dx * dx + dy * dy
        if square < least:  # a call of min() takes three times as long
            least = square
    return math.sqrt(least)


_SIDES = tuple((box.x1, box.y1, box.x2, box.y2) for box in BOXES)


def in_reach(at: Point) -> str:
    """Which of `USES` the gripper reaches, the nearest one; an empty text where there is none."""
    width_m, near = min((gap_to_box(at, 0.0, box).width_m, name) for name, box in USES.items())
    return near if width_m <= REACH_M else ""


def at_charger(at: Point) -> bool:
    """Whether the robot stands at its charger."""
    return abs(at[0] - CHARGER[0]) < AT_CHARGER_M and abs(at[1] - CHARGER[1]) < AT_CHARGER_M
