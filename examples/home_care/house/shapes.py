"""Boxes and discs in the plane, and the gaps between them. Lengths in m, angles in rad."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A box with sides along the axes, from its least to its greatest corner (m)."""

    x1: float
    y1: float
    x2: float
    y2: float

    @property
    def corners(self) -> tuple[Point, Point, Point, Point]:
        """Counter-clockwise."""
        return (self.x1, self.y1), (self.x2, self.y1), (self.x2, self.y2), (self.x1, self.y2)

    def grown(self, by_m: float) -> Box:
        """The box with all sides moved outwards."""
        return Box(self.x1 - by_m, self.y1 - by_m, self.x2 + by_m, self.y2 + by_m)

    def contains(self, point: Point) -> bool:
        """Whether a point is inside; on a side it is not."""
        return self.x1 < point[0] < self.x2 and self.y1 < point[1] < self.y2

    def nearest(self, point: Point) -> Point:
        """Its point that is nearest to a point: that point itself, where it is inside."""
        return min(max(point[0], self.x1), self.x2), min(max(point[1], self.y1), self.y2)

    def crosses(self, start: Point, end: Point) -> bool:
        """Whether a segment goes through its inside."""
        enter, leave = 0.0, 1.0
        for low, high, first, last in (
            (self.x1, self.x2, start[0], end[0]),
            (self.y1, self.y2, start[1], end[1]),
        ):
            way = last - first
            if way == 0.0:
                if not low < first < high:
                    return False
                continue
            one, other = (low - first) / way, (high - first) / way
            enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
        return enter < leave


class Gap(NamedTuple):
    """Between a disc and something: its width (m, negative where they overlap), and the unit vector away from it."""

    width_m: float
    away: Point


def box_around(middle: Point, size: Point) -> Box:
    """The box with this middle and these extents (m)."""
    return Box(
        middle[0] - size[0] / 2.0, middle[1] - size[1] / 2.0, middle[0] + size[0] / 2.0, middle[1] + size[1] / 2.0
    )


def gap_to_box(middle: Point, radius_m: float, box: Box) -> Gap:
    """Between a disc and a box; inside the box, `away` is the shortest way out."""
    near = box.nearest(middle)
    dx, dy = middle[0] - near[0], middle[1] - near[1]
    far_m = math.hypot(dx, dy)
    if far_m > 0.0:
        return Gap(far_m - radius_m, (dx / far_m, dy / far_m))
    sides = (
        (middle[0] - box.x1, (-1.0, 0.0)),
        (box.x2 - middle[0], (1.0, 0.0)),
        (middle[1] - box.y1, (0.0, -1.0)),
        (box.y2 - middle[1], (0.0, 1.0)),
    )
    depth_m, away = min(sides)
    return Gap(-depth_m - radius_m, away)


def gap_to_disc(middle: Point, radius_m: float, other: Point, other_radius_m: float) -> Gap:
    """Between two discs; where both have one middle, `away` is along x."""
    dx, dy = middle[0] - other[0], middle[1] - other[1]
    far_m = math.hypot(dx, dy)
    away = (dx / far_m, dy / far_m) if far_m > 0.0 else (1.0, 0.0)
    return Gap(far_m - radius_m - other_radius_m, away)


def gap_to_turned_box(middle: Point, radius_m: float, box_middle: Point, heading_rad: float, size: Point) -> Gap:
    """Between a disc and a box whose x axis points along `heading_rad`."""
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    dx, dy = middle[0] - box_middle[0], middle[1] - box_middle[1]
    gap = gap_to_box((cos * dx + sin * dy, cos * dy - sin * dx), radius_m, box_around((0.0, 0.0), size))
    return Gap(gap.width_m, (cos * gap.away[0] - sin * gap.away[1], sin * gap.away[0] + cos * gap.away[1]))


def moved(point: Point, direction: Point, way_m: float) -> Point:
    """A point, some way along a unit vector."""
    return point[0] + way_m * direction[0], point[1] + way_m * direction[1]


def turned(angle_rad: float) -> float:
    """An angle as one from -pi (excluded) to pi."""
    rest = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if rest == -math.pi else rest


def distance_to_segment(point: Point, start: Point, end: Point) -> float:
    """From a point to the nearest point of a segment (m)."""
    way_x, way_y = end[0] - start[0], end[1] - start[1]
    square = way_x * way_x + way_y * way_y
    if square == 0.0:
        return math.dist(point, start)
    part = ((point[0] - start[0]) * way_x + (point[1] - start[1]) * way_y) / square
    part = min(max(part, 0.0), 1.0)
    return math.dist(point, (start[0] + part * way_x, start[1] + part * way_y))
