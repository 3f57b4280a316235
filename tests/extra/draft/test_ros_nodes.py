from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.code_model import CodeModel
from tests.extra.draft import robots, ros_robots


def read(tmp_path: Path, source: str) -> CodeModel:
    (tmp_path / "node_code.py").write_text(source, encoding="utf-8")
    return analyse("node_code", tmp_path)


ENDPOINTS = {
    "ARM": {
        "publisher /arm/moving std_msgs/msg/Bool of arm, called: ",
        "publisher /arm/done std_msgs/msg/Empty of arm, called: ",
        "subscription /request std_msgs/msg/Empty of arm, called: on_request",
        "subscription /somebody_near std_msgs/msg/Bool of arm, called: on_person",
    },
    "DOOR": {
        "publisher /home/door/state std_msgs/msg/String of door, called: ",
        "subscription /home/commands std_msgs/msg/String of door, called: on_command",
        "service /home/lock std_srvs/srv/SetBool of door, called: on_lock",
    },
    "TRANSPORT": {
        "client /grip std_srvs/srv/Trigger of transport, called: ",
        "action server /fetch transport_msgs/action/Fetch of transport, called: fetch",
        "action client /navigate_to_pose nav2_msgs/action/NavigateToPose of transport, called: ",
        "publisher   of transport, called: ",
    },
}


@pytest.mark.parametrize("name", ENDPOINTS)
def test_topics_services_and_actions_are_those_of_the_source(name: str, tmp_path: Path) -> None:
    endpoints = read(tmp_path, getattr(ros_robots, name)).ros.endpoints
    assert {
        f"{e.kind} {e.name} {e.type} of {e.node}, called: {', '.join(e.callbacks)}" for e in endpoints
    } == ENDPOINTS[name]


def test_parameters_have_their_defaults_and_locations(tmp_path: Path) -> None:
    arm = read(tmp_path, ros_robots.ARM).ros
    assert [(p.name, p.default, str(p.location)) for p in arm.parameters] == [("period_s", "0.1", "node_code.py:11")]
    door = read(tmp_path, ros_robots.DOOR).ros
    assert {(p.name, p.default) for p in door.parameters} == {
        ("limits.open_s", "5.0"),
        ("limits.name", "'front'"),
        ("command_topic", "'commands'"),
    }


def test_what_the_source_does_not_name_is_a_question_with_its_place(tmp_path: Path) -> None:
    questions = read(tmp_path, ros_robots.TRANSPORT).questions
    asked = [(str(q.location), q.text) for q in questions if q.about == "publisher"]
    assert asked == [("node_code.py:21", "Which name and which type has this publisher?")]


def test_callbacks_are_all_functions_that_an_endpoint_is_given_and_names_may_be_f_strings(tmp_path: Path) -> None:
    source = """
from functools import partial
from rclpy.action import ActionServer
from rclpy.node import Node
from std_msgs.msg import String
from control_msgs.action import GripperCommand

SPACE = "/hall"
TOPIC = f"{SPACE}/speed"

class Gripper(Node):
    def __init__(self):
        super().__init__("gripper")
        self.create_subscription(String, TOPIC, partial(self.on_speed, fast=True), 10)
        ActionServer(self, GripperCommand, "grip", execute_callback=self.grip, goal_callback=self.accept)
    def on_speed(self, message, fast): ...
    def grip(self, goal): ...
    def accept(self, goal): ...
"""
    endpoints = read(tmp_path, source).ros.endpoints
    assert [(e.name, e.callbacks) for e in endpoints] == [("/hall/speed", ("on_speed",)), ("/grip", ("grip", "accept"))]


def test_code_without_rclpy_has_no_nodes(tmp_path: Path) -> None:
    source = "class Bus:\n    def create_publisher(self, kind, topic): ...\n\nBus().create_publisher(int, 'x')\n"
    assert read(tmp_path, source).ros.endpoints == ()


def test_the_terminal_says_what_nodes_say_and_hear(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "node_code.py").write_text(ros_robots.ARM, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "draft", "--from", "node_code", "--no-run"]) == 0
    said = capsys.readouterr().out
    assert "nodes of ROS 2: arm; 4 topics, services and actions" in said
    assert "node_code.py is a node of ROS 2: drafted as with --ros2 node_code.py" in said


def test_without_the_feature_ros2_plain_code_is_drafted_and_nodes_say_what_they_need(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.draft.ros.executable.offers", lambda role, name: ())
    (tmp_path / "node_code.py").write_text(ros_robots.ARM, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for way in ("--from=node_code", "--ros2=node_code.py"):
        assert main(["init", "draft", way, "--no-run"]) == 2
        assert "ROS 2 nodes need the feature `ros2`" in capsys.readouterr().err
    (tmp_path / "plain_code.py").write_text(robots.MATCH, encoding="utf-8")
    assert main(["init", "draft", "--from", "plain_code", "--no-run"]) == 0


def test_without_the_feature_draft_code_is_not_drafted(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.skeleton.skeleton.offers", lambda role, name: ())
    assert main(["init", "--from", "json"]) == 2
    assert "need the feature `draft`, which is not installed" in capsys.readouterr().err
