"""What of a drafted stand-in follows what it is told, and how it moves."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files, write
from tests.extra.draft.test_observed import Bus, Recorder

HEAD = """
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Go:
    pass


@dataclass(frozen=True)
class Pose:
    x: float
    y: float
    yaw: float = 0.0


@dataclass(frozen=True)
class Speed:
    linear: float
    angular: float


@dataclass(frozen=True)
class Hand:
    close: bool


@dataclass(frozen=True)
class Opening:
    width: float


class Base(Protocol):
    def pose(self) -> Pose: ...
    def drive(self, speed: Speed) -> None: ...


class Gripper(Protocol):
    def command(self, hand: Hand) -> None: ...
    def state(self) -> Opening: ...


"""

CODE = """
class Robot:
    def __init__(self, bus, device{annotation}, clock):
        self.device, self.clock, self.goes = device, clock, bus.subscribe(Go)

    def run(self):
        while True:
            self.goes.wait(1.0)
            {lines}
"""


def draft_of(folder: Path, lines: str, annotation: str = "") -> Draft:
    """The draft of a robot with one device, with which it does this."""
    robot = CODE.format(annotation=annotation and f": {annotation}", lines=lines.replace("\n", "\n            "))
    (folder / "robot_code.py").write_text(HEAD + robot, encoding="utf-8")
    return Draft(analyse("robot_code", folder), "robot_code", "person", folder.resolve())


@pytest.mark.parametrize(
    ("lines", "annotation", "found"),
    [
        ("self.device.pose().x\nself.device.drive(Speed(0.2, 0.1))", "Base", [("x y yaw", "drive")]),
        ("self.device.state().width\nself.device.command(Hand(True))", "Gripper", [("width", "switch")]),
        ("x, y, theta = self.device.odometry()\nself.device.set_speed(0.2, 0.1)", "", [("x y theta", "drive")]),
        ("x, y, _ = self.device.odometry()\nself.device.wheels(left=0.2, right=0.1)", "", [("x y", "wheels")]),
        ("x, y = self.device.position()\nself.device.go_to(2.0, 1.0)", "", [("x y", "reach")]),
        ("x, y = self.device.position()\nself.device.move(v=2.0, w=1.0)\nself.device.stop()", "",
         [("x y", "drive drive")]),
        ("if self.device.is_open(): pass\nself.device.open()\nself.device.close()", "", [("is_open", "up down")]),
        ("if self.device.is_closed(): pass\nself.device.open()\nself.device.close()", "", [("is_closed", "down up")]),
        ("if self.device.height_m() > 1.0: pass\nself.device.set_height_m(1.2)", "", [("height_m", "target")]),
        ("if self.device.position() > 1.0: pass\nself.device.set_speed(1.2)", "", [("position", "speed")]),
        ("if self.device.position > 1.0: pass\nself.device.speed = 0.2", "", [("position", "speed")]),
        ("if self.device.position > 1.0: pass\nself.device.speed = 0.2\nself.device.stop()", "",
         [("position", "speed speed")]),
        ("if self.device.is_lifted(): pass\nself.device.drive(1.0, 0.0)", "", []),
        ("if self.device.is_open(): pass\nself.device.lock()", "", []),
        ("if not self.device.close(): pass\nself.device.open()", "", []),
        ("if self.device.battery_v() < 11.0: pass\nself.device.start()", "", []),
        ("if self.device.ahead_m() < 0.6: pass\nself.device.brush = True", "", []),
    ],
)  # fmt: skip
def test_what_follows_what_is_said_by_names(
    lines: str, annotation: str, found: list[tuple[str, str]], tmp_path: Path
) -> None:
    moving = draft_of(tmp_path, lines, annotation).motions.get("device", ())
    assert [
        (" ".join(value.name for value in motion.readings), " ".join(command.kind for command in motion.commands))
        for motion in moving
    ] == found


def stand_in(folder: Path, draft: Draft) -> tuple[Any, Any, SimpleNamespace, Recorder]:
    """The stand-in for the device of a draft, its world, and the clock and recorder of this."""
    texts = dict(files(draft))
    modules = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        for name in ("world", "ports"):
            modules[name] = ModuleType(name)
            patch.setitem(sys.modules, name, modules[name])
            exec(compile(texts[f"{name}.py"], name, "exec"), modules[name].__dict__)
    kernel, recorder = SimpleNamespace(now_s=0.0), Recorder()
    world = modules["world"].World(kernel, recorder, Bus())
    return modules["ports"].Device(world), world, kernel, recorder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robot")


@pytest.fixture(scope="module")
def base(folder: Path) -> Draft:
    return draft_of(folder, "x, y, theta = self.device.odometry()\nself.device.set_speed(0.2, 0.1)")


@given(
    told=st.lists(
        st.tuples(st.floats(-1, 1), st.one_of(st.just(0.0), st.floats(-2, 2)), st.floats(0.01, 5)), max_size=4
    )
)
@example(told=[(0.0, 5e-324, 1.0)])  # half of it is 0
def test_a_base_drives_on_arcs(folder: Path, base: Draft, told: list[tuple[float, float, float]]) -> None:
    device, _, kernel, _ = stand_in(folder, base)
    x = y = heading = 0.0
    for forward, turn, duration_s in told:
        device.set_speed(forward, turn)
        kernel.now_s += duration_s
        for _ in range(2000):  # slower and simpler: many small straight steps
            step_s = duration_s / 2000
            x += forward * step_s * math.cos(heading + turn * step_s / 2)
            y += forward * step_s * math.sin(heading + turn * step_s / 2)
            heading += turn * step_s
    at = device.odometry()
    assert at[:2] == pytest.approx((x, y), abs=1e-4)
    assert math.remainder(at[2] - heading, math.tau) == pytest.approx(0.0, abs=1e-6)


def test_where_a_base_is_does_not_depend_on_how_often_one_asks(folder: Path, base: Draft) -> None:
    ends = []
    for asks in (1, 7, 100):
        device, _, kernel, _ = stand_in(folder, base)
        device.set_speed(0.5, 0.3)
        for _ in range(asks):
            kernel.now_s += 10.0 / asks
            device.odometry()
        ends.append(device.odometry())
    assert ends[0] == pytest.approx(ends[1])
    assert ends[0] == pytest.approx(ends[2])


def test_where_a_base_is_and_what_it_is_told_are_signals(folder: Path, base: Draft) -> None:
    device, _, kernel, recorder = stand_in(folder, base)
    device.set_speed(0.5, 0.0)
    kernel.now_s = 2.0
    device.odometry()
    assert (2.0, "device_x", 1.0) in recorder.signals
    assert (0.0, "device_set_speed_argument_1", 0.5) in recorder.signals


@pytest.mark.parametrize(
    "lines",
    [
        "x, y, theta = self.device.odometry()\nself.device.set_speed(0.2, 0.1)",
        "x, y, heading_deg = self.device.pose()\nself.device.drive(forward_m_s=0.2, turn_deg_s=45.0)",
        "x, y = self.device.position()\nself.device.go_to(2.0, 1.0)",
        "x, y = self.device.position()\nself.device.wheels(left=0.2, right=0.1)",
        "if self.device.is_open(): pass\nself.device.open()",
    ],
)
def test_stand_ins_that_move_pass_ruff(lines: str, tmp_path: Path) -> None:
    folder = tmp_path.resolve() / "hri"
    write(replace(draft_of(tmp_path, lines), folder=folder), folder)
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "I,F,E4,E7,E9,B", "."]
    checked = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_a_heading_is_in_degrees_where_its_name_says_so(tmp_path: Path) -> None:
    lines = "x, y, heading_deg = self.device.pose()\nself.device.drive(forward_m_s=0.2, turn_deg_s=45.0)"
    device, _, kernel, _ = stand_in(tmp_path, draft_of(tmp_path, lines))
    device.drive(0.0, 45.0)
    kernel.now_s = 2.0
    assert device.pose() == pytest.approx((0.0, 0.0, 90.0))
    device.drive(1.0, 0.0)
    kernel.now_s = 5.0
    assert device.pose() == pytest.approx((0.0, 3.0, 90.0))


def test_a_base_that_is_told_where_to_go_is_there_after_a_while(tmp_path: Path) -> None:
    draft = draft_of(tmp_path, "x, y = self.device.position()\nself.device.go_to(2.0, 1.0)")
    device, _, kernel, _ = stand_in(tmp_path, draft)
    device.go_to(2.0, -1.0)
    kernel.now_s = 0.5
    assert device.position() == pytest.approx((1.0, -0.5))
    kernel.now_s = 9.0
    assert device.position() == pytest.approx((2.0, -1.0))


def test_a_gripper_is_open_and_closes_and_not_wholly_where_something_is_in_its_way(tmp_path: Path) -> None:
    draft = draft_of(tmp_path, "self.device.state().width\nself.device.command(Hand(True))", "Gripper")
    device, world, kernel, recorder = stand_in(tmp_path, draft)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(tmp_path)
        patch.delitem(sys.modules, "robot_code", raising=False)
        hand = import_module("robot_code").Hand  # the stand-in makes the code's own classes
        device.command(hand(close=False))
        kernel.now_s = 2.0
        opened = device.state().width
        device.command(hand(close=True))
        kernel.now_s = 2.5
        halfway = device.state().width
        kernel.now_s = 4.0
        closed = device.state().width
        world.ways["device_state_width"] = 0.25
        device.command(hand(close=False))
        kernel.now_s = 6.0
        short = device.state().width
        del sys.modules["robot_code"]
    assert (opened, halfway, closed, short) == (1.0, 0.5, 0.0, 0.25)
    assert (2.0, "device_command_hand_close", True) in recorder.signals
    assert (6.0, "device_state_width", 0.25) in recorder.signals
