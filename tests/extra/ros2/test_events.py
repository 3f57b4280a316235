"""Events of quality of service."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.events import (
    EventHandle,
    PublisherEventType,
    SubscriptionEventType,
)
from pytest_hricdv.extra.ros2.graph import notes_of
from pytest_hricdv.extra.ros2.qos import BEST_EFFORT, KEEP_ALL, MANUAL_BY_TOPIC, TRANSIENT_LOCAL, Profile
from pytest_hricdv.extra.ros2.topics import Publisher, Subscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Point, Reading, node, reading, run, wait

_MS = 1_000_000


def test_who_comes_and_goes_is_counted_on_both_sides() -> None:
    def robot(kernel: Kernel) -> None:
        made = node("robot")
        publisher = Publisher(made, Reading, "scan", Profile())
        event = EventHandle(publisher, PublisherEventType.RCL_PUBLISHER_MATCHED)
        assert wait("event", [event], timeout_s=1.0) == []
        subscription = Subscription(made, Reading, "scan", Profile())
        alive = EventHandle(subscription, SubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED)
        assert wait("event", [event, alive]) == [0, 1]
        assert astuple(event.take_event()) == (1, 1, 1, 1)
        assert astuple(alive.take_event()) == (1, 0, 1, 0)
        assert wait("event", [event, alive], timeout_s=1.0) == []
        subscription.destroy_when_not_in_use()
        assert astuple(event.take_event()) == (1, 0, 0, -1)

    run(robot)


def test_what_does_not_match_says_why() -> None:
    seen: list[Any] = []

    def camera(kernel: Kernel) -> None:
        kernel.sleep(1.0)
        made = node("camera")
        publisher = Publisher(made, Reading, "scan", Profile(reliability=BEST_EFFORT))
        event = EventHandle(publisher, PublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS)
        assert astuple(event.take_event()) == (1, 1, 16)
        Publisher(node("other"), Point, "scan", Profile())

    def robot(kernel: Kernel) -> None:
        subscription = Subscription(node("robot"), Reading, "scan", Profile())
        kinds = ("RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS", "RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE")
        events = [EventHandle(subscription, SubscriptionEventType[kind]) for kind in kinds]
        assert wait("event", events) == [0, 1]
        seen.extend([kernel.now_s, *(astuple(event.take_event()) for event in events)])

    run(camera, robot)
    assert seen == [1.0, (1, 1, 16), (1, 1)]


_S = 1_000_000_000
_RELIABILITY, _DURABILITY, _DEADLINE, _LIVELINESS = 16, 2, 4, 8


@pytest.mark.parametrize(
    ("offered", "requested", "policy", "text"),
    [
        (
            {"reliability": BEST_EFFORT},
            {},
            _RELIABILITY,
            "reliability: best effort is offered, reliable requested",
        ),
        (
            {},
            {"durability": TRANSIENT_LOCAL},
            _DURABILITY,
            "durability: volatile is offered, transient local requested",
        ),
        ({"deadline_ns": 2 * _S}, {"deadline_ns": _S}, _DEADLINE, "deadline: 2 s is offered, 1 s requested"),
        ({}, {"deadline_ns": _S}, _DEADLINE, "deadline: none is offered, 1 s requested"),
        (
            {},
            {"liveliness": MANUAL_BY_TOPIC},
            _LIVELINESS,
            "liveliness: automatic is offered, manual by topic requested",
        ),
        ({}, {"lease_ns": _S}, _LIVELINESS, "lease of the liveliness: none is offered, 1 s requested"),
        (
            {"reliability": BEST_EFFORT},
            {"durability": TRANSIENT_LOCAL},
            _RELIABILITY,
            "reliability: best effort is offered, reliable requested; "
            "durability: volatile is offered, transient local requested",
        ),
        (
            {},
            {"durability": TRANSIENT_LOCAL, "deadline_ns": _S},
            _DEADLINE,
            "durability: volatile is offered, transient local requested; deadline: none is offered, 1 s requested",
        ),
        (
            {"deadline_ns": 2 * _S, "lease_ns": 2 * _S},
            {"deadline_ns": _S, "lease_ns": _S},
            _LIVELINESS,
            "deadline: 2 s is offered, 1 s requested; lease of the liveliness: 2 s is offered, 1 s requested",
        ),
    ],
)
def test_each_policy_that_does_not_match_is_told_by_events_and_noted_with_both_ends(
    offered: dict[str, Any], requested: dict[str, Any], policy: int, text: str
) -> None:
    """The events are those of Fast DDS 3.2.3, of rclpy 9.1.2: one of several policies is the last one."""

    def robot(kernel: Kernel) -> None:
        camera, planner = node("camera", namespace="/left"), node("planner")
        publisher = Publisher(camera, Reading, "scan", Profile(**offered))
        subscription = Subscription(planner, Reading, "/left/scan", Profile(**requested))
        Subscription(planner, Reading, "/left/scan", Profile(**requested))
        for endpoint, count in ((publisher, 2), (subscription, 1)):
            assert astuple(endpoint.events.incompatible) == (count, count, policy)

    kernel, _ = run(robot)
    ends = "no message goes from /left/camera to /planner, their qualities of service do not match"
    assert notes_of(kernel) == (f"/left/scan: {ends} ({text})",)


@pytest.mark.parametrize(
    ("offered", "requested"),
    [
        ({"lifespan_ns": _S}, {"lifespan_ns": 5 * _S}),
        ({"depth": 1}, {"history": KEEP_ALL}),
        ({"durability": TRANSIENT_LOCAL}, {}),
        ({}, {"reliability": BEST_EFFORT}),
        ({"deadline_ns": _S}, {"deadline_ns": 2 * _S}),
    ],
)
def test_what_matches_is_not_noted(offered: dict[str, Any], requested: dict[str, Any]) -> None:
    def robot(kernel: Kernel) -> None:
        made = node("robot")
        publisher = Publisher(made, Reading, "scan", Profile(**offered))
        Subscription(made, Reading, "scan", Profile(**requested))
        assert publisher.get_subscription_count() == 1

    assert notes_of(run(robot)[0]) == ()


def test_deadlines_that_are_missed_are_counted_from_the_last_message_on() -> None:
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        made = node("robot")
        profile = Profile(deadline_ns=100 * _MS)
        publisher = Publisher(made, Reading, "scan", profile)
        missed = EventHandle(publisher, PublisherEventType.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED)
        assert wait("event", [missed], timeout_s=1.0) == []
        publisher.publish(reading(1.0))
        kernel.sleep(0.05)
        publisher.publish(reading(2.0))
        assert wait("event", [missed]) == [0]
        seen.append((kernel.now_s, astuple(missed.take_event())))
        kernel.sleep(0.25)
        seen.append(astuple(missed.take_event()))

    run(robot)
    assert seen == [(1.15, (1, 1)), (3, 2)]


def test_who_has_to_say_that_it_is_alive_and_does_not_is_lost() -> None:
    seen: list[float] = []

    def robot(kernel: Kernel) -> None:
        publisher = Publisher(node("robot"), Reading, "scan", Profile(liveliness=MANUAL_BY_TOPIC, lease_ns=500 * _MS))
        lost = EventHandle(publisher, PublisherEventType.RCL_PUBLISHER_LIVELINESS_LOST)
        publisher.assert_liveliness()
        kernel.sleep(0.25)
        publisher.assert_liveliness()
        wait("event", [lost])
        seen.append(kernel.now_s)

    run(robot)
    assert seen == [0.75]


def test_who_comes_later_and_takes_nothing_has_lost_nothing() -> None:
    def robot(kernel: Kernel) -> None:
        publisher = Publisher(node("lidar"), Reading, "scan", Profile())
        publisher.publish(reading(1.0))
        subscription = Subscription(node("robot"), Reading, "scan", Profile(depth=1))
        lost = EventHandle(subscription, SubscriptionEventType.RCL_SUBSCRIPTION_MESSAGE_LOST)
        for value in (2.0, 3.0, 4.0):  # the queue has one place: what it pushes out had arrived
            publisher.publish(reading(value))
        assert wait("event", [lost], timeout_s=1.0) == []

    run(robot)


def test_a_publisher_whose_lease_is_over_is_not_alive_until_it_says_so() -> None:
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        profile = Profile(liveliness=MANUAL_BY_TOPIC, lease_ns=100 * _MS)
        publisher = Publisher(node("camera"), Reading, "scan", profile)
        subscription = Subscription(node("robot"), Reading, "scan", profile)
        changed = EventHandle(subscription, SubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED)
        lost = EventHandle(publisher, PublisherEventType.RCL_PUBLISHER_LIVELINESS_LOST)
        changed.take_event()
        publisher.assert_liveliness()
        assert wait("event", [changed, lost]) == [0, 1]
        seen.extend([kernel.now_s, astuple(changed.take_event()), astuple(lost.take_event())])
        kernel.sleep(1.0)
        publisher.publish(reading(1.0))
        seen.extend([astuple(changed.take_event()), astuple(lost.take_event())])

    run(robot)
    assert seen == [0.1, (0, 1, -1, 1), (1, 1), (1, 0, 1, -1), (1, 0)]
