"""A robot description without rigid joints: the links that they join made one.

PyBullet can do this while it loads (URDF_MERGE_FIXED_LINKS), but loses the memory of every link that it merges: 80 kB a
world here, for good. So it does it once, to say what the welded links weigh; the same bodies to the bit are then loaded
without it.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.engine import Engine, bullet
from sim.physics_time import STEP_S

Frame = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Place (m) and rotation matrix."""


@cache
def welded(description: str) -> str:
    """URDF text of the same robot, for a fixed base, with movable joints only.

    Raises:
        SimulationError: PyBullet refuses the description.
    """
    weights = _weights(description)
    root = ElementTree.fromstring(description)
    links = {link.get("name", ""): link for link in root.findall("link")}
    heavier: set[str] = set()
    while (joint := _rigid(root)) is not None:
        parent = _end(joint, "parent").get("link", "")
        child = links[_end(joint, "child").get("link", "")]
        _move_shapes(child, links[parent], _frame(joint))
        for other in root.findall("joint"):
            if _end(other, "parent").get("link") == child.get("name"):
                _end(other, "parent").set("link", parent)
                _put(other, _within(_frame(joint), _frame(other)))
        root.remove(joint)
        root.remove(child)
        heavier.add(parent)
    for name in heavier & weights.keys():
        _set_inertia(links[name], weights[name])
    return ElementTree.tostring(root, encoding="unicode")


def _rigid(root: ElementTree.Element) -> ElementTree.Element | None:
    """A rigid joint to be welded next: the last one, so that what hangs on its child is welded to that already."""
    return next((joint for joint in reversed(root.findall("joint")) if joint.get("type") == "fixed"), None)


def _move_shapes(child: ElementTree.Element, parent: ElementTree.Element, frame: Frame) -> None:
    for shape in (*child.findall("collision"), *child.findall("visual")):
        _put(shape, _within(frame, _frame(shape)))
        parent.append(shape)


def _weights(description: str) -> dict[str, tuple[Any, ...]]:
    """Link -> what PyBullet's own merging makes it weigh; the base is fixed, and needs no weight."""
    with Engine(STEP_S) as engine:
        body, joints, _ = engine.load(description, sleeps=False, merges=True)
        told = {"physicsClientId": engine.client}
        names = {index: bullet.getJointInfo(body, index, **told)[12].decode() for index in joints.values()}
        return {name: bullet.getDynamicsInfo(body, index, **told) for index, name in names.items()}


def _set_inertia(link: ElementTree.Element, dynamics: tuple[Any, ...]) -> None:
    mass_kg, moments, centre_m = dynamics[0], dynamics[2], dynamics[3]  # along the link's own axes
    old = link.find("inertial")
    if old is not None:
        link.remove(old)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=" ".join(map(repr, centre_m)), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(mass_kg))
    ixx, iyy, izz = map(repr, moments)
    ElementTree.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)


def _frame(part: ElementTree.Element) -> Frame:
    """Of a joint or shape, in that of its link: PyBullet's own functions for this are of single precision."""
    origin = part.find("origin")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    roll, pitch, yaw = map(float, rpy.split())
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(angle), math.cos(angle)) for angle in (roll, pitch, yaw))
    turned = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array([*map(float, xyz.split())]), np.array(turned)


def _within(outer: Frame, inner: Frame) -> Frame:
    return outer[0] + outer[1] @ inner[0], outer[1] @ inner[1]


def _put(part: ElementTree.Element, frame: Frame) -> None:
    origin = part.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(part, "origin")
    (r00, _, _), (r10, _, _), (r20, r21, r22) = frame[1].tolist()
    angles = math.atan2(r21, r22), math.atan2(-r20, math.hypot(r00, r10)), math.atan2(r10, r00)
    origin.set("xyz", " ".join(repr(x + 0.0) for x in frame[0].tolist()))  # 0.0 makes a zero of minus zero
    origin.set("rpy", " ".join(repr(angle + 0.0) for angle in angles))


def _end(joint: ElementTree.Element, which: str) -> ElementTree.Element:
    end = joint.find(which)
    assert end is not None, "PyBullet would not have loaded it"
    return end
