"""Rigid joints welded: the same bodies as PyBullet's own merging gives, to the bit."""

from __future__ import annotations

from typing import Any

import pytest

from controller.ports import ARM_JOINTS
from sim.bullet.client import bullet, connect, load
from sim.bullet.merging import merge_fixed_joints
from sim.engine import SimulationError
from sim.torso import PALM
from sim.urdf import arm_description, without_visuals


def bodies(description: str, *, merge_links: bool) -> dict[str, Any]:
    """What PyBullet knows of a robot's links: joints, limits, masses, inertia, frames; and where they can be hit."""
    client = connect()
    where = {"physicsClientId": client}
    body = load(client, description, bullet.URDF_MERGE_FIXED_LINKS if merge_links else 0)
    links = range(-1, bullet.getNumJoints(body, **where))
    hit = [
        [(shape[2], *shape[3], *shape[5], *shape[6]) for shape in bullet.getCollisionShapeData(body, link, **where)]
        for link in links
    ]
    found = {
        "frames": [bullet.getJointInfo(body, link, **where) for link in links[1:]],
        "dynamics": [bullet.getDynamicsInfo(body, link, **where) for link in links],
        "hit": [sorted(tuple(round(value, 9) + 0.0 for value in shape) for shape in shapes) for shapes in hit],
    }
    bullet.disconnect(client)
    return found


@pytest.mark.engine("pybullet")
def test_merged_links_equal_those_that_pybullet_merges_to_the_bit() -> None:
    description = without_visuals(arm_description(ARM_JOINTS, PALM))
    mine, its = bodies(merge_fixed_joints(description), merge_links=False), bodies(description, merge_links=True)
    names = [frame[1].decode().removesuffix("_joint") for frame in mine["frames"]]
    assert tuple(names) == ARM_JOINTS
    for what, value in its.items():
        assert mine[what] == value, what


@pytest.mark.engine("pybullet")
def test_a_description_that_cannot_be_loaded_is_refused_when_merging() -> None:
    description = without_visuals(arm_description(ARM_JOINTS, PALM)).replace(
        '<parent link="base_link"', '<parent link="b"'
    )
    with pytest.raises(SimulationError, match="PyBullet refused the robot description"):
        merge_fixed_joints(description)
