"""What is seen of a robot."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from functools import cache
from typing import Any

from sim.geometry import Pose
from sim.mujoco.body import link_of, turn, vector
from sim.mujoco.library import load, mujoco
from sim.shapes import Box, Cylinder, LinkShape, Shape, Sphere


@cache
def shapes_of_description(description: str) -> tuple[LinkShape, ...]:
    """The visual shapes of a robot, from URDF text."""
    root = ElementTree.fromstring(description)
    compiler = ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler")
    compiler.set("discardvisual", "false")  # as it does when it loads a URDF
    spec = load(ElementTree.tostring(root, encoding="unicode"))
    links = [joint.parent for joint in spec.joints]
    owners = [link_of(geom.parent, links) for geom in spec.geoms]
    spec.compiler.fusestatic = True
    model = spec.compile()
    return tuple(
        LinkShape(owners[number], _shape(model, number), _at(model, number), tuple(model.geom_rgba[number].tolist()))
        for number in range(model.ngeom)
        if not model.geom_contype[number]
    )


def _shape(model: Any, number: int) -> Shape:
    x, y, z = model.geom_size[number].tolist()
    kind = model.geom_type[number]
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return Box((x, y, z))
    return Sphere(x) if kind == mujoco.mjtGeom.mjGEOM_SPHERE else Cylinder(x, 2.0 * y)


def _at(model: Any, number: int) -> Pose:
    return vector(model.geom_pos[number]), turn(model.geom_quat[number])
