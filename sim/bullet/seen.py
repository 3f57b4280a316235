"""What is seen of a body."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from sim.bullet.client import bullet, connect, load
from sim.shapes import Box, Cylinder, LinkShape, Shape, Sphere


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
