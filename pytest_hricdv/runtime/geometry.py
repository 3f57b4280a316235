"""Shapes in a world, for viewers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True)
class Body:
    """A coloured shape where it is now.

    Args:
        name: the same as long as it is the same body.
        shape: a cylinder is one along its z axis.
        size_m: its extents along its own axes (m).
        position_m: of its middle, in the world (m).
        rotation: from its own axes to the world's, a unit quaternion (x, y, z, w).
        rgba: its colour, each part from 0 to 1.
    """

    name: str
    shape: Literal["box", "sphere", "cylinder"]
    size_m: Vector
    position_m: Vector
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)
    rgba: tuple[float, ...] = (0.6, 0.6, 0.6, 1.0)
