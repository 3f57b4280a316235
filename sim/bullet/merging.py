"""Robot descriptions without fixed joints, by merging the links that these join.

PyBullet can do this while it loads (URDF_MERGE_FIXED_LINKS), but leaks the memory of every merged link: 80 kB for each
world. So it does it once, to compute the inertia of the merged links; after that the same bodies, bit for bit, are
loaded without it.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.bullet.client import bullet, connect, load

Frame = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Place (m) and rotation matrix."""


@cache
def merge_fixed_joints(description: str) -> str:
    """URDF text of the same robot with a fixed base and movable joints only.

    Raises:
        SimulationError: PyBullet refuses the description.
    """
    if 'type="fixed"' not in description:
        return description
    dynamics = _dynamics(description)
    root = ElementTree.fromstring(description)
    links = {link.get("name", ""): link for link in root.findall("link")}
    merged: set[str] = set()
    while (joint := _last_fixed_joint(root)) is not None:
        parent = _end_of(joint, "parent").get("link", "")
        child = links[_end_of(joint, "child").get("link", "")]
        _move_shapes(child, links[parent], _frame(joint))
        for other in root.findall("joint"):
            if _end_of(other, "parent").get("link") == child.get("name"):
                _end_of(other, "parent").set("link", parent)
                _put(other, _within(_frame(joint), _frame(other)))
        root.remove(joint)
        root.remove(child)
        merged.add(parent)
    for name in merged & dynamics.keys():
        _set_inertia(links[name], dynamics[name])
    return ElementTree.tostring(root, encoding="unicode")


def _last_fixed_joint(root: ElementTree.Element) -> ElementTree.Element | None:
    """The next fixed joint to merge: the last one, because links beyond its child are then merged already."""
    return next((joint for joint in reversed(root.findall("joint")) if joint.get("type") == "fixed"), None)


def _move_shapes(child: ElementTree.Element, parent: ElementTree.Element, frame: Frame) -> None:
    for shape in (*child.findall("collision"), *child.findall("visual")):
        _put(shape, _within(frame, _frame(shape)))
        parent.append(shape)


def _dynamics(description: str) -> dict[str, tuple[Any, ...]]:
    """Link -> its dynamics after PyBullet's own merging; the fixed base needs none."""
    client = connect()
    where = {"physicsClientId": client}
    try:
        body = load(client, description, bullet.URDF_MERGE_FIXED_LINKS)
        indices = range(bullet.getNumJoints(body, **where))
        names = {index: bullet.getJointInfo(body, index, **where)[12].decode() for index in indices}
        return {name: bullet.getDynamicsInfo(body, index, **where) for index, name in names.items()}
    finally:
        bullet.disconnect(**where)


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
    """Frame of a joint or shape relative to its link. PyBullet's functions for this have single precision."""
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
    origin.set("xyz", " ".join(repr(x + 0.0) for x in frame[0].tolist()))  # adding 0.0 turns minus zero into zero
    origin.set("rpy", " ".join(repr(angle + 0.0) for angle in angles))


def _end_of(joint: ElementTree.Element, which: str) -> ElementTree.Element:
    end = joint.find(which)
    assert end is not None, "PyBullet would have refused it"
    return end
