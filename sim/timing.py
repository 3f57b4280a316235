"""Timing of arm paths: straight segments from stop to stop, with limited joint speed and acceleration.

A segment has one degree of freedom and begins and ends at rest: the time-optimal profile is a trapezoid of the speed (a
triangle for a short segment), so no trajectory library is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from controller.ports import ARM_JOINTS, JointPose, PlanningError
from sim.engine import STEP_S

SPEED_SHARE = 0.96
"""The fastest joint moves at this share of the allowed speed: 0.24 of 0.25 rad/s. Contacts add some: up to 0.2463 rad/s
were measured at 120 steps per second (0.2432 at 240, 0.2525 at 60; for other rates, see
docs/studies/convergence.md)."""

MAX_ACCELERATION_RAD_S2 = 1.0
"""Largest acceleration of a joint: a quarter of a second from rest to 0.25 rad/s."""

SETTLE_S = 0.15
"""Time beyond the planned time until a joint motor is at rest (it approaches the goal exponentially): only planned
durations have it, and from 0.1 to 0.3 the records are the same (see `sim.world.REST_TICKS`)."""


@dataclass(frozen=True)
class Segment:
    """A straight segment: all joints start and arrive together; acceleration and deceleration take `ramp_s` each."""

    goal: JointPose
    duration_s: float
    ramp_s: float


@dataclass(frozen=True)
class ArmPath:
    """A planned path; a `controller.ports.Path`."""

    start: JointPose
    segments: tuple[Segment, ...]

    @property
    def duration_s(self) -> float:
        """Duration of the motion, including the stop at the end of each segment."""
        return sum(segment.duration_s + SETTLE_S for segment in self.segments)


def time_path(start: JointPose, waypoints: Sequence[JointPose], max_speed_rad_s: float) -> ArmPath:
    """The path from `start` through `waypoints` (rad) with its fastest joint at SPEED_SHARE of `max_speed_rad_s`.

    Raises:
        PlanningError: no waypoints, a waypoint that is not nine finite angles, or a speed that is not above 0.
    """
    if not (math.isfinite(max_speed_rad_s) and max_speed_rad_s > 0.0):
        raise PlanningError(f"cannot plan for a joint speed of {max_speed_rad_s!r} rad/s: expected more than 0")
    if not waypoints:
        raise PlanningError("cannot plan a way without waypoints")
    segments = []
    here = start
    for waypoint in waypoints:
        goal = tuple(waypoint)
        if len(goal) != len(ARM_JOINTS) or not all(math.isfinite(angle) for angle in goal):
            raise PlanningError(f"waypoint {goal} is not {len(ARM_JOINTS)} finite angles")
        way_rad = max(abs(g - h) for g, h in zip(goal, here, strict=True))
        segments.append(Segment(goal, *_trapezoid(way_rad, SPEED_SHARE * max_speed_rad_s)))
        here = goal
    return ArmPath(start, tuple(segments))


def _trapezoid(way_rad: float, speed_rad_s: float) -> tuple[float, float]:
    """Duration and ramp (s) of a move over an angle from rest to rest."""
    ramp_s = speed_rad_s / MAX_ACCELERATION_RAD_S2
    if way_rad < speed_rad_s * ramp_s:  # too short to reach the speed
        ramp_s = math.sqrt(way_rad / MAX_ACCELERATION_RAD_S2)
        return max(2.0 * ramp_s, STEP_S), ramp_s
    return way_rad / speed_rad_s + ramp_s, ramp_s
