"""What the laser sees that the map does not have: people, animals, things that stand about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import cos, hypot, pi, sin

from carebot.flatmap import HULL_M, FlatMap
from carebot.messages import Pose, Scan

THINNED = 6
"""Each sixth ray is looked at (chosen): at 1.2 m they are 7 cm apart, and the least that walks here is 15 cm wide."""

BESIDE_M = 0.12
"""On either side of the hull the way has to be free so far (chosen: a person's step in half a period)."""

SAME_M = 0.5
"""What is seen nearer to each other than this may be the same person (chosen: the breadth of shoulders)."""

NEARER_M = 0.02
"""By less it does not count as nearer (chosen: two thirds of the laser's noise)."""


@dataclass(frozen=True)
class Seen:
    """Something that is not in the map.

    Args:
        ahead_m: in the robot's frame, along its heading.
        left_m: across it.
        x: in the flat's frame (m).
        y: likewise.
    """

    ahead_m: float
    left_m: float
    x: float
    y: float

    @property
    def distance_m(self) -> float:
        """From the laser."""
        return hypot(self.ahead_m, self.left_m)


@cache
def _rays(count: int) -> tuple[tuple[float, float], ...]:
    """Cosine and sine of the bearing of each ray that is looked at, of a scan of so many."""
    step_rad = THINNED * 2 * pi / count
    bearings = (number * step_rad - pi for number in range(len(range(0, count, THINNED))))
    return tuple((cos(bearing), sin(bearing)) for bearing in bearings)


def unknown(scan: Scan, pose: Pose, flat: FlatMap, within_m: float) -> list[Seen]:
    """What is seen within so many metres and is not in the map."""
    seen = []
    turned_cos, turned_sin = cos(pose.heading), sin(pose.heading)
    for range_m, (ray_cos, ray_sin) in zip(scan.ranges[::THINNED], _rays(len(scan.ranges)), strict=True):
        if range_m < within_m:
            ahead_m, left_m = range_m * ray_cos, range_m * ray_sin
            x = pose.x + ahead_m * turned_cos - left_m * turned_sin
            y = pose.y + ahead_m * turned_sin + left_m * turned_cos
            if not flat.explains(x, y):
                seen.append(Seen(ahead_m, left_m, x, y))
    return seen


def is_in_the_way(other: Seen, stop_m: float, seen: Sequence[Seen] = ()) -> bool:
    """Whether the robot would come near it if it drove on: it is ahead, and not beside the way.

    Who stands nearer beside the robot than it likes is not in its way as long as it comes no nearer to them.

    Args:
        other: what may be in the way.
        stop_m: how far ahead of the hull the way has to be free.
        seen: all that is seen.
    """
    if not 0.0 < other.ahead_m < HULL_M + stop_m:
        return False
    near_m = [near.distance_m for near in seen if hypot(near.x - other.x, near.y - other.y) < SAME_M]
    return abs(other.left_m) < min([HULL_M + BESIDE_M, *(distance_m - NEARER_M for distance_m in near_m)])
