"""The robot's description against the published joint table."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sim.engine import Engine, bullet
from sim.physics_time import STEP_S
from sim.torso import CLOSED, FINGER_JOINTS, OPEN, URDF, Torso

TABLE: list[dict[str, Any]] = json.loads(Path(__file__).with_name("bert2_joint_table.json").read_text())


@pytest.fixture
def torso() -> Iterator[Torso]:
    with Engine(STEP_S) as engine:
        yield Torso(engine)


def test_has_22_revolute_joints(torso: Torso) -> None:
    revolute = {row["joint"].removesuffix("_joint") for row in TABLE if row["type"] == "revolute"}
    assert len(revolute) == 22
    assert set(torso.joints) == revolute


def test_loads_with_the_limits_of_the_table(torso: Torso) -> None:
    for row in TABLE:
        if row["type"] == "revolute":
            assert torso.limits_rad[row["joint"].removesuffix("_joint")] == (row["lower"], row["upper"])


@pytest.mark.parametrize("row", TABLE, ids=[row["joint"] for row in TABLE])
def test_every_joint_is_as_in_the_table(row: dict[str, Any]) -> None:
    joint = next(j for j in ElementTree.parse(URDF).getroot().findall("joint") if j.get("name") == row["joint"])
    parent, child, origin = joint.find("parent"), joint.find("child"), joint.find("origin")
    assert parent is not None
    assert child is not None
    assert origin is not None
    assert joint.get("type") == row["type"]
    assert (parent.get("link"), child.get("link")) == (row["parent"], row["child"])
    assert [float(x) for x in origin.get("xyz", "").split()] == row["xyz"]
    assert [float(x) for x in origin.get("rpy", "").split()] == row["rpy"]
    axis = joint.find("axis")
    assert (None if axis is None else axis.get("xyz")) == row["axis"]


def test_every_moving_link_has_a_mass_a_shape_and_a_believable_inertia(torso: Torso) -> None:
    for name, index in torso.joints.items():
        mass_kg, _, inertia = bullet.getDynamicsInfo(torso.body, index)[:3]
        assert 0.02 <= mass_kg <= 12.0, name
        assert all(1e-5 <= part <= 1.0 for part in inertia), name
        assert bullet.getCollisionShapeData(torso.body, index), name


def test_finger_poses_are_within_their_limits(torso: Torso) -> None:
    for name, stretched, closed in zip(FINGER_JOINTS, OPEN, CLOSED, strict=True):
        lower, upper = torso.limits_rad[name]
        assert lower < stretched < upper
        assert lower < closed < upper
