"""When messages arrive: drawn from the seed of the test, in order unless they may overtake, never lost if reliable."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.extra.ros2 import qos
from pytest_hricdv.extra.ros2.bridge import Bridge, vocabulary
from pytest_hricdv.extra.ros2.events import EventHandle, SubscriptionEventType
from pytest_hricdv.extra.ros2.graph import carry_with
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.extra.ros2.world import wait_for
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.runtime.node_error import NodeError
from tests.extra.ros2.test_bridge import CELL, Cell, scan

pytestmark = pytest.mark.usefixtures("cell_msgs")

SCAN = "/cell/scan"


def timed(seed: int = 1, **timing: Any) -> Cell:
    """A run of the cell whose middleware takes time."""
    run = Cell()
    del run.kernel.own["ros2 carrier"]
    carry_with(run.kernel, Bridge(run.bus, replace(CELL, **timing), seed))
    return run


def arrivals(run: Cell, count: int = 20, *, is_reliable: bool = False) -> list[tuple[int, float]]:
    """Number and time (s) of the messages that come, of as many at 100 Hz."""
    from cell_msgs.msg import Scan  # type: ignore[import-not-found, unused-ignore]

    profile = qos.Profile(depth=1000) if is_reliable else qos.Profile(depth=1000, reliability=qos.BEST_EFFORT)
    publisher = Publisher(run.node("lidar")._node, Scan, SCAN, qos.Profile())
    hearing = TopicSubscription(run.node("robot")._node, Scan, SCAN, profile)
    came: list[tuple[int, float]] = []

    def hear() -> None:
        while True:
            wait_for("subscription", hearing, None)
            came.append((hearing.take_message(Scan, False)[0].count, run.kernel.now_s))  # type: ignore[index]

    def publish() -> None:
        for number in range(count):
            publisher.publish(scan(count=number))
            run.kernel.sleep(0.01)

    run.kernel.spawn("hear", hear)
    run.run(publish)
    return came


def test_messages_are_late_in_order_and_the_same_in_each_repeat() -> None:
    timing: dict[str, Any] = {"delay_s": {SCAN: Uniform(0.0, 0.05, "s")}}
    came = arrivals(timed(**timing))
    assert [number for number, _ in came] == list(range(20))
    delays_s = [time_s - number * 0.01 for number, time_s in came]
    assert all(0.0 <= delay_s <= 0.0501 for delay_s in delays_s)
    assert len({round(delay_s, 6) for delay_s in delays_s}) > 5
    assert arrivals(timed(**timing)) == came
    assert arrivals(timed(seed=2, **timing)) != came


def test_messages_overtake_each_other_where_they_may() -> None:
    came = arrivals(timed(delay_s={"/cell/*": Uniform(0.0, 0.05)}, reorder=(SCAN,)))
    numbers = [number for number, _ in came]
    assert numbers != sorted(numbers)
    assert sorted(numbers) == list(range(20))


def test_a_share_of_the_messages_of_best_effort_is_lost() -> None:
    run = timed(drop={SCAN: 0.5})
    came = arrivals(run, count=200)
    assert 70 <= len(came) <= 130  # 200 draws of 1/2: 100, and four standard deviations of 7
    lost = [message for message in run.recorder.messages if message.topic == "lost cell_scan"]
    assert len(lost) == 200 - len(came)
    assert len(came) == sum(message.topic == "cell_scan" for message in run.recorder.messages)


@pytest.mark.parametrize(
    ("timing", "problem"),
    [
        (
            {"drop": {SCAN: 0.1}},
            "drop of /cell/scan: /lidar publishes and /robot subscribes reliably, so the middleware sends",
        ),
        (
            {"delay_s": {SCAN: Uniform(0.0, 0.1)}, "reorder": (SCAN,)},
            "reorder of /cell/scan: /lidar publishes and /robot subscribes reliably, so the middleware keeps the order",
        ),
    ],
)
def test_what_is_carried_reliably_is_neither_lost_nor_reordered(timing: dict[str, Any], problem: str) -> None:
    with pytest.raises(NodeError, match=problem):
        arrivals(timed(**timing), is_reliable=True)


def test_services_and_actions_take_time_in_both_directions() -> None:
    run = timed(delay_s={"/grasp": 0.5, "/fetch": 1.0})
    run.node("gripper").serve("/grasp", "cell_msgs/srv/Grasp", lambda request, response: response)
    client = run.node("person").client("/grasp", "cell_msgs/srv/Grasp")
    ended_s: list[float] = []

    def person() -> None:
        client.call(5.0, force=1.0)
        ended_s.append(run.kernel.now_s)

    assert run.run(person) == [
        "0.000 test timing of the middleware /grasp=delay 0.5..0.5 s /fetch=delay 1..1 s",
        "0.500 person grasp_request force=1.0",
        "1.000 gripper grasp_response held=False",
    ]
    assert ended_s == [1.0]


@pytest.mark.parametrize(
    ("timing", "problem"),
    [
        ({"delay_s": {SCAN: -1.0}}, "delay_s of '/cell/scan' is -1.0; expected seconds, such as 0.01 or Uniform"),
        ({"delay_s": {SCAN: math.inf}}, "delay_s of '/cell/scan' is inf; expected seconds"),
        ({"delay_s": {SCAN: "fast"}}, "delay_s of '/cell/scan' is fast; expected seconds"),
        ({"delay_s": {SCAN: Uniform(1.0, 5.0, "ms")}}, "delay_s of '/cell/scan' is range .* ms; expected seconds"),
        ({"drop": {SCAN: 1.5}}, "drop of '/cell/scan' is 1.5; expected a share of messages, from 0 to 1"),
        ({"drop": {SCAN: True}}, "drop of '/cell/scan' is True; expected a share"),
        ({"reorder": (SCAN,)}, "reorder of '/cell/scan': its messages have no delay; declare delay_s"),
    ],
)
def test_a_mistake_is_said_before_anything_runs(timing: dict[str, Any], problem: str) -> None:
    with pytest.raises(Ros2Error, match=problem):
        vocabulary(Ros2(**timing))


def test_a_subscription_hears_by_the_next_message_of_how_many_were_lost() -> None:
    from cell_msgs.msg import Scan  # type: ignore[import-not-found, unused-ignore]

    run = timed(drop={SCAN: 0.5})
    best_effort = qos.Profile(depth=1000, reliability=qos.BEST_EFFORT)
    publisher = Publisher(run.node("lidar")._node, Scan, SCAN, best_effort)
    hearing = TopicSubscription(run.node("robot")._node, Scan, SCAN, best_effort)
    lost = EventHandle(hearing, SubscriptionEventType.RCL_SUBSCRIPTION_MESSAGE_LOST)
    came: list[int] = []

    def publish() -> None:
        for number in range(20):
            publisher.publish(scan(count=number))
        while (taken := hearing.take_message(Scan, False)) is not None:
            came.append(taken[0].count)

    run.run(publish)
    missing = came[-1] - came[0] + 1 - len(came)
    assert 0 < missing < 15
    assert astuple(lost.take_event()) == (missing, missing)
    assert not lost.is_ready()


def test_a_filter_of_content_is_an_error_that_says_so() -> None:
    from cell_msgs.msg import Scan

    with pytest.raises(RCLError, match="content filters are not simulated: range > 1; filter the messages"):
        TopicSubscription(timed().node("arm")._node, Scan, SCAN, qos.Profile(), ("range > 1", []))
