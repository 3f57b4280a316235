"""Rigid joints welded: the same bodies as PyBullet's own merging gives, to the bit, and no memory lost."""

from __future__ import annotations

from typing import Any

import pytest

from controller.ports import ARM_JOINTS
from pytest_hricdv.runtime import Recorder
from sim.description import arm_description, without_looks
from sim.engine import Engine, SimulationError, bullet
from sim.physics_time import STEP_S
from sim.torso import PALM
from sim.welding import welded
from sim.world import World
from tests.sim.memory import resident_kb


def bodies(description: str, *, merges: bool) -> dict[str, Any]:
    """What an engine knows of a robot's links: joints, limits, masses, inertia, frames; and where they can be hit."""
    with Engine(STEP_S) as engine:
        body, joints, limits = engine.load(description, sleeps=False, merges=merges)
        links, told = range(-1, len(joints)), {"physicsClientId": engine.client}
        hit = [
            [(shape[2], *shape[3], *shape[5], *shape[6]) for shape in bullet.getCollisionShapeData(body, link, **told)]
            for link in links
        ]
        return {
            "joints": joints,
            "limits": limits,
            "frames": [bullet.getJointInfo(body, link, **told) for link in links[1:]],
            "weights": [bullet.getDynamicsInfo(body, link, **told) for link in links],
            "hit": [sorted(tuple(round(value, 9) + 0.0 for value in shape) for shape in shapes) for shapes in hit],
        }


def test_a_welded_robot_is_the_one_that_pybullet_merges_to_the_bit() -> None:
    description = without_looks(arm_description(ARM_JOINTS, PALM))
    mine, its = bodies(welded(description), merges=False), bodies(description, merges=True)
    assert tuple(mine["joints"]) == ARM_JOINTS
    for what, value in its.items():
        assert mine[what] == value, what


def test_a_robot_that_cannot_be_loaded_is_not_welded() -> None:
    description = without_looks(arm_description(ARM_JOINTS, PALM)).replace(
        '<parent link="base_link"', '<parent link="b"'
    )
    with pytest.raises(SimulationError, match="PyBullet refused the robot description"):
        welded(description)


def test_a_world_that_is_closed_leaves_no_memory_behind() -> None:
    for _ in range(30):
        World(Recorder()).close()
    before_kb = resident_kb()
    for _ in range(60):
        World(Recorder()).close()
    assert resident_kb() - before_kb < 60 * 20  # each lost 80 kB while PyBullet merged the links
