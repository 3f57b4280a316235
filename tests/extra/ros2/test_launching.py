"""Launch files as they are: what they start, when, with what; and what is said of those that cannot be run."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import IGNORED, Launch
from pytest_hricdv.extra.ros2.launch_processes import LaunchedProcess
from tests.extra.ros2.launch_workspace import ran, write_package

_NEEDED = ("rclpy", "launch", "launch_ros", "launch_xml", "launch_yaml", "std_msgs")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        any(find_spec(name) is None for name in _NEEDED), reason=f"needs {', '.join(_NEEDED)} of a distribution"
    ),
]


@pytest.fixture(autouse=True)
def _as_it_was(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The path and the modules of this process are left as they were."""
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield
    assert not {"WHO", "AMENT_PREFIX_PATH"} & os.environ.keys(), (
        "what a launch file sets is seen only by what it starts"
    )
    for name in [module for module in sys.modules if module.partition(".")[0] == "cell"]:
        del sys.modules[name]


_IMPORTS = """
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import *
from launch.events import Shutdown as ShutdownEvent, matches_action
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.descriptions import ComposableNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
"""

_ALL_KINDS = (
    _IMPORTS
    + """
    share = get_package_share_directory("cell")
    once = Node(package="cell", executable="once", arguments=["--fast", LaunchConfiguration("speed")])
    return LaunchDescription([
        DeclareLaunchArgument("speed", default_value="3"),
        DeclareLaunchArgument("extra", default_value="false"),
        DeclareLaunchArgument("robot"),
        SetEnvironmentVariable("WHO", "me"),
        Node(package="cell", executable="talker", name="first", namespace=LaunchConfiguration("robot"),
             parameters=[{"period": 4.0, "text": "hi"}], remappings=[("chatter", "/all")]),
        GroupAction([
            PushRosNamespace("g"),
            SetParameter("period", 4.0),
            Node(package="cell", executable="talker", parameters=[os.path.join(share, "config", "cell.yaml")]),
        ]),
        Node(package="cell", executable="talker", name="extra", condition=IfCondition(LaunchConfiguration("extra"))),
        once,
        RegisterEventHandler(OnProcessExit(target_action=once, on_exit=[
            Node(package="cell", executable="talker", name="after"),
        ])),
        TimerAction(period=3.5, actions=[Node(package="cell", executable="talker", name="late")]),
        TimerAction(period=5.2, actions=[EmitEvent(event=ShutdownEvent(reason="done"))]),
    ])
"""
)


def _said(messages: list[tuple[float, str, Any]], *topics: str) -> list[tuple[float, Any]]:
    return [(time_s, text) for time_s, topic, text in messages if topic in topics]


def test_a_launch_file_in_python_runs_in_simulated_time(tmp_path: Path) -> None:
    package = write_package(tmp_path, all__launch__py=_ALL_KINDS)
    messages, run = ran(Launch(package / "launch" / "all.launch.py", arguments={"robot": "r2"}))
    assert [entry for entry in messages if entry[1] != "rosout"] == [
        (3.0, "chatter", "/after hello me"),
        (4.0, "all", "/r2/first hi me"),
        (4.0, "g_chatter", "/g/talker from a file me"),
        (4.0, "chatter", "/after hello me"),
        (4.5, "chatter", "/late hello me"),
        (5.0, "chatter", "/after hello me"),
    ]
    assert _said(messages, "rosout") == [(0.0, "once --fast 3"), *[(5.2, "ended by KeyboardInterrupt")] * 4]
    assert run.ending is not None
    assert (run.ending.how, run.ending.time_s) == ("idle", 5.2)


_XML = """<launch>
  <arg name="n" default="1"/>
  <arg name="who"/>
  <group if="$(eval '$(var n) == 1')">
    <push-ros-namespace namespace="x"/>
    <node pkg="cell" exec="talker" name="t">
      <param name="text" value="$(var who)"/>
      <remap from="chatter" to="heard"/>
      <env name="WHO" value="xml"/>
    </node>
  </group>
  <node pkg="cell" exec="talker" name="u" unless="$(eval '$(var n) == 1')"/>
  <include file="$(find-pkg-share cell)/launch/y.launch.yaml"><arg name="period" value="0.5"/></include>
</launch>
"""
_YAML = """
launch:
- arg: {name: period, default: "1.0"}
- node:
    pkg: cell
    exec: talker
    name: yam
    namespace: y
    param:
    - {name: period, value: $(var period)}
"""


@pytest.mark.parametrize(("n", "expected"), [(1, (1.0, "x_heard", "/x/t w xml")), (2, (1.0, "chatter", "/u hello -"))])
def test_launch_files_in_xml_and_yaml_run(n: int, expected: tuple[float, str, str], tmp_path: Path) -> None:
    package = write_package(tmp_path, x__launch__xml=_XML, y__launch__yaml=_YAML)
    messages, _ = ran(Launch(package / "launch" / "x.launch.xml", arguments={"who": "w", "n": n}), limit_s=1.2)
    assert messages == [(0.5, "y_chatter", "/y/yam hello -"), expected, (1.0, "y_chatter", "/y/yam hello -")]


_MANAGED = (
    _IMPORTS
    + """
    from lifecycle_msgs.msg import Transition

    node = LifecycleNode(package="cell", executable="managed", name="managed", namespace="")

    def change(transition):
        return EmitEvent(event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition))

    return LaunchDescription([
        node,
        RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=node, start_state="configuring", goal_state="inactive",
            entities=[change(Transition.TRANSITION_ACTIVATE)],
        )),
        change(Transition.TRANSITION_CONFIGURE),
    ])
"""
)


def test_managed_nodes_change_their_states_by_events(tmp_path: Path) -> None:
    package = write_package(tmp_path, managed__launch__py=_MANAGED)
    messages, _ = ran(Launch(package / "launch" / "managed.launch.py"), limit_s=3.0)
    assert [text for _, text in _said(messages, "rosout")] == ["configured", "active"]


_RESPAWN = (
    _IMPORTS
    + """
    return LaunchDescription([
        Node(package="cell", executable="fails", respawn=True, respawn_delay=1.5, respawn_max_retries=2),
    ])
"""
)


def test_what_fails_is_started_again_if_the_launch_file_says_so(tmp_path: Path) -> None:
    package = write_package(tmp_path, again__launch__py=_RESPAWN)
    assert _said(ran(Launch(package / "launch" / "again.launch.py"))[0], "rosout") == [
        (0.0, "up"),
        (2.0, "up"),
        (4.0, "up"),
    ]


def test_an_exit_code_that_no_launch_file_expects_fails_the_run(tmp_path: Path) -> None:
    package = write_package(tmp_path, once__launch__py=_RESPAWN.replace("respawn=True", "respawn=False"))
    _, run = ran(Launch(package / "launch" / "once.launch.py"))
    assert run.ending is not None
    assert "SystemExit: 3" in str(run.ending.error)


_OTHERS = (
    _IMPORTS
    + """
    return LaunchDescription([
        Node(package="rviz2", executable="rviz2"),
        ExecuteProcess(cmd=["gz", "sim", "-r"]),
        ComposableNodeContainer(
            name="box", namespace="", package="rclcpp_components", executable="component_container",
            composable_node_descriptions=[ComposableNode(
                package="image_proc", plugin="image_proc::Rectify", name="rectify", namespace="camera",
                remappings=[("image", "/raw")], parameters=[{"quality": 3}],
            )],
        ),
        Node(package="driver", executable="lidar", name="lidar", parameters=[{"rate": 5.0}], arguments=["--quiet"]),
    ])
"""
)


def test_what_is_no_python_is_named_all_at_once(tmp_path: Path) -> None:
    package = write_package(tmp_path, others__launch__py=_OTHERS)
    with pytest.raises(Exception, match="rviz2/rviz2 is of package 'rviz2', which is neither installed nor") as raised:
        ran(Launch(package / "launch" / "others.launch.py"))
    assert "; the same of gz, driver/lidar" in str(raised.value)


def test_functions_of_the_testbench_stand_for_executables(tmp_path: Path) -> None:
    package = write_package(tmp_path, others__launch__py=_OTHERS)
    started: list[object] = []

    def rectify(process: LaunchedProcess) -> None:
        from std_msgs.msg import String

        started.append((process.name, process.namespace, dict(process.parameters)))
        process.sleep(1.0)
        process.node.publisher("image", String).publish(String(data="raw"))

    def lidar(process: LaunchedProcess) -> None:
        started.append((process.name, process.arguments, dict(process.parameters)))

    executables: dict[str, Any] = {
        "rviz2/*": IGNORED,
        "gz": IGNORED,
        "image_proc/image_proc::Rectify": rectify,
        "driver/lidar": lidar,
    }
    messages, _ = ran(Launch(package / "launch" / "others.launch.py", executables=executables), limit_s=3.0)
    assert _said(messages, "raw") == [(1.0, "raw")]
    assert started == [
        ("lidar", ("--quiet",), {"rate": 5.0}),
        ("rectify", "/camera", {"quality": 3}),
    ]


@pytest.mark.parametrize(
    ("launch", "message"),
    [
        ({"arguments": {}}, r"argument 'who' has no default, and no value.*it declares n, who"),
        ({"arguments": {"hwo": 1}}, r"no argument 'hwo'; nearest: who; it declares n, who"),
        ({"file": "y.launch.xml"}, r"there is no file .*y\.launch\.xml; paths begin where pytest was started"),
        ({"file": "x.launch.xml", "package": "sell"}, r"there is no package 'sell'.*; nearest: cell"),
        (
            {"file": "y.launch.xml", "package": "cell"},
            r"package 'cell', in .*, has none; there are bad\.launch",
        ),
        ({"workspace": ["nowhere"]}, r"workspace: .*nowhere is not a folder"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(launch: dict[str, Any], message: str, tmp_path: Path) -> None:
    package = write_package(tmp_path, x__launch__xml=_XML.split("<include")[0] + "</launch>", bad__launch__py="1 +")
    options = {"file": str(package / "launch" / "x.launch.xml"), "workspace": [str(package)], **launch}
    with pytest.raises(Exception, match=message) as raised:
        ran(Launch(**options))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 +", "SyntaxError"),
        ("x = 1", "generate_launch_description"),
        (_IMPORTS + "    get_package_share_directory('nav2_bringup')", "there is no package 'nav2_bringup', neither"),
        (_IMPORTS + "    return LaunchDescription([Node(package='cell', executable='tallker')])", "nearest: talker"),
    ],
)
def test_what_is_wrong_in_a_launch_file_is_said(text: str, message: str, tmp_path: Path) -> None:
    package = write_package(tmp_path, bad__launch__py=text)
    with pytest.raises(Exception, match=message) as raised:
        ran(Launch(package / "launch" / "bad.launch.py"))
    assert str(raised.value).count("\n") == 0
