"""Topics and services: what arrives, where, and in which order."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.ros2 import graph_queries
from pytest_hricdv.extra.ros2.clocks import Clock, ClockType
from pytest_hricdv.extra.ros2.messages import copy_message
from pytest_hricdv.extra.ros2.qos import (
    AUTOMATIC,
    BEST_EFFORT,
    KEEP_ALL,
    RELIABLE,
    TRANSIENT_LOCAL,
    VOLATILE,
    Profile,
    QoSCompatibility,
    check_compatible,
)
from pytest_hricdv.extra.ros2.services import Client, IntrospectionState, Service
from pytest_hricdv.extra.ros2.topics import Publisher, Subscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Grasp, Point, Reading, node, reading, run, wait


def _values(subscription: Subscription) -> list[float]:
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
        subscription = Subscription(node("robot"), Reading, "/scan", Profile())
        assert wait("subscription", [subscription]) == [0]
        taken = subscription.take_message(Reading, False)
        assert taken is not None
        message, info = taken
        seen.extend([kernel.now_s, message._range, message._points[0]._x, message._ranges[0], message._seen._x])
        assert info["source_timestamp"] == info["received_timestamp"]
        assert (info["publication_sequence_number"], info["reception_sequence_number"]) == (1, 1)

    run(camera, robot)
    assert seen == [1.0, 1.0, 1.0, 1.0, 0]


@given(depth=st.integers(1, 6), count=st.integers(0, 12), late=st.booleans(), keep_all=st.booleans())
def test_a_queue_keeps_the_last_ones(depth: int, count: int, late: bool, keep_all: bool) -> None:
    """Also for a subscription that comes late, where both sides keep messages for such."""
    profile = Profile(depth=depth, durability=TRANSIENT_LOCAL if late else VOLATILE)
    profile = replace(profile, history=KEEP_ALL) if keep_all else profile
    got: list[float] = []

    def robot(kernel: Kernel) -> None:
        made = node("robot")
        publisher = Publisher(made, Reading, "scan", profile)
        subscription = None if late else Subscription(made, Reading, "scan", profile)
        for number in range(count):
            publisher.publish(reading(float(number)))
        got.extend(_values(subscription or Subscription(made, Reading, "scan", profile)))

    run(robot)
    every = [float(number) for number in range(count)]
    assert got == (every if keep_all else every[-depth:])


@pytest.mark.parametrize(
    ("offered", "requested", "reason"),
    [
        (Profile(reliability=BEST_EFFORT), Profile(reliability=RELIABLE), "Best effort publisher"),
        (Profile(), Profile(durability=TRANSIENT_LOCAL), "Volatile publisher"),
        (Profile(deadline_ns=20), Profile(deadline_ns=10), "deadline is less"),
        (Profile(), Profile(lease_ns=10), "lease duration is less"),
    ],
)
def test_profiles_that_do_not_match_mean_silence(offered: Profile, requested: Profile, reason: str) -> None:
    def robot(kernel: Kernel) -> None:
        made = node("robot")
        publisher = Publisher(made, Reading, "scan", offered)
        subscription = Subscription(made, Reading, "scan", requested)
        publisher.publish(reading(1.0))
        assert publisher.get_subscription_count() == subscription.get_publisher_count() == 0
        assert _values(subscription) == []
        assert made.get_count_publishers("/scan") == made.get_count_subscribers("/scan") == 1

    run(robot)
    result = check_compatible(offered, requested)
    assert result.compatibility is QoSCompatibility.ERROR
    assert reason in result.reason
    decided = replace(requested, liveliness=AUTOMATIC)
    assert check_compatible(decided, decided).compatibility is QoSCompatibility.OK


def test_another_type_or_domain_is_another_topic() -> None:
    def robot(kernel: Kernel) -> None:
        subscription = Subscription(node("robot"), Reading, "scan", Profile())
        Publisher(node("other_type"), Point, "scan", Profile()).publish(Point(x=1, y=1))
        Publisher(node("other_domain", domain=7), Reading, "scan", Profile()).publish(reading(1.0))
        Publisher(node("same"), Reading, "scan", Profile()).publish(reading(2.0))
        assert _values(subscription) == [2.0]

    run(robot)


def test_each_client_gets_its_own_responses() -> None:
    held: dict[str, list[tuple[int, bool]]] = {"left": [], "right": []}

    def gripper(kernel: Kernel) -> None:
        service = Service(node("gripper"), Grasp, "grasp", Profile())
        for _ in range(4):
            wait("service", [service])
            kernel.sleep(0.5)
            request, info = service.service_take_request(Grasp.Request)
            assert info is not None
            assert request is not None
            service.service_send_response(Grasp.Response(held=request._force > 1), info.request_id)

    def ask(kernel: Kernel, name: str, forces: tuple[float, float]) -> None:
        client = Client(node(name), Grasp, "grasp", Profile())
        for force in forces:
            number = client.send_request(Grasp.Request(force=force))
            wait("client", [client])
            info, response = client.take_response(Grasp.Response)
            assert info is not None
            assert info.request_id.sequence_number == number
            assert response is not None
            held[name].append((number, response._held))

    def left(kernel: Kernel) -> None:
        ask(kernel, "left", (0.0, 2.0))

    def right(kernel: Kernel) -> None:
        ask(kernel, "right", (3.0, 0.0))

    assert run(gripper, left, right)[1] == "idle"
    assert held == {"left": [(1, False), (2, True)], "right": [(1, True), (2, False)]}


def test_without_a_server_a_request_is_lost_and_who_waits_for_it_waits() -> None:
    def robot(kernel: Kernel) -> None:
        client = Client(node("robot"), Grasp, "grasp", Profile())
        assert not client.service_server_is_available()
        client.send_request(Grasp.Request(force=1.0))
        Service(node("late"), Grasp, "grasp", Profile())
        assert client.service_server_is_available()
        assert wait("client", [client], timeout_s=5.0) == []
        assert client.take_response(Grasp.Response) == (None, None)

    run(robot)


def test_the_graph_tells_who_does_what() -> None:
    def robot(kernel: Kernel) -> None:
        made = node("robot", namespace="/cell")
        publisher = Publisher(made, Reading, "scan", Profile())
        Subscription(node("viewer"), Point, "/goal", Profile())
        Service(made, Grasp, "~/grasp", Profile())
        kind = "tests/extra/Reading"
        assert graph_queries.topic_names_and_types(made, False) == [
            ("/cell/scan", [kind]),
            ("/goal", ["tests/extra/Point"]),
        ]
        assert graph_queries.publishers_by_node(made, False, "robot", "/cell") == [("/cell/scan", [kind])]
        assert graph_queries.subscribers_by_node(made, False, "robot", "/cell") == []
        assert graph_queries.service_names_and_types(made) == [("/cell/robot/grasp", ["tests/extra/Grasp"])]
        with pytest.raises(graph_queries.NodeNameNonExistentError, match="nonexistent node /cell/arm"):
            graph_queries.publishers_by_node(made, False, "arm", "/cell")
        publisher.destroy_when_not_in_use()
        assert graph_queries.publishers_by_node(made, False, "robot", "/cell") == []

    run(robot)


def test_a_third_one_looks_on() -> None:
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        made, clock = node("robot"), Clock(ClockType.SYSTEM_TIME)
        service, client = (Service(made, Grasp, "grasp", Profile()), Client(made, Grasp, "grasp", Profile()))
        service.configure_introspection(clock, Profile(), IntrospectionState.METADATA)
        client.configure_introspection(clock, Profile(), IntrospectionState.CONTENTS)
        looking = Subscription(made, Grasp.Event, "grasp/_service_event", Profile())
        client.send_request(Grasp.Request(force=2.0))
        _, info = service.service_take_request(Grasp.Request)
        assert info is not None
        service.service_send_response(Grasp.Response(held=True), info.request_id)
        client.take_response(Grasp.Response)
        client.configure_introspection(clock, Profile(), IntrospectionState.OFF)
        client.send_request(Grasp.Request(force=3.0))
        while (taken := looking.take_message(Grasp.Event, False)) is not None:
            event = taken[0]
            assert event.info.sequence_number == 1
            contents = [each._force for each in event.request], [each._held for each in event.response]
            seen.append((event.info.event_type, *contents))

    run(robot)
    assert seen == [(0, [2.0], []), (1, [], []), (2, [], []), (3, [], [True])]


def test_a_message_whose_lifespan_is_over_is_heard_by_nobody() -> None:
    """Neither by who comes late, nor by who has not looked in time."""
    profile = Profile(durability=TRANSIENT_LOCAL, lifespan_ns=1_000_000_000)
    heard: list[list[float]] = []

    def system(kernel: Kernel) -> None:
        made = node("lidar")
        publisher, slow = Publisher(made, Reading, "scan", profile), Subscription(made, Reading, "scan", profile)
        for value in (1.0, 2.0, 3.0):
            publisher.publish(reading(value))
            kernel.sleep(0.6)
        late = Subscription(made, Reading, "scan", profile)
        heard.extend(_values(subscription) for subscription in (slow, late))
        kernel.sleep(1.0)
        assert Subscription(made, Reading, "scan", profile).take_message(Reading, False) is None

    run(system)
    assert heard == [[3.0], [3.0]]


class _Range:
    """A message with a float32, as `rosidl` generates it."""

    __slots__ = ("_far", "_near")

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return {"near": "float", "far": "double"}


def test_a_float32_is_rounded_when_it_is_sent() -> None:
    message: Any = _Range()
    message._near = message._far = 0.1
    sent = copy_message(message)
    assert (sent._near, sent._far) == (0.10000000149011612, 0.1)
    assert message._near == 0.1
