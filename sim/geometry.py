"""Places, orientations and poses as plain numbers."""

from __future__ import annotations

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[Vector, Quaternion]

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
