"""Shapes of bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from sim.geometry import Pose, Vector


@dataclass(frozen=True)
class Box:
    """A box; `half_m`: half its extents (m)."""

    half_m: Vector


@dataclass(frozen=True)
class Sphere:
    """A sphere."""

    radius_m: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z."""

    radius_m: float
    length_m: float


Shape = Box | Sphere | Cylinder


@dataclass(frozen=True)
class Surface:
    """Friction, and drag of the air, of a body (coefficients)."""

    lateral: float
    rolling: float
    spinning: float
    angular_drag: float


class Visual(NamedTuple):
    """A shape that is seen: the body it belongs to, its number there, what it is like, and its colour."""

    body: int
    number: int
    shape: Shape
    rgba: tuple[float, ...]


class LinkShape(NamedTuple):
    """A visual shape of a moving link, or -1 for the base, with its pose on the link."""

    link: int
    shape: Shape
    at: Pose
    rgba: tuple[float, ...]
