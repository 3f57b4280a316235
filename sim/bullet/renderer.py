"""Pictures by PyBullet's software renderer, and the shapes that are on them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.bullet.client import bullet, connect, load
from sim.geometry import Pose, Vector
from sim.shapes import Box, Cylinder, Shape, Sphere


class LinkShape(NamedTuple):
    """A visual shape of a link, with its pose on the link."""

    link: int
    shape: Shape
    at: Pose
    rgba: tuple[float, ...]


@cache
def shapes_of_description(description: str) -> tuple[LinkShape, ...]:
    """The visual shapes of a robot's links, of which fixed joints are merged."""
    client = connect()
    try:
        return shapes_of(client, load(client, description, bullet.URDF_MERGE_FIXED_LINKS))
    finally:
        bullet.disconnect(physicsClientId=client)


def shapes_of(client: int, body: int) -> tuple[LinkShape, ...]:
    """The visual shapes of a body's links."""
    shapes = bullet.getVisualShapeData(body, physicsClientId=client)
    return tuple(
        LinkShape(link, _shape(kind, size), (place, turn), tuple(rgba))
        for _, link, kind, size, _, place, turn, rgba, *_ in shapes
    )


def _shape(kind: int, size: Sequence[float]) -> Shape:
    if kind == bullet.GEOM_BOX:
        return Box((size[0] / 2, size[1] / 2, size[2] / 2))
    if kind == bullet.GEOM_SPHERE:
        return Sphere(size[0])
    return Cylinder(radius_m=size[1], length_m=size[0])


class BulletRenderer:
    """Shapes in a client of their own; a `sim.engine.Renderer`."""

    def __init__(self) -> None:
        self._client = connect()

    def close(self) -> None:
        """See `Renderer`."""
        if self._client >= 0:
            bullet.disconnect(self._client)
            self._client = -1

    def add(self, shape: Shape, rgba: Sequence[float]) -> int:
        """See `Renderer`."""
        match shape:
            case Box(half_m):
                given = {"shapeType": bullet.GEOM_BOX, "halfExtents": half_m}
            case Sphere(radius_m):
                given = {"shapeType": bullet.GEOM_SPHERE, "radius": radius_m}
            case Cylinder(radius_m, length_m):
                given = {"shapeType": bullet.GEOM_CYLINDER, "length": length_m, "radius": radius_m}
        visual = bullet.createVisualShape(rgbaColor=rgba, physicsClientId=self._client, **given)
        body: int = bullet.createMultiBody(0.0, -1, visual, physicsClientId=self._client)
        return body

    def remove(self, number: int) -> None:
        """See `Renderer`."""
        bullet.removeBody(number, physicsClientId=self._client)

    def put(self, number: int, pose: Pose) -> None:
        """See `Renderer`."""
        bullet.resetBasePositionAndOrientation(number, pose[0], pose[1], physicsClientId=self._client)

    def picture(
        self, eye: Vector, target: Vector, degrees: float, size: tuple[int, int], light: Vector, *, shadows: bool
    ) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """See `Renderer`."""
        width, height = size
        _, _, pixels, _, bodies = bullet.getCameraImage(
            width,
            height,
            bullet.computeViewMatrix(eye, target, (0.0, 0.0, 1.0)),
            bullet.computeProjectionMatrixFOV(degrees, width / height, 0.05, 6.0),
            lightDirection=light,
            shadow=int(shadows),
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        rgb = np.reshape(np.asarray(pixels, dtype=np.uint8), (height, width, 4))[:, :, :3]
        return rgb, np.reshape(np.asarray(bodies), (height, width)) < 0
