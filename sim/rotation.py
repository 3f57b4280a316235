"""Orientations as matrices and angles, in double precision."""

from __future__ import annotations

import math

from sim.geometry import Quaternion

Matrix = tuple[float, float, float, float, float, float, float, float, float]
"""Row by row."""


def matrix_of(turn: Quaternion) -> Matrix:
    """The rotation matrix of an orientation; its columns are the turned axes."""
    x, y, z, w = turn
    scale = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * scale, y * scale, z * scale
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz, yy, yz, zz = x * xs, x * ys, x * zs, y * ys, y * zs, z * zs
    return (1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy))


def turn_of(pitch_rad: float, yaw_rad: float) -> Quaternion:
    """The orientation after a turn about y, then about the fixed z axis."""
    sp, cp = math.sin(pitch_rad / 2.0), math.cos(pitch_rad / 2.0)
    sy, cy = math.sin(yaw_rad / 2.0), math.cos(yaw_rad / 2.0)
    x, y, z, w = 0.0 - sp * sy, sp * cy, cp * sy, cp * cy  # no minus zero
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return (x / length, y / length, z / length, w / length)
