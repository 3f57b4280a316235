"""Topics and services: what arrives, where, and in which order."""

from __future__ import annotations

from typing import Any

from pytest_hricdv.extra.ros2.qos import (
    Profile,
)
from pytest_hricdv.extra.ros2.services import Client, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Grasp, Reading, node, reading, run, wait


def _values(subscription: TopicSubscription) -> list[float]:
    found = []
    while (taken := subscription.take_message(Reading, False)) is not None:
        found.append(taken[0]._range)
    return found


def test_a_message_arrives_at_its_instant_as_a_copy() -> None:
    seen: list[Any] = []

    def camera(kernel: Kernel) -> None:
        publisher = Publisher(node("camera"), Reading, "scan", Profile())
        kernel.sleep(1.0)
        message: Any = reading(1.0)
        publisher.publish(message)
        message._range, message._points[0]._x, message._ranges[0], message._seen._x = 2.0, 2.0, 2.0, 2.0

    def robot(kernel: Kernel) -> None:
        subscription = TopicSubscription(node("robot"), Reading, "/scan", Profile())
        assert wait("subscription", [subscription]) == [0]
        taken = subscription.take_message(Reading, False)
        assert taken is not None
        message, info = taken
        seen.extend([kernel.now_s, message._range, message._points[0]._x, message._ranges[0], message._seen._x])
        assert info["source_timestamp"] == info["received_timestamp"]
        assert (info["publication_sequence_number"], info["reception_sequence_number"]) == (1, 1)

    run(camera, robot)
    assert seen == [1.0, 1.0, 1.0, 1.0, 0]


def test_without_a_server_a_request_is_lost_and_who_waits_for_it_waits() -> None:
    def robot(kernel: Kernel) -> None:
        client = Client(node("robot"), Grasp, "grasp", Profile())
        assert not client.service_server_is_available()
        client.send_request(Grasp.Request(force=1.0))
        ServiceServer(node("late"), Grasp, "grasp", Profile())
        assert client.service_server_is_available()
        assert wait("client", [client], timeout_s=5.0) == []
        assert client.take_response(Grasp.Response) == (None, None)

    run(robot)
