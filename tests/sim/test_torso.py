"""The robot's description against the published joint table."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from controller.ports import ARM_JOINTS
from sim.engine import Engine, SimulationError
from sim.engines import new_engine
from sim.fingers import FINGER_JOINTS, Fingers
from sim.torso import PALM, Torso
from sim.urdf import URDF, arm_description

TABLE: list[dict[str, Any]] = json.loads(Path(__file__).with_name("bert2_joint_table.json").read_text())
REVOLUTE = {row["joint"].removesuffix("_joint"): row for row in TABLE if row["type"] == "revolute"}
BRACED = {"neck_flexor", "neck_rotor", "right_shoulder_flex"}


def robot(engine: Engine) -> tuple[Torso, Fingers]:
    torso = Torso(engine)
    return torso, Fingers(engine, torso.palm_pose())


@pytest.fixture
def bodies() -> Iterator[tuple[Torso, Fingers]]:
    with new_engine() as engine:
        yield robot(engine)


def test_of_22_revolute_joints_arm_and_fingers_move_and_three_are_braced(bodies: tuple[Torso, Fingers]) -> None:
    torso, fingers = bodies
    assert len(REVOLUTE) == 22
    assert set(torso.joints) == set(ARM_JOINTS)
    assert set(fingers.joints) == set(FINGER_JOINTS)
    assert {*torso.joints, *fingers.joints, *BRACED} == set(REVOLUTE)


def test_loads_with_the_limits_of_the_table(bodies: tuple[Torso, Fingers]) -> None:
    for body in bodies:
        for name, limits in body.limits_rad.items():
            assert limits == (REVOLUTE[name]["lower"], REVOLUTE[name]["upper"])


@pytest.mark.engine("pybullet")
def test_the_arm_carries_the_mass_of_everything_but_the_stand(bodies: tuple[Torso, Fingers]) -> None:
    masses = {
        str(link.get("name")): float(mass.get("value", "0"))
        for link in ElementTree.parse(URDF).getroot().findall("link")
        for mass in link.findall("inertial/mass")
    }
    whole_kg = sum(mass for name, mass in masses.items() if name not in ("base_link", "hip_base_link"))
    bullet = pytest.importorskip("pybullet")
    arm_kg = sum(bullet.getDynamicsInfo(bodies[0].body, index)[0] for index in bodies[0].joints.values())
    assert arm_kg == pytest.approx(whole_kg)


def test_a_description_without_a_joint_is_refused_by_name(tmp_path: Path) -> None:
    lame = tmp_path / "lame.urdf"
    lame.write_text(URDF.read_text(encoding="utf-8").replace('"left_elbow_flex_joint"', '"stiff_joint"'))
    with pytest.raises(SimulationError, match=r"lame\.urdf: no joints \['left_elbow_flex'\]; it has \['base'"):
        arm_description(ARM_JOINTS, PALM, lame)
    with pytest.raises(SimulationError, match=r"nowhere\.urdf.*No such file"):
        arm_description(ARM_JOINTS, PALM, tmp_path / "nowhere.urdf")
    lame.write_text("<robot>")
    with pytest.raises(SimulationError, match=r"lame\.urdf: no element found"):
        arm_description(ARM_JOINTS, PALM, lame)


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
