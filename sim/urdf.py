"""The robot's URDF description, and the two simplified bodies that are simulated from it.

`bert2.urdf` is the whole robot with the 22 moving joints of the published joint table. Each joint costs time in every
step (one unknown of the solver: 97 us per step for all, 16 us for the arm's nine). So the robot is two bodies: the arm
and everything fixed to it, with neck and right shoulder fixed; and the left hand's fingers, a separate body at the palm
that sleeps while the fingers do not move. The fingers' mass belongs to the arm.

Fixed joints are removed by merging their links. PyBullet can do this while it loads (URDF_MERGE_FIXED_LINKS), but leaks
the memory of every merged link: 80 kB for each world. So it does it once, to compute the inertia of the merged links;
after that the same bodies, to the bit, are loaded without it.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.engine import STEP_S, Engine, SimulationError, bullet

Frame = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Place (m) and rotation matrix."""

URDF = Path(__file__).with_name("bert2.urdf")


@cache
def arm_description(joints: tuple[str, ...], palm: str, urdf: Path = URDF) -> str:
    """URDF text of the robot with only `joints` movable; links beyond the `palm` joint's link have mass but no shape.

    Raises:
        SimulationError: the description has no such joint, or cannot be read.
    """
    root = _read(urdf, (*joints, palm))
    for joint in root.findall("joint"):
        if _name(joint) not in joints:
            joint.set("type", "fixed")
    beyond = set(_beyond(root, palm))
    for link in root.findall("link"):
        if link.get("name") in beyond:
            for part in (*link.findall("visual"), *link.findall("collision")):
                link.remove(part)
    return ElementTree.tostring(root, encoding="unicode")


@cache
def hand_description(fingers: tuple[str, ...], palm: str, urdf: Path = URDF) -> str:
    """URDF text of the links beyond the `palm` joint's link; the base is that link's frame, without mass and shape.

    Raises:
        SimulationError: the description has no such joint, or cannot be read.
    """
    root = _read(urdf, (*fingers, palm))
    beyond = set(_beyond(root, palm))
    hand = ElementTree.Element("robot", name=f"{root.get('name')}_hand")
    hand.extend(root.findall("material"))
    ElementTree.SubElement(hand, "link", name=f"{palm}_link")
    hand.extend(copy.deepcopy(link) for link in root.findall("link") if link.get("name") in beyond)
    hand.extend(joint for joint in root.findall("joint") if _end(joint, "child") in beyond)
    return ElementTree.tostring(hand, encoding="unicode")


@cache
def without_visuals(description: str) -> str:
    """URDF text of the same bodies whose visual shapes are replaced by one tiny box for each link.

    PyBullet makes a mesh of every visual sphere and cylinder (5 ms for the arm, more than the rest of a world), and of
    the collision shapes of a link without visual shapes.
    """
    root = ElementTree.fromstring(description)
    for link in root.findall("link"):
        seen = link.findall("visual")
        for part in seen:
            link.remove(part)
        if seen:
            speck = ElementTree.SubElement(ElementTree.SubElement(link, "visual"), "geometry")
            ElementTree.SubElement(speck, "box", size="0.001 0.001 0.001")
    return ElementTree.tostring(root, encoding="unicode")


@cache
def merge_fixed_joints(description: str) -> str:
    """URDF text of the same robot with a fixed base and movable joints only.

    Raises:
        SimulationError: PyBullet refuses the description.
    """
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
    with Engine(STEP_S) as engine:
        body, joints, _ = engine.load(description, may_sleep=False, merge_links=True)
        where = {"physicsClientId": engine.client}
        names = {index: bullet.getJointInfo(body, index, **where)[12].decode() for index in joints.values()}
        return {name: bullet.getDynamicsInfo(body, index, **where) for index, name in names.items()}


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


def _read(urdf: Path, joints: Sequence[str]) -> ElementTree.Element:
    try:
        root = ElementTree.parse(urdf).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise SimulationError(f"robot description {urdf}: {error}") from error
    known = {_name(joint) for joint in root.findall("joint")}
    missing = [name for name in joints if name not in known]
    if missing:
        raise SimulationError(f"robot description {urdf}: no joints {missing}; it has {sorted(known)}")
    return root


def _beyond(root: ElementTree.Element, palm: str) -> list[str]:
    """Links connected, directly or indirectly, to the link that the `palm` joint moves."""
    found = [_end(joint, "child") for joint in root.findall("joint") if _name(joint) == palm]
    for link in found:
        found.extend(_end(joint, "child") for joint in root.findall("joint") if _end(joint, "parent") == link)
    return found[1:]


def _name(joint: ElementTree.Element) -> str:
    return joint.get("name", "").removesuffix("_joint")


def _end(joint: ElementTree.Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")
