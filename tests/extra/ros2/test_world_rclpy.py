"""Nodes of the real `rclpy` with what surrounds them: stand-ins, a person at the terminal, messages that take time."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.ros2 import Navigation, PlanarBase
from pytest_hricdv.run import Run
from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Ros2, RosNode, Testbench, VirtualTime
from pytest_hricdv.testbench_faults import check_testbench

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),  # of rclpy itself
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy"),
]

INTERFACES = tuple(
    sorted(folder for folder in (Path(__file__).parent / "interface_files").iterdir() if folder.is_dir())
)

COMMANDER = """
import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient

log = []


def main():
    rclpy.init()
    node = rclpy.create_node("commander")
    client = ActionClient(node, NavigateToPose, "navigate_to_pose")
    log.append(client.wait_for_server(timeout_sec=1.0))
    goal = NavigateToPose.Goal()
    goal.pose.pose.position.x = 2.0
    ways = []
    for is_cancelled in (False, True):
        sent = client.send_goal_async(goal, lambda message: ways.append(message.feedback.distance_remaining))
        rclpy.spin_until_future_complete(node, sent)
        if is_cancelled:
            rclpy.spin_until_future_complete(node, rclpy.task.Future(), timeout_sec=0.35)
            cancel = sent.result().cancel_goal_async()
            rclpy.spin_until_future_complete(node, cancel)
            log.append(len(cancel.result().goals_canceling))
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(node, result)
        log.append(result.result().status)
        goal.pose.pose.position.x = 0.0
    log.append((len(ways), max(ways)))
"""

TELEOP = """
import sys
import termios
import threading
import tty

import rclpy
from geometry_msgs.msg import Twist


def main():
    settings = termios.tcgetattr(sys.stdin)
    rclpy.init()
    node = rclpy.create_node("teleop")
    publisher = node.create_publisher(Twist, "cmd_vel", 10)
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    tty.setraw(sys.stdin.fileno())
    while (key := sys.stdin.read(1)) != "\\x03":
        twist = Twist()
        twist.linear.x = {"w": 0.5, "x": -0.5}.get(key, 0.0)
        publisher.publish(twist)
    termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)
    rclpy.shutdown()
"""

LISTENER = """
import rclpy
from std_msgs.msg import String

log = []


def main():
    rclpy.init()
    node = rclpy.create_node("listener")
    start = node.get_clock().now()

    def hear(message):
        log.append((message.data, (node.get_clock().now() - start).nanoseconds))

    node.create_subscription(String, "chatter", hear, 10)
    rclpy.spin(node)
"""


def play(
    folder: Path, source: str, world: Callable[[Run, Any], None], monkeypatch: pytest.MonkeyPatch, **declared: Any
) -> CaseResult:
    """Run a node, and what surrounds it."""
    (folder / "requirements.toml").touch()
    (folder / "cell.mas2j").write_text("MAS cell { agents: person; }")
    (folder / "played_node.py").write_text(source)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "played_node", raising=False)

    def run(run: Run) -> Outcome:
        world(run, run.ros2(RosNode(entry="played_node:main", name="played")))
        return Outcome(run.go(limit_s=20.0))

    testbench = Testbench(
        name="cell",
        model=Model(folder / "cell.mas2j"),
        beliefs=BeliefSpace(start=("a",), groups={}),
        concretization=Concretization(commands={}),
        requirements=folder / "requirements.toml",
        messages=(),
        signals={},
        code=("played_node",),
        run=run,
        time=VirtualTime(allowed_endings=("idle", "limit", "early")),
        ros2=replace(Ros2(interfaces=INTERFACES), **declared),
    )
    return execute(
        RunSettings(check_testbench(testbench, "here")), ConcreteTest(id="t", suite="by-hand", seed=0, actions=())
    )


def test_an_action_client_of_rclpy_is_served_by_a_fake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def world(run: Run, ros: Any) -> None:
        Navigation(ros, PlanarBase(ros, odom="", tf=""), speed_m_s=1.0).navigate_to_pose()

    result = play(tmp_path, COMMANDER, world, monkeypatch)
    assert result.errors == ()
    assert sys.modules["played_node"].log == [True, 4, 1, 5, (24, 2.0)]


def test_a_person_drives_a_base_by_the_keys_of_a_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bases: list[PlanarBase] = []
    before = os.ttyname(0) if os.isatty(0) else ""

    def world(run: Run, ros: Any) -> None:
        bases.append(PlanarBase(ros, tf=""))
        keyboard = run.terminal("played")

        def person() -> None:
            for key in ("w", "s", "x", "ctrl-c"):
                run.kernel.sleep(2.0)
                keyboard.press(key)

        run.kernel.spawn("person", person)

    result = play(tmp_path, TELEOP, world, monkeypatch, topics={"/cmd_vel": "geometry_msgs/msg/Twist"})
    assert result.errors == ()
    speeds = [message.fields["linear.x"] for message in result.record.messages if message.topic == "cmd_vel"]
    assert speeds == [0.5, 0.0, -0.5]
    assert bases[0].pose.x_m == pytest.approx(1.0 - 0.5 * (20.0 - 6.0))  # nobody stops it after ctrl-c
    assert (os.ttyname(0) if os.isatty(0) else "") == before


def test_messages_reach_a_node_of_rclpy_late_and_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def world(run: Run, ros: Any) -> None:
        publisher = ros.node("talker").publisher("/chatter", "std_msgs/msg/String")

        def talker() -> None:
            from std_msgs.msg import String  # type: ignore[import-not-found, unused-ignore]

            for number in range(5):
                run.kernel.sleep(1.0)
                publisher.publish(String(data=str(number)))

        run.kernel.spawn("talker", talker)

    timing = {"/chatter": Uniform(0.0, 3.0, "s")}
    play(tmp_path, LISTENER, world, monkeypatch, delay_s=timing)
    came = list(sys.modules["played_node"].log)
    assert [text for text, _ in came] == ["0", "1", "2", "3", "4"]
    delays_s = [time_ns / 1e9 - 1.0 - number for number, (_, time_ns) in enumerate(came)]
    assert all(0.0 <= delay_s <= 3.0 for delay_s in delays_s)
    assert max(delays_s) > 0.5
    play(tmp_path, LISTENER, world, monkeypatch, delay_s=timing)
    assert sys.modules["played_node"].log == came
