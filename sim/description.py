"""The robot's description, read once, and the two bodies that are simulated of it.

`bert2.urdf` is the whole robot with the published joint table's 22 moving joints. Physics pays for each of them in
every step (one unknown of the solver each: 97 us a step for all, 16 us for the arm's nine), so the robot is two bodies:
the arm with everything that it carries, its neck and right shoulder braced; and the left hand's fingers, a body of its
own at the palm that sleeps while the fingers do not move. The fingers' mass stays with the arm.
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
    """URDF text of the robot with only `joints` movable; what hangs on the `palm` joint's link is mass without shape.

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
    """URDF text of what hangs on the `palm` joint's link; its base is that link's frame, without mass and shape.

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
def without_looks(description: str) -> str:
    """URDF text of a robot that nobody looks at: the same bodies, each link's visible shapes one speck.

    PyBullet makes a mesh of every visible sphere and cylinder (5 ms for the arm, more than all else of a world), and
    of the colliding ones where none is visible.
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
    known = {_name(joint) for joint in root.findall("joint")}
    missing = [name for name in joints if name not in known]
    if missing:
        raise SimulationError(f"robot description {urdf}: no joints {missing}; it has {sorted(known)}")
    return root


def _beyond(root: ElementTree.Element, palm: str) -> list[str]:
    """Links that hang, directly or not, on the link that the `palm` joint moves."""
    found = [_end(joint, "child") for joint in root.findall("joint") if _name(joint) == palm]
    for link in found:
        found.extend(_end(joint, "child") for joint in root.findall("joint") if _end(joint, "parent") == link)
    return found[1:]


def _name(joint: ElementTree.Element) -> str:
    return joint.get("name", "").removesuffix("_joint")


def _end(joint: ElementTree.Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")
