"""A draft of the nodes that a launch file starts: which, under which names, and as one system."""

from __future__ import annotations

import ast
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.launch_analysis import analyse_launch, read_launch_file
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.ros_model import CodeLine, LaunchedNodes, StartedNode
from tests.extra.draft import ros_robots
from tests.extra.draft.test_ros_draft import INTERFACES

SETUP = """
from setuptools import setup

setup(name="home_robot", entry_points={"console_scripts": [
    "door = home_robot.door:main", "arm = home_robot.arm:main", "asker = home_robot.asker:main",
]})
"""
ASKER = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class Asker(Node):
    def __init__(self):
        super().__init__("asker")
        self.asked = self.create_publisher(Empty, "request", 10)
        self.create_subscription(Bool, "button", self.on_button, 10)

    def on_button(self, message):
        if message.data:
            self.asked.publish(Empty())


def main():
    rclpy.init()
    rclpy.spin(Asker())
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package of nodes in a workspace, beside packages of messages."""
    texts = {
        **INTERFACES,
        "home_robot/package.xml": "<package><name>home_robot</name></package>",
        "home_robot/setup.py": SETUP,
        "home_robot/home_robot/__init__.py": "",
        "home_robot/home_robot/door.py": ros_robots.DOOR,
        "home_robot/home_robot/arm.py": ros_robots.ARM,
        "home_robot/home_robot/asker.py": ASKER,
        "home_robot/launch/home.launch.py": "",
    }
    for name, text in texts.items():
        (tmp_path / "src" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "src" / name).write_text(text, encoding="utf-8")
    return tmp_path / "src" / "home_robot"


def started(package: Path) -> LaunchedNodes:
    """What its launch file starts, as the launch system says it."""
    file = package / "launch" / "home.launch.py"
    location = CodeLine(file.name, 0)
    arm = StartedNode("home_robot", "arm", location, "left_arm", "/left", (("arm/moving", "/moving"),))
    asker = StartedNode("home_robot", "asker", location, namespace="/left")
    return LaunchedNodes(file, {"side": "left"}, (arm, asker, StartedNode("rviz2", "rviz2", location)))


def drafted(package: Path, nodes: LaunchedNodes) -> tuple[Draft, dict[str, str]]:
    root = package.parent.parent
    model, start, _ = analyse_launch(nodes, root)
    draft = Draft(model, "home_tests", "person", root / "draft", ros=start)
    return draft, dict(files(draft))


def test_nodes_of_a_launch_file_are_one_system(package: Path) -> None:
    draft, texts = drafted(package, started(package))
    lines = texts["conftest.py"]
    ast.parse(lines)
    assert {message.topic for message in draft.code.inputs} == {"somebody_near", "left_button"}
    assert '    "/moving": "std_msgs/msg/Bool",' in lines
    assert '    "/left/left_arm/done": "std_msgs/msg/Empty",' in lines
    assert 'HEARD: tuple[str, ...] = ("/somebody_near", "/left/button")' in lines
    assert 'HERE / "../src/home_robot/launch/home.launch.py",' in lines
    assert 'arguments={"side": "left"},' in lines
    assert '"rviz2/rviz2": "ignored",  # TODO' in lines
    assert "rviz2/rviz2 is left out: package 'rviz2' is neither installed nor in" in said(draft)


def said(draft: Draft) -> str:
    return "\n".join(problem.text for problem in draft.code.problems)


def test_a_launch_file_without_a_node_of_python_is_one_sentence(package: Path) -> None:
    nodes = replace(started(package), nodes=started(package).nodes[-1:])
    with pytest.raises(DraftError, match="no node of Python is started by it: rviz2/rviz2 is left out"):
        analyse_launch(nodes, package.parent.parent)


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        ("gone.launch.xml", "there is no file"),
        ("home.launch.py left", "expected \"FILE name:=value ...\", and 'left'"),
    ],
)
def test_a_wrong_option_is_one_sentence(package: Path, asked: str, problem: str) -> None:
    with pytest.raises(DraftError, match=problem):
        read_launch_file(asked, package / "launch")


@pytest.mark.slow
@pytest.mark.skipif(
    any(find_spec(name) is None for name in ("rclpy", "launch", "launch_ros", "launch_xml", "std_msgs")),
    reason="needs rclpy and the launch system of a distribution",
)
def test_a_launch_file_of_python_is_run_and_nothing_of_it_started(package: Path) -> None:
    text = """
from launch import LaunchDescription
from launch.actions import GroupAction, TimerAction
from launch_ros.actions import Node, PushRosNamespace


def generate_launch_description():
    arm = Node(package="home_robot", executable="arm", name="right_arm", remappings=[("arm/moving", "/moving")],
               parameters=[{"period_s": 0.2}])
    asker = TimerAction(period=5.0, actions=[Node(package="home_robot", executable="asker", namespace="right")])
    rviz = Node(package="rviz2", executable="rviz2")
    return LaunchDescription([GroupAction([PushRosNamespace("right"), arm]), asker, rviz])
"""
    file = package / "launch" / "home.launch.py"
    file.write_text(text, encoding="utf-8")
    nodes = read_launch_file(str(file), package.parent.parent)
    assert [(node.key, node.name, node.namespace) for node in nodes.nodes] == [
        ("home_robot/arm", "right_arm", "/right"),
        ("rviz2/rviz2", "", ""),
        ("home_robot/asker", "", "/right"),
    ]
    _, texts = drafted(package, nodes)
    assert 'HERE / "../src/home_robot/launch/home.launch.py",' in texts["conftest.py"]
    assert '"rviz2/rviz2": "ignored",' in texts["conftest.py"]
    assert '    "/moving": "std_msgs/msg/Bool",' in texts["conftest.py"]
