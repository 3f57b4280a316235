"""Shapes of bodies: what they are like, and how they are rendered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from sim.geometry import Pose, Vector

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


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


class Renderer(Protocol):
    """Renders shapes, without any physics."""

    def close(self) -> None:
        """Release all resources."""

    def add(self, shape: Shape, rgba: Sequence[float]) -> int:
        """Add a shape; returns its number."""

    def remove(self, number: int) -> None:
        """Remove a shape."""

    def put(self, number: int, pose: Pose) -> None:
        """Set the pose of a shape."""

    def picture(
        self, eye: Vector, target: Vector, degrees: float, size: tuple[int, int], light: Vector, *, shadows: bool
    ) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """What is seen: height x width x 3 (RGB), and height x width: whether nothing is there.

        Args:
            eye: position (m).
            target: that is looked at (m).
            degrees: vertical field of view.
            size: width and height (px).
            light: direction to the light.
            shadows: whether it throws shadows.
        """
