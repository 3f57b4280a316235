"""Orientations as matrices and angles, and poses relative to others, in double precision."""

from __future__ import annotations

import math

from sim.geometry import Pose, Quaternion, Vector

Matrix = tuple[float, float, float, float, float, float, float, float, float]
"""Row by row."""

PARALLEL = 1.0 - 1e-12
"""Orientations whose product is greater are the same: there is no axis to turn about."""


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


def turned(turn: Quaternion, vector: Vector) -> Vector:
    """A vector, turned."""
    (a, b, c, d, e, f, g, h, i), (x, y, z) = matrix_of(turn), vector
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """The orientation that is `second` relative to `first`."""
    (ax, ay, az, aw), (bx, by, bz, bw) = first, second
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def compose(base: Pose, pose: Pose) -> Pose:
    """The pose that is `pose` relative to `base`."""
    (x, y, z), (dx, dy, dz) = base[0], turned(base[1], pose[0])
    return (x + dx, y + dy, z + dz), product(base[1], pose[1])


def relative(base: Pose, pose: Pose) -> Pose:
    """A pose relative to `base`: the reverse of `compose`."""
    (x, y, z), (bx, by, bz) = pose[0], base[0]
    qx, qy, qz, qw = base[1]
    back = (-qx, -qy, -qz, qw)
    return turned(back, (x - bx, y - by, z - bz)), product(back, pose[1])


def between(start: Quaternion, other: Quaternion, share: float) -> Quaternion:
    """The orientation that is this share of the way from one to another (spherical linear interpolation)."""
    cosine = sum(a * b for a, b in zip(start, other, strict=True))
    sign, cosine = (1.0, cosine) if cosine >= 0.0 else (-1.0, -cosine)
    if cosine > PARALLEL:
        return other
    angle = math.acos(cosine)
    near, far = math.sin((1.0 - share) * angle) / math.sin(angle), sign * math.sin(share * angle) / math.sin(angle)
    x, y, z, w = (near * a + far * b for a, b in zip(start, other, strict=True))
    return (x, y, z, w)
