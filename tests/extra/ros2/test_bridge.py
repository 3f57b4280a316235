"""What goes over topics, services and actions is in the record, and requirements can name it."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.extra.ros2.bridge import Bridge, vocabulary
from pytest_hricdv.extra.ros2.graph import carry_with
from pytest_hricdv.extra.ros2.messages import fields_of
from pytest_hricdv.extra.ros2.world import WorldNode
from pytest_hricdv.monitor import Vocabulary
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from pytest_hricdv.runtime.bus import MessageFault
from pytest_hricdv.runtime.node_error import NodeError

pytestmark = pytest.mark.usefixtures("cell_msgs")

CELL = Ros2(
    topics={"/cell/scan": "cell_msgs/msg/Scan"},
    services={"/grasp": "cell_msgs/srv/Grasp"},
    actions={"/fetch": "cell_msgs/action/Fetch"},
)


def scan(**fields: Any) -> Any:
    from cell_msgs.msg import Scan  # type: ignore[import-not-found, unused-ignore]

    return Scan(**fields)


class Cell:
    """A run with the graph of a cell."""

    def __init__(self, declared: Ros2 = CELL, kinds: tuple[type[Any], ...] = ()) -> None:
        self.kernel, self.recorder = Kernel(), Recorder()
        self.bus = Bus(self.kernel, kinds, self.recorder)
        carry_with(self.kernel, Bridge(self.bus, declared))

    def node(self, name: str) -> WorldNode:
        return WorldNode(self.kernel, name)

    def run(self, body: Callable[[], None], limit_s: float = 100.0) -> list[str]:
        self.kernel.spawn("test", body)
        try:
            self.kernel.run(limit_s)
        finally:
            self.kernel.close()
        return [" ".join(str(message).split()) for message in self.recorder.messages]


def test_a_message_is_recorded_with_its_sender_and_its_nested_fields() -> None:
    cell = Cell()
    publisher = cell.node("lidar").publisher("/cell/scan", "cell_msgs/msg/Scan")
    heard: list[Any] = []
    hearing = cell.node("robot").subscribe("/cell/scan", "cell_msgs/msg/Scan")

    def body() -> None:
        message = scan(frame="map", near=True, count=3, ranges=array("d", [1.0, 2.0]))
        message.origin.x = 4.0
        publisher.publish(message)
        message.frame = "changed after it was sent"
        heard.append(hearing.wait(1.0))

    crc = fields_of(scan(ranges=array("d", [1.0, 2.0])))["ranges.crc"]
    assert cell.run(body) == [
        "0.000 lidar cell_scan frame=map near=True count=3 origin.x=4.0 origin.y=0.0 ranges.length=2 "
        f"ranges.crc={crc} labels.length=0 labels.crc={fields_of(scan())['labels.crc']}"
    ]
    assert (heard[0].frame, heard[0].origin.x, list(heard[0].ranges)) == ("map", 4.0, [1.0, 2.0])


def test_requirements_name_nested_fields_lengths_services_and_actions() -> None:
    names = Vocabulary(messages=vocabulary(CELL))
    assert names.kind("cell_scan.origin.x") is float
    assert names.kind("cell_scan.ranges.length") is float
    assert names.kind("cell_scan.near") is bool
    assert names.kind("grasp_request.force") is float
    assert names.kind("grasp_response.held") is bool
    assert names.kind("fetch_goal.part") is str
    assert names.kind("fetch_answer.accepted") is bool
    assert names.kind("fetch_result.status") is float
    assert names.kind("rosout.msg") is str
    assert names.kind("terminal_input.text") is str
    assert "fetch_cancel" in names.messages


def test_the_world_serves_asks_and_is_answered() -> None:
    cell = Cell()
    gripper, person = cell.node("gripper"), cell.node("person")
    answers: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        cell.kernel.sleep(2.0)
        response.held = request.force > 1.0
        return response

    gripper.serve("/grasp", "cell_msgs/srv/Grasp", answer)
    client = person.client("/grasp", "cell_msgs/srv/Grasp")

    def body() -> None:
        late = client.call(1.0, force=5.0)
        answers.extend([late, *(getattr(client.call(10.0, force=force), "held", None) for force in (0.5, 5.0))])

    assert cell.run(body) == [
        "0.000 person grasp_request force=5.0",
        "1.000 person grasp_request force=0.5",
        "2.000 gripper grasp_response held=True",
        "4.000 gripper grasp_response held=False",
        "4.000 person grasp_request force=5.0",
        "6.000 gripper grasp_response held=True",
    ]
    assert answers == [None, False, True]


def test_a_person_calls_an_action() -> None:
    cell = Cell()
    robot, person = cell.node("robot"), cell.node("person")
    given: list[Any] = []

    def send_goal(request: Any, response: Any) -> Any:
        given.append(bytes(request.goal_id.uuid))
        response.accepted = request.goal.part == "leg"
        return response

    def get_result(request: Any, response: Any) -> Any:
        assert bytes(request.goal_id.uuid) == given[-1]
        cell.kernel.sleep(3.0)
        response.status, response.result.found = 4, True
        return response

    def body() -> None:
        from cell_msgs.action import Fetch  # type: ignore[import-not-found, unused-ignore]

        robot.serve("/fetch/_action/send_goal", Fetch.Impl.SendGoalService, send_goal)
        robot.serve("/fetch/_action/get_result", Fetch.Impl.GetResultService, get_result)
        action = person.action("/fetch", "cell_msgs/action/Fetch")
        assert action.call(10.0, part="door") is None
        over = action.call(10.0, part="leg")
        assert over is not None
        assert (over.status, over.result.found) == (4, True)

    assert cell.run(body) == [
        "0.000 person fetch_goal part=door",
        "0.000 robot fetch_answer accepted=False",
        "0.000 person fetch_goal part=leg",
        "0.000 robot fetch_answer accepted=True",
        "3.000 robot fetch_result status=4 found=True",
    ]
    assert given[0] != given[1]


def test_a_latched_message_reaches_who_comes_later() -> None:
    cell = Cell()

    def body() -> None:
        lidar, robot = cell.node("lidar"), cell.node("robot")
        lidar.publisher("/cell/scan", "cell_msgs/msg/Scan", latched=True).publish(scan(count=7))
        assert robot.subscribe("/cell/scan", "cell_msgs/msg/Scan").poll() is None  # it does not ask for it

    assert len(cell.run(body)) == 1


@pytest.mark.parametrize(
    ("fault", "heard_s"),
    [
        (MessageFault("lost"), []),
        (MessageFault("late", (2.0,)), [2.0]),
        (MessageFault("doubled", (0.0, 1.0)), [0.0, 1.0]),
    ],
)
def test_messages_are_lost_late_and_doubled(fault: MessageFault, heard_s: list[float]) -> None:
    cell = Cell()
    publisher = cell.node("lidar").publisher("/cell/scan", "cell_msgs/msg/Scan")
    hearing = cell.node("robot").subscribe("/cell/scan", "cell_msgs/msg/Scan")
    cell.bus.disturb("cell_scan", fault)
    found: list[float] = []

    def body() -> None:
        publisher.publish(scan())
        while hearing.wait(5.0) is not None:
            found.append(cell.kernel.now_s)

    assert cell.run(body)[0].startswith(f"0.000 lidar {fault.name} cell_scan")
    assert found == heard_s


def test_another_type_than_declared_is_an_error_that_names_both() -> None:
    cell = Cell()

    def body() -> None:
        cell.node("lidar").publisher("/cell/scan", "cell_msgs/msg/Other")

    with pytest.raises(NodeError) as caught:
        cell.run(body)
    assert str(caught.value.__cause__) == (
        "/cell/scan: /lidar uses it with the type cell_msgs/msg/Other, but the testbench declares cell_msgs/msg/Scan"
    )


def _other() -> Any:
    from cell_msgs.msg import Other

    return Other()


def test_two_names_that_are_one_in_the_record_are_an_error() -> None:
    cell = Cell(Ros2())

    def body() -> None:
        for topic in ("/a/b", "/a_b"):
            cell.node("lidar").publisher(topic, "cell_msgs/msg/Other").publish(_other())

    with pytest.raises(NodeError, match="/a_b and /a/b are both called 'a_b' in the record"):
        cell.run(body)


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (Ros2(topics={"scan": "cell_msgs/msg/Scan"}), "'scan' is not a full name"),
        (Ros2(topics={"/scan": "cell_msgs/Scan"}), "topics has the type 'cell_msgs/Scan'; expected one such as"),
        (Ros2(topics={"/scan": "cell_msgs/srv/Grasp"}), "topics has the type 'cell_msgs/srv/Grasp'"),
        (Ros2(topics={"/scan": "cell_msgs/msg/Scn"}), "cell_msgs has no msg 'Scn'; nearest: Scan"),
        (
            Ros2(topics={"/scan": "no_msgs/msg/Scan"}),
            "no Python package 'no_msgs'; is the workspace's setup file sourced",
        ),
        (Ros2(topics={"/a/b": "cell_msgs/msg/Scan", "/a_b": "cell_msgs/msg/Scan"}), "are called 'a_b' in requirements"),
        (Ros2(topics={"/rosout": "cell_msgs/msg/Scan"}), "without its being declared"),
    ],
)
def test_a_wrong_declaration_is_a_located_error(declared: Ros2, message: str) -> None:
    with pytest.raises(Ros2Error, match=message):
        vocabulary(declared)


@dataclass(frozen=True)
class Ab:
    """A message of the bus."""


def test_a_topic_that_is_called_as_a_message_of_the_bus_is_an_error() -> None:
    cell = Cell(Ros2(), (Ab,))

    def body() -> None:
        cell.node("lidar").publisher("/ab", "cell_msgs/msg/Other").publish(_other())

    with pytest.raises(NodeError, match="/ab is called 'ab' in the record, as a message of the bus is"):
        cell.run(body)
