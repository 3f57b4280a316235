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
    qos_check_compatible,
    qos_profile_sensor_data,
    qos_profile_system_default,
)
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import Int32, String

from tests.extra.ros2.differential.common import Log, Main, System, alone, elapse, raised, serving, together, until

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


def comparing(log: Log) -> None:
    """Each profile with each other one, as `rclpy` compares them, and as they come to match in the graph."""
    rclpy.init()
    node, pairs = Node("node"), []
    for offered_name, offered in PROFILES.items():
        for requested_name, requested in PROFILES.items():
            compatibility, reason = qos_check_compatible(offered, requested)
            log("compared", [offered_name, requested_name, compatibility.name, bool(reason)])
    for name, profile in PROFILES.items():
        pairs.append((name, node.create_publisher(Int32, "numbers", profile)))
    subscriptions = [(name, node.create_subscription(Int32, "numbers", print, each)) for name, each in PROFILES.items()]
    elapse(node, 0.2)
    until(node, lambda: pairs[0][1].get_subscription_count() > 0)
    for name, publisher in pairs:
        log("publishers", [name, publisher.get_subscription_count()])
    for name, subscription in subscriptions:
        log("subscriptions", [name, subscription.get_publisher_count()])


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


def living(log: Log) -> None:
    """Liveliness that a talker asserts itself, until it does no more."""
    rclpy.init()
    talker, listener = Node("talker"), Node("listener")
    lost: list[int] = []
    changes: list[tuple[int, int]] = []
    profile = PROFILES["asserted"]
    publisher = talker.create_publisher(
        Int32,
        "numbers",
        profile,
        event_callbacks=PublisherEventCallbacks(liveliness=lambda event: lost.append(event.total_count)),
    )
    listener.create_subscription(
        Int32,
        "numbers",
        print,
        profile,
        event_callbacks=SubscriptionEventCallbacks(
            liveliness=lambda event: changes.append((event.alive_count, event.not_alive_count))
        ),
    )
    spun = together(talker, listener)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    timer = talker.create_timer(0.05, publisher.assert_liveliness)
    until(spun, lambda: (1, 0) in changes)
    elapse(spun, 0.5)
    log("alive", [lost, changes[-1]])
    timer.cancel()
    until(spun, lambda: changes[-1][1] == 1 and bool(lost))
    log("not alive", [lost[-1], changes[-1]])
    publisher.publish(Int32())
    until(spun, lambda: changes[-1] == (1, 0))
    log("alive again", changes[-1])


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


def overridden(log: Log) -> None:
    """Policies that parameters set."""
    arguments = ["--ros-args"]
    for name, value in (("depth", "3"), ("reliability", "best_effort"), ("history", "keep_last")):
        arguments += ["-p", f"qos_overrides./numbers.publisher.{name}:={value}"]
    rclpy.init(args=arguments)
    node = Node("node")
    options = QoSOverridingOptions.with_default_policies()
    publisher = node.create_publisher(Int32, "numbers", 10, qos_overriding_options=options)
    profile = publisher.qos_profile
    log("profile", [profile.depth, profile.reliability.name, profile.history.name, profile.durability.name])
    prefix = "qos_overrides./numbers.publisher"
    log("parameters", {name: each.value for name, each in sorted(node.get_parameters_by_prefix(prefix).items())})


def differing(log: Log) -> None:
    """One topic with two types: not in one process, and between two of them nothing is heard."""
    rclpy.init()
    node = Node("texts")
    heard: list[Any] = []
    subscription = node.create_subscription(String, "numbers", heard.append, 10)
    log("in one process", raised(lambda: node.create_publisher(Int32, "numbers", 10)))
    log("in one process", raised(lambda: node.create_subscription(Int32, "numbers", print, 10)))
    until(node, lambda: node.count_publishers("numbers") == 1)
    elapse(node, 0.3)
    log("counts", [subscription.get_publisher_count(), len(heard)])
    log("types", sorted(dict(node.get_topic_names_and_types())["/numbers"]))


SYSTEMS = {
    "incompatible": System({"listener": demanding}, {"talker": serving(unreliable)}),
    "incompatible reliability": alone(matching(BEST_EFFORT, RELIABLE)),
    "incompatible durability": alone(matching(VOLATILE, LATCHED)),
    "incompatible deadline": alone(matching(PROFILES["seldom"], PROFILES["often"])),
    "incompatible liveliness": alone(matching(PROFILES["alive"], PROFILES["asserted"])),
    "all profiles": alone(comparing),
    "matched events": alone(matched),
    "deadline": alone(missing),
    "liveliness": alone(living),
    "lifespan": alone(short_lived),
    "overridden profile": alone(overridden),
    "two types": System({"texts": differing}, {"talker": serving(unreliable)}),
}
