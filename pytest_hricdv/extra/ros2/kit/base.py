"""Fakes for a testbench: `PlanarBase`, which obeys `/cmd_vel`, and `Laser`, a scanner in a world of polygons.

Testbenches import them from `pytest_hricdv.ros2`; a `PlanarPose` is where the base is. `servers` drives the base.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.messages import import_type, set_stamp
from pytest_hricdv.extra.ros2.world import StartedSystem


@dataclass(frozen=True)
class PlanarPose:
    """Position (m) and heading (rad, counterclockwise from the x axis) of a base."""

    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0

    def move(self, forward_m_s: float, left_m_s: float, turn_rad_s: float, duration_s: float) -> PlanarPose:
        """The pose after moving on an arc, with a constant velocity in its own frame."""
        turned_rad = turn_rad_s * duration_s
        # The integral of a rotating velocity; without rotation, the limits of sin(x) / x and (1 - cos(x)) / x.
        straight = math.sin(turned_rad) / turned_rad if turned_rad else 1.0
        aside = (1.0 - math.cos(turned_rad)) / turned_rad if turned_rad else 0.0
        forward_m = (forward_m_s * straight - left_m_s * aside) * duration_s
        left_m = (forward_m_s * aside + left_m_s * straight) * duration_s
        cos, sin = math.cos(self.heading_rad), math.sin(self.heading_rad)
        return PlanarPose(
            self.x_m + cos * forward_m - sin * left_m,
            self.y_m + sin * forward_m + cos * left_m,
            math.remainder(self.heading_rad + turned_rad, math.tau),
        )


def quaternion(heading_rad: float) -> Any:
    """A `geometry_msgs/msg/Quaternion` that turns about the z axis."""
    made = import_type("geometry_msgs/msg/Quaternion", "msg")()
    made.z, made.w = math.sin(heading_rad / 2), math.cos(heading_rad / 2)
    return made


def heading_rad(quaternion: Any) -> float:
    """The heading (rad) of a `geometry_msgs/msg/Quaternion`."""
    q = quaternion
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def stamp(header: Any, system: StartedSystem, frame_id: str) -> None:
    """Give a header the present time, as clocks of nodes read it, and a frame."""
    set_stamp(header.stamp, system_ns(system.kernel))
    header.frame_id = frame_id


class PlanarBase:
    """A base on wheels. It obeys commands at once, and drives through walls.

    Args:
        system: the system of `run.ros2`.
        pose: where it begins.
        cmd_vel: the topic that it obeys, with a type: `geometry_msgs/msg/Twist` or `TwistStamped`.
        period_s: between two messages on `/odom` and `/tf`. 20 Hz by default, as of small robots.
        stops_after_s: time without a command after which it stops (s); infinity: never.
        odom: topic; empty: none.
        tf: topic; empty: none.
        frames: the frames of `/odom` and `/tf`, parent and child.
        node: its name in the graph.
    """

    def __init__(
        self,
        system: StartedSystem,
        pose: PlanarPose = PlanarPose(),
        *,
        cmd_vel: tuple[str, str] = ("/cmd_vel", "geometry_msgs/msg/Twist"),
        period_s: float = 0.05,
        stops_after_s: float = math.inf,
        odom: str = "/odom",
        tf: str = "/tf",
        frames: tuple[str, str] = ("odom", "base_link"),
        node: str = "base",
    ) -> None:
        self._pose, self._posed_s = pose, system.kernel.now_s
        self.forward_m_s = self.left_m_s = self.turn_rad_s = 0.0
        self._system, self._period_s, self._stops_after_s, self._frames = system, period_s, stops_after_s, frames
        world = system.node(node)
        self._commands = world.subscribe(*cmd_vel)
        self._is_stamped = cmd_vel[1].endswith("Stamped")
        self._commanded_s = -math.inf
        self._odom = world.publisher(odom, "nav_msgs/msg/Odometry") if odom else None
        self._tf = world.publisher(tf, "tf2_msgs/msg/TFMessage", depth=100) if tf else None
        system.kernel.spawn(node, self._drive)

    @property
    def pose(self) -> PlanarPose:
        """The present pose."""
        gone_s = self._system.kernel.now_s - self._posed_s
        return self._pose.move(self.forward_m_s, self.left_m_s, self.turn_rad_s, gone_s)

    @pose.setter
    def pose(self, pose: PlanarPose) -> None:
        """Put it there."""
        self._pose, self._posed_s = pose, self._system.kernel.now_s

    def _drive(self) -> None:
        kernel = self._system.kernel
        while True:
            self._publish()
            next_s = kernel.now_s + self._period_s
            while (left_s := next_s - kernel.now_s) > 0.0:
                message = self._commands.wait(left_s)
                self.pose = self.pose  # up to now it went as it was told before
                if message is not None:
                    self._obey(message)
                elif kernel.now_s - self._commanded_s > self._stops_after_s:
                    self.forward_m_s = self.left_m_s = self.turn_rad_s = 0.0

    def _obey(self, message: Any) -> None:
        twist = message.twist if self._is_stamped else message
        self.forward_m_s, self.left_m_s, self.turn_rad_s = twist.linear.x, twist.linear.y, twist.angular.z
        self._commanded_s = self._system.kernel.now_s

    def _publish(self) -> None:
        parent, child = self._frames
        pose = self.pose
        rotation = quaternion(pose.heading_rad)
        if self._odom is not None:
            odometry = import_type("nav_msgs/msg/Odometry", "msg")()
            stamp(odometry.header, self._system, parent)
            odometry.child_frame_id = child
            odometry.pose.pose.position.x, odometry.pose.pose.position.y = pose.x_m, pose.y_m
            odometry.pose.pose.orientation = rotation
            twist = odometry.twist.twist
            twist.linear.x, twist.linear.y, twist.angular.z = self.forward_m_s, self.left_m_s, self.turn_rad_s
            self._odom.publish(odometry)
        if self._tf is not None:
            transform = import_type("geometry_msgs/msg/TransformStamped", "msg")()
            stamp(transform.header, self._system, parent)
            transform.child_frame_id = child
            transform.transform.translation.x, transform.transform.translation.y = pose.x_m, pose.y_m
            transform.transform.rotation = rotation
            self._tf.publish(import_type("tf2_msgs/msg/TFMessage", "msg")(transforms=[transform]))


Point = tuple[float, float]
Polygon = Sequence[Point]
"""Corners (m), in order; the last one is joined to the first one."""


def _segments(polygons: Sequence[Polygon]) -> Iterator[tuple[float, float, float, float]]:
    for polygon in polygons:
        for (x1, y1), (x2, y2) in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
            yield x1, y1, x2, y2


def distance_m(x_m: float, y_m: float, angle_rad: float, polygons: Sequence[Polygon]) -> float:
    """The distance from a point along a ray to an edge of a polygon; infinity if it meets none."""
    cos, sin, nearest_m = math.cos(angle_rad), math.sin(angle_rad), math.inf
    for x1, y1, x2, y2 in _segments(polygons):
        # Solve p + t d = a + u (b - a) by Cramer's rule.
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
        system: the system of `run.ros2`.
        pose: where the scanner is; called for each scan, for instance `lambda: base.pose`.
        polygons: what it sees; a function where something moves, as a person's legs.
        topic: the topic of the scans.
        samples: rays of a scan, evenly from `angle_min_rad` to `angle_max_rad`.
        range_m: the least and the largest distance. REP 117: nearer is -inf, farther is inf.
        noise_m: standard deviation of a distance.
        period_s: between two scans. 10 Hz by default, as of small scanners.
        generator: the generator of the noise; without one it is that of the test's seed.
        frame_id: the frame id of the scanner.
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
        scan, pose, polygons = import_type("sensor_msgs/msg/LaserScan", "msg")(), self._pose(), self._polygons()
        stamp(scan.header, self._system, self._frame_id)
        scan.angle_min, scan.angle_increment = self._first_rad, self._step_rad
        scan.angle_max = self._first_rad + self._step_rad * (self._samples - 1)
        scan.scan_time = self._period_s
        scan.range_min, scan.range_max = self._range_m
        angles = (pose.heading_rad + self._first_rad + self._step_rad * index for index in range(self._samples))
        scan.ranges = [self._measure(distance_m(pose.x_m, pose.y_m, angle, polygons)) for angle in angles]
        return scan

    def _measure(self, exact_m: float) -> float:
        measured_m = exact_m + self._random.gauss(0.0, self._noise_m) if self._noise_m else exact_m
        nearest_m, farthest_m = self._range_m
        return math.inf if measured_m > farthest_m else -math.inf if measured_m < nearest_m else measured_m
