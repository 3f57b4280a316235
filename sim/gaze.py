"""The gaze of a head at a leg, and the head pose for a given gaze.

Offset: lateral distance of the head from the leg (m, along y; the person sits opposite the robot, on the x axis).
Distance: from head to leg (m). Angle: between the direction of the face, which is the head's x axis, and the direction
from head to leg (degrees).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim.engine import SimulationError, check_finite
from sim.geometry import Pose, Quaternion, Vector
from sim.rotation import matrix_of, turn_of

ELEVATION_RAD = math.radians(40.0)
"""Elevation of a person's head seen from the leg, bent over the table."""


@dataclass(frozen=True)
class Gaze:
    """How a head looks at a leg."""

    offset_m: float
    distance_m: float
    angle_deg: float


def gaze_of(head: Pose, leg: Vector) -> Gaze:
    """The gaze of a head pose at a leg's middle (m)."""
    place, turn = head
    to_leg = tuple(b - a for a, b in zip(place, leg, strict=True))
    distance_m = math.dist(place, leg)
    facing = matrix_of(turn)[0::3]
    cosine = sum(a * b for a, b in zip(to_leg, facing, strict=True)) / max(distance_m, 1e-9)
    angle_deg = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    return Gaze(abs(to_leg[1]), distance_m, angle_deg)


def head_pose(gaze: Gaze, side: float, leg: Vector) -> Pose:
    """A head pose on the person's side of the table that has this gaze.

    Args:
        gaze: offset at most the distance, angle between 0 and 180 degrees.
        side: positive for a head on the robot's left of the leg (towards +y) that looks past it on the same side,
            negative for the other side.
        leg: middle of the leg (m).

    Raises:
        SimulationError: there is no such gaze, or a number is not finite.
    """
    check_finite("gaze", (gaze.offset_m, gaze.distance_m, gaze.angle_deg, side))
    if not (0.0 <= gaze.offset_m <= gaze.distance_m and gaze.distance_m > 0.0 and 0.0 <= gaze.angle_deg <= 180.0):
        raise SimulationError(f"no head has {gaze}: expected offset <= distance, distance > 0, angle in [0, 180]")
    hand = math.copysign(1.0, side)
    reach_m = math.sqrt(gaze.distance_m**2 - gaze.offset_m**2)
    place = (
        leg[0] + reach_m * math.cos(ELEVATION_RAD),
        leg[1] + hand * gaze.offset_m,
        leg[2] + reach_m * math.sin(ELEVATION_RAD),
    )
    return place, orientation_to(place, leg, hand * math.radians(gaze.angle_deg))


def orientation_to(place: Vector, target: Vector, past_rad: float = 0.0) -> Quaternion:
    """Orientation of a head at `place` whose face points `past_rad` to the side of the direction to `target`."""
    x, y, z = (b - a for a, b in zip(place, target, strict=True))
    yaw, pitch = math.atan2(y, x), -math.atan2(z, math.hypot(x, y))
    # Rotation about the head's own vertical axis: the angle to the target equals the rotation for every pitch.
    return _turned(turn_of(pitch, yaw), past_rad)


def _turned(turn: Quaternion, about_z_rad: float) -> Quaternion:
    """`turn`, then a turn about the new z axis."""
    x, y, z, w = turn
    sine, cosine = math.sin(about_z_rad / 2.0), math.cos(about_z_rad / 2.0)
    return (x * cosine + y * sine, y * cosine - x * sine, z * cosine + w * sine, w * cosine - z * sine)
