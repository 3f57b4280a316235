"""What a testbench says of ROS 2, checked before anything runs."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.execution.case import RunSettings, execute
from pytest_hricdv.extra.ros2 import system
from pytest_hricdv.extra.ros2.graph import note
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.run import Run, TestbenchError
from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, VirtualTime
from pytest_hricdv.testbench_faults import check_testbench


@dataclass(frozen=True)
class Scan:
    """A message of the bus."""


@pytest.fixture
def testbench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cell_msgs: None) -> Testbench:
    monkeypatch.setattr(system, "prepare", lambda: None)  # there may be no rclpy
    (tmp_path / "requirements.toml").touch()
    (tmp_path / "cell.mas2j").write_text("MAS cell { agents: person; }")
    return Testbench(
        name="cell",
        model=Model(tmp_path / "cell.mas2j"),
        beliefs=BeliefSpace(start=("a",), groups={}),
        concretization=Concretization(commands={}),
        requirements=tmp_path / "requirements.toml",
        messages=(),
        signals={},
        code=("cell",),
        run=lambda run: Outcome("never"),
        ros2=Ros2(topics={"/scan": "cell_msgs/msg/Scan"}),
    )


def test_it_has_the_names_of_the_graph(testbench: Testbench) -> None:
    assert check_testbench(testbench, "here").vocabulary().kind("scan.origin.x") is float


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ros2": "/scan"}, "here: ros2 is '/scan'; expected Ros2(...) or None"),
        ({"messages": (Scan, Scan)}, "here: two message classes have the topic 'scan' on the bus; rename one of them"),
        ({"messages": (Scan,)}, "here: 'scan' is both a message of the bus and a topic of ROS 2; rename one of them"),
        (
            {"ros2": Ros2(topics={"/scan": "cell_msgs/msg/Scn"})},
            "here: ros2: cell_msgs has no msg 'Scn'; nearest: Scan",
        ),
    ],
)
def test_a_mistake_is_said(changes: dict[str, Any], message: str, testbench: Testbench) -> None:
    with pytest.raises(TestbenchError) as caught:
        check_testbench(replace(testbench, **changes), "here")
    assert str(caught.value) == message


KEYS = """
import sys
import termios
import threading
import tty

pressed = []


def read():
    settings = termios.tcgetattr(sys.stdin)
    tty.setraw(sys.stdin.fileno())
    pressed.append(sys.stdin.read(1))
    termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)


def main():
    threading.Thread(target=read).start()
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        pressed.append("interrupted")
"""


def test_each_process_has_a_terminal_at_which_a_person_types(
    testbench: Testbench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(system, "_USED", ())  # there may be no rclpy
    (tmp_path / "typed_node.py").write_text(KEYS)
    monkeypatch.syspath_prepend(tmp_path)

    def run(run: Run) -> Outcome:
        run.ros2(RosNode(entry="typed_node:main", name="left"), RosNode(entry="typed_node:main", name="right"))
        left, right = run.terminal("left"), run.terminal("right")

        def person() -> None:
            for keyboard, key in ((right, "r"), (left, "l"), (right, "ctrl-c"), (left, "ctrl-c")):
                run.kernel.sleep(1.0)
                keyboard.press(key)

        run.kernel.spawn("person", person)
        return Outcome(run.go(limit_s=10.0))

    bench = replace(testbench, code=("typed_node",), run=run, time=VirtualTime(allowed_endings=("idle",)))
    result = execute(RunSettings(bench), ConcreteTest(id="t", suite="by-hand", seed=0, actions=()))
    assert (result.errors, result.sim_s) == ((), 4.0)
    assert sys.modules["typed_node"].pressed == ["r", "l", "interrupted", "interrupted"]
    assert [" ".join(str(message).split()) for message in result.record.messages] == [
        "1.000 person terminal_input terminal=right text=r",
        "2.000 person terminal_input terminal=left text=l",
        "3.000 person terminal_input terminal=right text=ctrl-c",
        "4.000 person terminal_input terminal=left text=ctrl-c",
    ]


NODE = """
import time


def main():
    time.sleep(2.0)
"""


def test_a_node_of_a_run_waits_in_virtual_time(
    testbench: Testbench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(system, "_USED", ())  # there may be no rclpy
    (tmp_path / "sleeping_node.py").write_text(NODE)
    monkeypatch.syspath_prepend(tmp_path)

    def run(run: Run) -> Outcome:
        run.ros2(RosNode(entry="sleeping_node:main"))
        note(run.kernel, "nobody is here")
        return Outcome(run.go(limit_s=10.0))

    bench = replace(testbench, code=("sleeping_node",), run=run, time=VirtualTime(allowed_endings=("idle",)))
    result = execute(RunSettings(bench), ConcreteTest(id="t", suite="by-hand", seed=0, actions=()))
    assert (result.outcome.ended, result.sim_s, result.errors) == ("idle", 2.0, ())
    assert result.has_measured_node
    assert result.notes == ("nobody is here",)
