"""A draft of the nodes that a launch file starts: which, under which names, and as one system."""

from __future__ import annotations

import ast
from importlib.util import find_spec
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.found.launched import LaunchedNodes
from pytest_hricdv.extra.draft.launch_analysis import launch_findings, launched
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.draft.ros.executable import workspace
from pytest_hricdv.extra.draft.ros.launch_text import read_launch
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files
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
XML = """<launch>
  <arg name="side" default="left"/>
  <arg name="is_fast" default="false"/>
  <group>
    <push-ros-namespace namespace="$(var side)"/>
    <node pkg="home_robot" exec="arm" name="$(var side)_arm">
      <remap from="arm/moving" to="/moving"/>
      <param name="period_s" value="0.2"/>
      <param name="limits"><param name="most" value="3"/></param>
    </node>
    <node pkg="home_robot" exec="asker"/>
  </group>
  <node pkg="home_robot" exec="door" if="$(var is_fast)"/>
  <node pkg="rviz2" exec="rviz2"/>
</launch>
"""
YAML = """launch:
- arg: {name: side, default: left}
- group:
  - push_ros_namespace: {namespace: $(var side)}
  - node:
      pkg: home_robot
      exec: arm
      name: $(var side)_arm
      remap:
      - {from: arm/moving, to: /moving}
      param:
      - {name: period_s, value: 0.2}
      - name: limits
        param:
        - {name: most, value: 3}
  - node: {pkg: home_robot, exec: asker}
- node: {pkg: rviz2, exec: rviz2}
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
        "home_robot/launch/home.launch.xml": XML,
        "home_robot/launch/home.launch.yaml": YAML,
    }
    for name, text in texts.items():
        (tmp_path / "src" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "src" / name).write_text(text, encoding="utf-8")
    return tmp_path / "src" / "home_robot"


def of(package: Path, text: str, suffix: str = "xml", **arguments: str) -> LaunchedNodes:
    """What a launch file of this text starts."""
    file = package / "launch" / f"some.launch.{suffix}"
    file.write_text(text, encoding="utf-8")
    return read_launch(file, arguments, workspace(package))


def drafted(package: Path, nodes: LaunchedNodes) -> tuple[Draft, dict[str, str]]:
    root = package.parent.parent
    findings, start, _ = launch_findings(nodes, root)
    draft = Draft(findings, "home_tests", "person", root / "draft", ros=start)
    return draft, dict(files(draft))


@pytest.mark.parametrize("suffix", ["xml", "yaml"])
def test_nodes_are_read_with_their_names_remappings_and_parameters(package: Path, suffix: str) -> None:
    nodes = read_launch(package / "launch" / f"home.launch.{suffix}", {}, workspace(package)).nodes
    assert [node.key for node in nodes] == ["home_robot/arm", "home_robot/asker", "rviz2/rviz2"]
    arm = nodes[0]
    assert (arm.name, arm.namespace, arm.remappings) == ("left_arm", "/left", (("arm/moving", "/moving"),))
    assert arm.parameters == ({"period_s": 0.2}, {"limits.most": 3})
    assert str(arm.place) == f"home.launch.{suffix}:{6 if suffix == 'xml' else 5}"


def test_nodes_of_a_launch_file_are_one_system(package: Path) -> None:
    draft, texts = drafted(package, read_launch(package / "launch" / "home.launch.xml", {}, workspace(package)))
    lines = texts["conftest.py"]
    ast.parse(lines)
    assert {message.topic for message in draft.findings.heard} == {"somebody_near", "left_button"}
    assert '    "/moving": "std_msgs/msg/Bool",' in lines
    assert '    "/left/left_arm/done": "std_msgs/msg/Empty",' in lines
    assert 'HEARD: tuple[str, ...] = ("/somebody_near", "/left/button")' in lines
    assert (
        'RosNode(entry="home_robot.arm:main", name="left_arm", namespace="/left", '
        'remappings=[("arm/moving", "/moving")], parameters=[{"period_s": 0.2}, {"limits.most": 3}])'
    ) in lines
    assert "# TODO: rviz2/rviz2 is no Python" in lines
    assert "rviz2/rviz2 is left out: package 'rviz2' is neither installed nor in" in said(draft)


def said(draft: Draft) -> str:
    return "\n".join(problem.text for problem in draft.findings.problems)


@pytest.mark.parametrize(
    ("text", "value"),
    [("2", 2), ("0.5", 0.5), ("true", True), ("left", "left"), ("2024-01-01", "2024-01-01"), ("[1, 2]", [1, 2]),
     ("1e-3", 0.001), ("[", "[")],
)  # fmt: skip
def test_values_of_parameters_are_those_of_ros(package: Path, text: str, value: object) -> None:
    made = of(package, f'<launch><node pkg="a" exec="b"><param name="p" value="{text}"/></node></launch>')
    assert made.nodes[0].parameters == ({"p": value},)


def test_an_argument_of_the_command_line_comes_before_the_default(package: Path) -> None:
    nodes = read_launch(package / "launch" / "home.launch.xml", {"side": "right", "is_fast": "1"}, workspace(package))
    names = [(node.name, node.namespace) for node in nodes.nodes[:3]]
    assert names == [("right_arm", "/right"), ("", "/right"), ("", "")]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ('<node pkg="a" exec="b" namespace="/x"/>', [("a/b", "/x")]),
        ('<group><push_ros_namespace namespace="x"/><node pkg="a" exec="b" namespace="y"/></group>', [("a/b", "/x/y")]),
        ('<group><push_ros_namespace namespace="x"/></group><node pkg="a" exec="b"/>', [("a/b", "")]),
        ('<group scoped="false"><push_ros_namespace namespace="x"/></group><node pkg="a" exec="b"/>', [("a/b", "/x")]),
        ('<let name="n" value="b"/><node pkg="a" exec="$(var n)"/>', [("a/b", "")]),
        ('<node pkg="a" exec="b" unless="true"/><node pkg="a" exec="c" unless="0"/>', [("a/c", "")]),
        ('<timer period="3.0"><node pkg="a" exec="b"/></timer>', [("a/b", "")]),
        ('<executable cmd="gz sim -r world.sdf"/>', [("gz", "")]),
        ('<node pkg="a" exec="$(env HRI_NOT_SET b)"/>', [("a/b", "")]),
        ('<include file="$(find-pkg-share home_robot)/launch/inner.launch.xml"><arg name="n" value="c"/></include>',
         [("a/c", "")]),
        ('<include file="inner.launch.xml"/>', [("a/b", "")]),
        ('<include file="$(dirname)/inner.launch.yaml"/>', [("a/d", "")]),
    ],
)  # fmt: skip
def test_elements_that_need_no_launch_system(package: Path, body: str, expected: list[tuple[str, str]]) -> None:
    (package / "launch" / "inner.launch.xml").write_text(
        '<launch><arg name="n" default="b"/><node pkg="a" exec="$(var n)"/></launch>'
    )
    (package / "launch" / "inner.launch.yaml").write_text("launch:\n- node: {pkg: a, exec: d}\n")
    made = of(package, f"<launch>{body}</launch>")
    assert [(node.key, node.namespace) for node in made.nodes] == expected
    assert made.problems == ()


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ('<node pkg="a" exec="$(eval 1+1)"/>', "<node> is left out: $(eval ...): the launch system reads it"),
        ('<node pkg="a" exec="$(var n)"/>', "<node> is left out: $(var n) has no value here: give it as n:=VALUE"),
        ('<node pkg="a" exec="b" if="maybe"/>', "<node> is left out: if='maybe': expected true or false"),
        ('<include file="robot.launch.py"/>', "<include> is left out: robot.launch.py is a launch file of Python"),
        ('<include file="gone.launch.xml"/>', "<include> is left out: there is no file"),
        ('<include file="$(find-pkg-share gone)/x.xml"/>', "<include> is left out: package 'gone' is not in the work"),
        ('<node pkg="a" type="b.py" name="c"/>', "<node> is left out: it has no exec: is it a launch file of ROS 1?"),
        ('<node exec="b"/>', "<node> is left out: it has no pkg"),
        ('<node_container pkg="rclcpp_components" exec="component_container"/>', "<node_container> is left out"),
    ],
)
def test_what_needs_the_launch_system_is_said_and_the_rest_is_read(package: Path, body: str, problem: str) -> None:
    made = of(package, f'<launch>\n{body}\n<node pkg="a" exec="last"/></launch>')
    (told,) = made.problems
    assert str(told[0]) == "some.launch.xml:2"
    assert problem in told[1]
    assert [node.key for node in made.nodes] == ["a/last"]


@pytest.mark.parametrize(
    ("suffix", "text", "problem"),
    [
        ("xml", "<launch>", "some.launch.xml:1: no XML: no element found"),
        ("xml", "", "some.launch.xml:1: no XML: no element found"),
        ("yaml", "launch: &a [group: *a]", "some.launch.yaml: its elements are nested too deep"),
        ("yaml", "launch: [", "some.launch.yaml:1: no YAML:"),
        ("py", "", "some.launch.py: is a launch file of Python: the launch system reads it: source a distribution"),
        ("xml", '<launch>\n<arg name="side"/></launch>', "some.launch.xml:2: argument 'side' has no default: expected"),
        ("xml", '<launch><include file="some.launch.xml"/></launch>', "include each other more than 16 deep"),
    ],
)
def test_a_launch_file_that_cannot_be_read_is_one_sentence(package: Path, suffix: str, text: str, problem: str) -> None:
    with pytest.raises(DraftError) as raised:
        of(package, text, suffix)
    assert problem in str(raised.value)


def test_a_launch_file_without_a_node_of_python_is_one_sentence(package: Path) -> None:
    nodes = of(package, '<launch><node pkg="rviz2" exec="rviz2"/></launch>')
    with pytest.raises(DraftError, match="no node of Python is started by it: rviz2/rviz2 is left out"):
        launch_findings(nodes, package.parent.parent)


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        ("gone.launch.xml", "there is no file"),
        ("home.launch.xml left", "expected \"FILE name:=value ...\", and 'left'"),
    ],
)
def test_a_wrong_option_is_one_sentence(package: Path, asked: str, problem: str) -> None:
    with pytest.raises(DraftError, match=problem):
        launched(asked, package / "launch")


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
    nodes = launched(str(file), package.parent.parent)
    assert [(node.key, node.name, node.namespace) for node in nodes.nodes] == [
        ("home_robot/arm", "right_arm", "/right"),
        ("rviz2/rviz2", "", ""),
        ("home_robot/asker", "", "/right"),
    ]
    _, texts = drafted(package, nodes)
    assert 'HERE / "../src/home_robot/launch/home.launch.py",' in texts["conftest.py"]
    assert '"rviz2/rviz2": "ignored",' in texts["conftest.py"]
    assert '    "/moving": "std_msgs/msg/Bool",' in texts["conftest.py"]
