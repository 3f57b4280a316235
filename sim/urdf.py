"""The robot's URDF description, and the two simplified bodies that are simulated from it.

`bert2.urdf` is the whole robot with the 22 moving joints of the published joint table. Each joint costs time in every
step (one unknown of the solver: 97 us per step for all, 16 us for the arm's nine). So the robot is two bodies: the arm
and everything fixed to it, with neck and right shoulder fixed; and the left hand's fingers, a separate body at the palm
that sleeps while the fingers do not move. The fingers' mass belongs to the arm.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from sim.engine import SimulationError

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


def _read(urdf: Path, joints: Sequence[str]) -> ElementTree.Element:
    try:
        root = ElementTree.parse(urdf).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise SimulationError(f"robot description {urdf}: {error}") from error
    described = {_name(joint) for joint in root.findall("joint")}
    missing = [name for name in joints if name not in described]
    if missing:
        raise SimulationError(f"robot description {urdf}: no joints {missing}; it has {sorted(described)}")
    return root


def _beyond(root: ElementTree.Element, palm: str) -> list[str]:
    """Links connected, directly or indirectly, to the link that the `palm` joint moves."""
    links = [_end(joint, "child") for joint in root.findall("joint") if _name(joint) == palm]
    for link in links:
        links.extend(_end(joint, "child") for joint in root.findall("joint") if _end(joint, "parent") == link)
    return links[1:]


def _name(joint: ElementTree.Element) -> str:
    return joint.get("name", "").removesuffix("_joint")


def _end(joint: ElementTree.Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")
