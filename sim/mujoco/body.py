"""Bodies of a MuJoCo scene: their elements in the description, and where they are in the compiled model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sim.geometry import Quaternion, Vector
from sim.mujoco.library import mujoco
from sim.shapes import Box, Cylinder, Shape, Sphere


@dataclass(frozen=True)
class Numbers:
    """Where a body is in the compiled model. The elements of a description forget theirs as soon as it changes.

    Args:
        links: number of each moving link, -1 for the base.
        geoms: numbers of the shapes of each link.
        mocap: its number among bodies that stay where they are placed; -1 if physics moves it.
        pose: where its pose is in the state, if physics moves it.
        velocity: where its velocity is.
    """

    links: Mapping[int, int]
    geoms: Mapping[int, Sequence[int]]
    mocap: int
    pose: slice
    velocity: slice


@dataclass
class Body:
    """A body of the scene.

    Args:
        base: its element of the description.
        free: physics moves it; else it stays where it is placed.
        links: the moving links of a robot.
        geoms: the shapes of each link, -1 for its base.
        joints: the joint of each link.
        seen: shape and colour, of a body of one shape.
        description: URDF text of a robot.
    """

    base: Any
    free: bool = False
    links: Sequence[Any] = ()
    joints: Sequence[Any] = ()
    geoms: Mapping[int, Sequence[Any]] = field(default_factory=dict)
    seen: tuple[Shape, tuple[float, ...]] | None = None
    description: str = ""
    numbers: Numbers = field(init=False)

    def find(self, model: Any) -> None:
        """Look up its numbers in a model that was just compiled."""
        base = self.base.id
        pose, velocity = slice(0), slice(0)
        if self.free:
            first, dof = int(model.jnt_qposadr[model.body_jntadr[base]]), int(model.body_dofadr[base])
            pose, velocity = slice(first, first + 7), slice(dof, dof + 6)
        self.numbers = Numbers(
            links={-1: base} | {number: link.id for number, link in enumerate(self.links)},
            geoms={link: tuple(geom.id for geom in geoms) for link, geoms in self.geoms.items()},
            mocap=int(model.body_mocapid[base]),
            pose=pose,
            velocity=velocity,
        )


def vector(values: Any) -> Vector:
    """Three numbers of MuJoCo."""
    x, y, z = values.tolist()
    return (x, y, z)


def turn(values: Any) -> Quaternion:
    """An orientation of MuJoCo, which has the real part first."""
    w, x, y, z = values.tolist()
    return (x, y, z, w)


def geom_of(shape: Shape) -> tuple[Any, Vector]:
    """MuJoCo's type and size of a shape."""
    match shape:
        case Box(half_m):
            return mujoco.mjtGeom.mjGEOM_BOX, half_m
        case Sphere(radius_m):
            return mujoco.mjtGeom.mjGEOM_SPHERE, (radius_m, 0.0, 0.0)
        case Cylinder(radius_m, length_m):
            return mujoco.mjtGeom.mjGEOM_CYLINDER, (radius_m, length_m / 2.0, 0.0)


def link_of(body: Any, links: Sequence[Any]) -> int:
    """The number of the moving link that a body of a description is or is fixed to; -1 for the base."""
    names = [link.name for link in links]
    while body.name != "world":
        if body.name in names:
            return names.index(body.name)
        body = body.parent
    return -1
