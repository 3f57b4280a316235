"""Quality of service: what matches, and the events that say what happened."""

from __future__ import annotations

import time
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
    qos_profile_system_default,
)
from std_msgs.msg import Int32

from tests.extra.ros2.differential.common import Log, Main, System, alone, elapse, serving, together, until

_OFTEN = Duration(seconds=0.2)
_SELDOM = Duration(seconds=0.6)

RELIABLE = QoSProfile(depth=10)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
VOLATILE = QoSProfile(depth=10, durability=DurabilityPolicy.VOLATILE)
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PROFILES = {
    "reliable": RELIABLE,
    "best effort": BEST_EFFORT,
    "latched": LATCHED,
    "latched, best effort": QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.BEST_EFFORT
    ),
    "often": QoSProfile(depth=10, deadline=_OFTEN),
    "seldom": QoSProfile(depth=10, deadline=_SELDOM),
    "alive": QoSProfile(depth=10, liveliness=LivelinessPolicy.AUTOMATIC, liveliness_lease_duration=_SELDOM),
    "asserted": QoSProfile(depth=10, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=_OFTEN),
    "system": qos_profile_system_default,
    "sensor": qos_profile_sensor_data,
}


def unreliable(log: Log) -> Node:
    node = Node("talker")
    publisher = node.create_publisher(Int32, "numbers", BEST_EFFORT)
    node.create_timer(0.1, lambda: publisher.publish(Int32(data=1)))
    return node


def demanding(log: Log) -> None:
    """Asks for more than is offered: it matches nobody, and hears nothing."""
    rclpy.init()
    node = Node("listener")
    heard: list[Any] = []
    subscription = node.create_subscription(Int32, "numbers", heard.append, RELIABLE)
    until(node, lambda: node.count_publishers("numbers") > 0)
    elapse(node, 0.5)
    log("numbers", heard)
    log("publishers", subscription.get_publisher_count())


def matching(offered: QoSProfile, requested: QoSProfile) -> Main:
    """A pair that does not match; both ends hear why."""

    def main(log: Log) -> None:
        rclpy.init()
        talker = Node("talker")
        listener = Node("listener")
        heard: list[Any] = []
        events: list[tuple[str, int, str]] = []

        def note(end: str) -> Any:
            return lambda event: events.append((end, event.total_count, QoSPolicyKind(event.last_policy_kind).name))

        publisher = talker.create_publisher(
            Int32, "numbers", offered, event_callbacks=PublisherEventCallbacks(incompatible_qos=note("talker"))
        )
        subscription = listener.create_subscription(
            Int32,
            "numbers",
            heard.append,
            requested,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=note("listener")),
        )
        spun = together(talker, listener)
        until(spun, lambda: len(events) == 2)
        publisher.publish(Int32(data=1))
        elapse(spun, 0.2)
        for event in sorted(events):
            log("events", event)
        log("counts", [publisher.get_subscription_count(), subscription.get_publisher_count(), len(heard)])

    return main


def matched(log: Log) -> None:
    """Who comes and goes, as both ends hear it."""
    rclpy.init()
    talker, listener = Node("talker"), Node("listener")
    seen: dict[str, list[tuple[int, int, int]]] = {"talker": [], "listener": []}

    def note(end: str) -> Any:
        return lambda event: seen[end].append((event.total_count, event.current_count, event.current_count_change))

    spun = together(talker, listener)
    events = PublisherEventCallbacks(matched=note("talker"))
    publisher = talker.create_publisher(Int32, "numbers", 10, event_callbacks=events)
    for count in (1, 2):
        events_of_listener = SubscriptionEventCallbacks(matched=note("listener"))
        subscription = listener.create_subscription(Int32, "numbers", print, 10, event_callbacks=events_of_listener)
        until(spun, lambda count=count: len(seen["talker"]) == 2 * count - 1 and len(seen["listener"]) == count)
        listener.destroy_subscription(subscription)
        until(spun, lambda count=count: len(seen["talker"]) == 2 * count)
    talker.destroy_publisher(publisher)
    for end, events_seen in seen.items():
        log(end, events_seen)


def missing(log: Log) -> None:
    """Deadlines: nothing comes for longer than was agreed."""
    rclpy.init()
    talker, listener = Node("talker"), Node("listener")
    counts = {"talker": 0, "listener": 0}

    def note(end: str) -> Any:
        def count(event: Any) -> None:
            counts[end] = event.total_count

        return count

    events = PublisherEventCallbacks(deadline=note("talker"))
    publisher = talker.create_publisher(Int32, "numbers", PROFILES["often"], event_callbacks=events)
    heard: list[int] = []
    listener.create_subscription(
        Int32,
        "numbers",
        heard.append,
        PROFILES["seldom"],
        event_callbacks=SubscriptionEventCallbacks(deadline=note("listener")),
    )
    spun = together(talker, listener)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    timer = talker.create_timer(0.05, lambda: publisher.publish(Int32()))
    elapse(spun, 0.5)
    log("in time", dict(counts))
    timer.cancel()
    until(spun, lambda: min(counts.values()) > 0)
    log("late", [counts["talker"] > counts["listener"] > 0, len(heard) > 5])


def short_lived(log: Log) -> None:
    """Messages that nobody takes before their lifespan is over are gone."""
    rclpy.init()
    talker, listener, heard = Node("talker"), Node("listener"), []
    publisher = talker.create_publisher(Int32, "numbers", QoSProfile(depth=10, lifespan=_OFTEN))
    listener.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), 10)
    until(talker, lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=1))
    time.sleep(0.5)
    publisher.publish(Int32(data=2))
    until(listener, lambda: len(heard) > 0)
    elapse(listener, 0.2)
    log("numbers", heard)


SYSTEMS = {
    "incompatible": System({"listener": demanding}, {"talker": serving(unreliable)}),
    "incompatible reliability": alone(matching(BEST_EFFORT, RELIABLE)),
    "incompatible durability": alone(matching(VOLATILE, LATCHED)),
    "incompatible deadline": alone(matching(PROFILES["seldom"], PROFILES["often"])),
    "incompatible liveliness": alone(matching(PROFILES["alive"], PROFILES["asserted"])),
    "matched events": alone(matched),
    "deadline": alone(missing),
    "lifespan": alone(short_lived),
}
