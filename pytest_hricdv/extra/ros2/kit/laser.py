"""A laser scanner in a world of polygons: rays against segments."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from pytest_hricdv.extra.ros2.kit.base import PlanarPose, stamp
from pytest_hricdv.extra.ros2.vocabulary import loaded
from pytest_hricdv.extra.ros2.world import StartedSystem

Point = tuple[float, float]
Polygon = Sequence[Point]
"""Corners (m), in order; the last one is joined to the first one."""


def _segments(polygons: Sequence[Polygon]) -> Iterator[tuple[float, float, float, float]]:
    for polygon in polygons:
        for (x1, y1), (x2, y2) in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
            yield x1, y1, x2, y2


def distance_m(x_m: float, y_m: float, angle_rad: float, polygons: Sequence[Polygon]) -> float:
    """How far a ray from a point goes until it meets an edge of a polygon; infinity: it meets none."""
    cos, sin, nearest_m = math.cos(angle_rad), math.sin(angle_rad), math.inf
    for x1, y1, x2, y2 in _segments(polygons):
        # Of p + t d = a + u (b - a): Cramer's rule.
        along_x, along_y, to_x, to_y = x2 - x1, y2 - y1, x1 - x_m, y1 - y_m
        cross = cos * along_y - sin * along_x
        if cross == 0.0:
            continue  # it is parallel
        u = (to_x * sin - to_y * cos) / cross
        t = (to_x * along_y - to_y * along_x) / cross
        if t >= 0.0 and 0.0 <= u <= 1.0:
            nearest_m = min(nearest_m, t)
    return nearest_m


class Laser:
    """A laser scanner that publishes `sensor_msgs/msg/LaserScan`.

    Args:
        system: of `run.ros2`.
        pose: where the scanner is; called for each scan, for instance `lambda: base.pose`.
        polygons: what it sees; a function where something moves, as a person's legs.
        topic: of the scans.
        samples: rays of a scan, evenly from `angle_min_rad` to `angle_max_rad`.
        range_m: the least and the largest distance. REP 117: nearer is -inf, farther is inf.
        noise_m: standard deviation of a distance.
        period_s: between two scans. 10 Hz, as of small scanners (chosen).
        generator: of the noise; without one it is that of the test's seed.
        frame_id: of the scanner.
        node: its name in the graph.
    """

    def __init__(
        self,
        system: StartedSystem,
        pose: Callable[[], PlanarPose],
        polygons: Sequence[Polygon] | Callable[[], Sequence[Polygon]],
        *,
        topic: str = "/scan",
        samples: int = 360,
        angle_min_rad: float = -math.pi,
        angle_max_rad: float = math.pi * (1 - 2 / 360),
        range_m: tuple[float, float] = (0.12, 3.5),
        noise_m: float = 0.0,
        period_s: float = 0.1,
        generator: random.Random | None = None,
        frame_id: str = "laser",
        node: str = "laser",
    ) -> None:
        self._system, self._pose, self._frame_id = system, pose, frame_id
        self._polygons = polygons if callable(polygons) else lambda: polygons
        self._range_m, self._noise_m, self._period_s = range_m, noise_m, period_s
        self._first_rad = angle_min_rad
        self._step_rad = (angle_max_rad - angle_min_rad) / max(samples - 1, 1)
        self._samples = samples
        self._random = generator or random.Random()
        self._publisher = system.node(node).publisher(topic, "sensor_msgs/msg/LaserScan")
        system.kernel.spawn(node, self._turn)

    def _turn(self) -> None:
        while True:
            self._publisher.publish(self.scan())
            self._system.kernel.sleep(self._period_s)

    def scan(self) -> Any:
        """A `sensor_msgs/msg/LaserScan` of the present instant."""
        scan, pose, polygons = loaded("sensor_msgs/msg/LaserScan", "msg")(), self._pose(), self._polygons()
        stamp(scan.header, self._system, self._frame_id)
        scan.angle_min, scan.angle_increment = self._first_rad, self._step_rad
        scan.angle_max = self._first_rad + self._step_rad * (self._samples - 1)
        scan.scan_time = self._period_s
        scan.range_min, scan.range_max = self._range_m
        angles = (pose.heading_rad + self._first_rad + self._step_rad * index for index in range(self._samples))
        scan.ranges = [self._measured(distance_m(pose.x_m, pose.y_m, angle, polygons)) for angle in angles]
        return scan

    def _measured(self, exact_m: float) -> float:
        measured_m = exact_m + self._random.gauss(0.0, self._noise_m) if self._noise_m else exact_m
        nearest_m, farthest_m = self._range_m
        return math.inf if measured_m > farthest_m else -math.inf if measured_m < nearest_m else measured_m
