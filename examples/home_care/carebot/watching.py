"""What the laser sees that the map does not have: people, animals, things that stand about."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, sin

from carebot.flatmap import HULL_M, FlatMap
from carebot.messages import Pose, Scan

THINNED = 6
"""Each sixth ray is looked at (chosen): at 1.2 m they are 7 cm apart, and the least that walks here is 15 cm wide."""

BESIDE_M = 0.12
"""On either side of the hull the way has to be free so far (chosen: a person's step in half a period)."""


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


def unknown(scan: Scan, pose: Pose, flat: FlatMap, within_m: float) -> list[Seen]:
    """What is seen within so many metres and is not in the map."""
    seen, step_rad = [], THINNED * 2 * pi / len(scan.ranges)
    for number, range_m in enumerate(scan.ranges[::THINNED]):
        if range_m < within_m:
            bearing = number * step_rad - pi
            ahead_m, left_m = range_m * cos(bearing), range_m * sin(bearing)
            x = pose.x + ahead_m * cos(pose.heading) - left_m * sin(pose.heading)
            y = pose.y + ahead_m * sin(pose.heading) + left_m * cos(pose.heading)
            if not flat.explains(x, y):
                seen.append(Seen(ahead_m, left_m, x, y))
    return seen


def is_in_the_way(seen: Seen, stop_m: float) -> bool:
    """Whether the robot would come near it if it drove on: it is ahead, and not beside the way."""
    return 0.0 < seen.ahead_m < HULL_M + stop_m and abs(seen.left_m) < HULL_M + BESIDE_M
