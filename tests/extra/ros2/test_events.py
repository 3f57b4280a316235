"""Events of quality of service."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import pytest

from pytest_hricdv.extra.ros2.graph import notes_of
from pytest_hricdv.extra.ros2.qos import BEST_EFFORT, KEEP_ALL, MANUAL_BY_TOPIC, TRANSIENT_LOCAL, Profile
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import Reading, node, run

_MS = 1_000_000


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
        subscription = TopicSubscription(planner, Reading, "/left/scan", Profile(**requested))
        TopicSubscription(planner, Reading, "/left/scan", Profile(**requested))
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
        TopicSubscription(made, Reading, "scan", Profile(**requested))
        assert publisher.get_subscription_count() == 1

    assert notes_of(run(robot)[0]) == ()
