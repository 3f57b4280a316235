"""Topics: histories, kept messages, several talkers, names, messages of all kinds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32
from test_msgs.msg import Arrays, BasicTypes, Defaults, MultiNested, Nested, Strings, UnboundedSequences

from tests.extra.ros2.differential.common import (
    PATIENCE_S,
    Log,
    Main,
    System,
    alone,
    elapse,
    raised,
    serving,
    together,
    until,
)

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


def publishing(messages: Sequence[Any], profile: QoSProfile | int, *, name: str = "talker", listeners: int = 1) -> Main:
    """Publishes messages once somebody listens, and stays until somebody says that all is heard."""

    def main(log: Log) -> None:
        rclpy.init()
        node = Node(name)
        over: list[Any] = []
        publishers = {type(each): node.create_publisher(type(each), _topic(type(each)), profile) for each in messages}
        node.create_subscription(Int32, "over", over.append, 10)
        for publisher in publishers.values():
            until(node, lambda publisher=publisher: publisher.get_subscription_count() >= listeners)
        for message in messages:
            publishers[type(message)].publish(message)
        log("over", until(node, lambda: len(over) == listeners))

    return main


def listening(
    kinds: Sequence[type[Any]], count: int, profile: QoSProfile | int, *, name: str = "listener", talkers: int = 1
) -> Main:
    """Logs messages until it has heard so many."""

    def main(log: Log) -> None:
        rclpy.init()
        node = Node(name)
        heard: dict[Any, list[Any]] = {kind: [] for kind in kinds}
        for kind in kinds:
            node.create_subscription(kind, _topic(kind), heard[kind].append, profile)
        over = node.create_publisher(Int32, "over", 10)
        until(node, lambda: sum(map(len, heard.values())) == count)
        for kind in kinds:
            log(_topic(kind), [str(message) for message in heard[kind]])
        until(node, lambda: over.get_subscription_count() == talkers)
        over.publish(Int32())
        until(node, lambda: over.get_subscription_count() == 0)

    return main


def _topic(kind: type[Any]) -> str:
    return "numbers" if kind is Int32 else kind.__name__.lower()


def _numbers(count: int, first: int = 0) -> list[Int32]:
    return [Int32(data=first + number) for number in range(count)]


def _messages() -> list[Any]:
    """Of all kinds of field: numbers at their limits, texts, arrays, sequences, messages in messages."""
    basic = BasicTypes(
        bool_value=True,
        byte_value=b"\xff",
        char_value=255,
        float32_value=0.1,
        float64_value=-1e308,
        int8_value=-128,
        uint8_value=255,
        int16_value=-(2**15),
        uint16_value=2**16 - 1,
        int32_value=-(2**31),
        uint32_value=2**32 - 1,
        int64_value=-(2**63),
        uint64_value=2**64 - 1,
    )
    return [
        basic,
        Strings(string_value="Ärger\n“quoted”", bounded_string_value="22 characters, at most"),
        Arrays(string_values=["", "a", "b"], int64_values=[1, -2, 3], basic_types_values=[basic] * 3),
        UnboundedSequences(bool_values=[True, False], float64_values=[0.5] * 5, basic_types_values=[BasicTypes()]),
        Nested(basic_types_value=basic),
        MultiNested(),
        Defaults(),
    ]


_KINDS = (BasicTypes, Strings, Arrays, UnboundedSequences, Nested, MultiNested, Defaults)


def latching(log: Log) -> Node:
    """Publishes five messages before anybody listens."""
    node = Node("talker")
    publisher = node.create_publisher(Int32, "numbers", LATCHED)
    for message in _numbers(5):
        publisher.publish(message)
    node.kept = [publisher, node.create_publisher(Int32, "published", 1)]
    return node


def _until_published(node: Node) -> None:
    """Listeners are late: the talker has published before any of them is there."""
    until(node, lambda: node.count_publishers("published") == 1)


def late(profile: QoSProfile, expected: int) -> Main:
    """Hears what was published before it was there, or not."""

    def main(log: Log) -> None:
        rclpy.init()
        node, heard = Node("listener"), []
        _until_published(node)
        subscription = node.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), profile)
        until(node, lambda: subscription.get_publisher_count() > 0)
        if expected:
            until(node, lambda: len(heard) == expected)
        else:
            elapse(node, 0.5)
        log("numbers", heard)

    return main


def waiting(log: Log) -> None:
    rclpy.init()
    node = Node("waiting")
    _until_published(node)
    came, message = wait_for_message(Int32, node, "numbers", qos_profile=LATCHED, time_to_wait=PATIENCE_S)
    log("came", [came, message.data >= 2])
    log("nothing", wait_for_message(Int32, node, "silence", time_to_wait=0.3)[0])


def keeping(profile: QoSProfile) -> Main:
    """Takes nothing until all has arrived: what its history keeps is what it hears."""

    def main(log: Log) -> None:
        rclpy.init()
        talker, listener, heard = Node("talker"), Node("listener"), []
        publisher = talker.create_publisher(Int32, "numbers", QoSProfile(depth=10))
        listener.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), profile)
        until(talker, lambda: publisher.get_subscription_count() == 1)
        for message in _numbers(6):
            publisher.publish(message)
        log("acknowledged", publisher.wait_for_all_acked(Duration(seconds=PATIENCE_S)))
        until(listener, lambda: 5 in heard)
        log("numbers", heard)

    return main


def unreliable(log: Log) -> None:
    """A reliable talker and a best-effort listener match; what it hears, it hears in order."""
    rclpy.init()
    node = Node("both")
    heard: list[Any] = []
    sent: list[Any] = []
    publisher = node.create_publisher(Int32, "numbers", 10)
    node.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), BEST_EFFORT)

    def tick() -> None:
        sent.append(len(sent))
        publisher.publish(Int32(data=sent[-1]))

    node.create_timer(0.02, tick)
    log("enough", until(node, lambda: len(heard) > 5))
    log("in order", heard == sorted(heard))
    log("best-effort listeners", publisher.get_subscription_count())


def coming_and_going(log: Log) -> None:
    """Publishers and subscriptions are destroyed and made anew."""
    rclpy.init()
    talker, listener, heard = Node("talker"), Node("listener"), []
    spun = together(talker, listener)

    def listen() -> Any:
        return listener.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), 10)

    publisher, subscription = talker.create_publisher(Int32, "numbers", 10), listen()
    until(spun, lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=1))
    until(spun, lambda: len(heard) == 1)
    log("destroyed", listener.destroy_subscription(subscription))
    log("nobody", until(spun, lambda: publisher.get_subscription_count() == 0))
    publisher.publish(Int32(data=2))
    subscription = listen()
    until(spun, lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=3))
    until(spun, lambda: len(heard) == 2)
    talker.destroy_publisher(publisher)
    log("no talker", until(spun, lambda: subscription.get_publisher_count() == 0))
    log("after the end", raised(lambda: publisher.publish(Int32(data=4))))
    publisher = talker.create_publisher(Int32, "numbers", 10)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=5))
    until(spun, lambda: len(heard) == 3)
    log("numbers", heard)


def named(log: Log) -> None:
    """Namespaces, private names and remappings."""
    rclpy.init(args=["--ros-args", "-r", "everywhere:=somewhere", "-r", "right:speed:=limit"])
    arguments = ["--ros-args", "-r", "numbers:=/all/numbers", "-r", "__node:=left"]
    for node in (Node("arm", namespace="cell", cli_args=arguments), Node("right", namespace="/cell/deep")):
        about = node.get_name()
        log(about, [node.get_namespace(), node.get_fully_qualified_name(), node.get_logger().name])
        for name in ("numbers", "~/own", "/absolute", "deep/er", "everywhere", "speed", "{node}/{ns}"):
            log(about, [name, raised(lambda node=node, name=name: node.resolve_topic_name(name))])
        for name in ("numbers", "~/own", "/absolute", "deep/er", "everywhere", "speed"):
            log(about, [name, node.resolve_topic_name(name), node.resolve_service_name(name)])
            log(about, node.create_publisher(Int32, name, 1).topic_name)


SYSTEMS = {
    "topic": System({"talker": publishing(_numbers(20), 50), "listener": listening([Int32], 20, 50)}),
    "two listeners": System(
        {
            "talker": publishing(_numbers(10), 50, listeners=2),
            "left": listening([Int32], 10, 50, name="left"),
            "right": listening([Int32], 10, 50, name="right"),
        }
    ),
    "messages of all kinds": System(
        {"talker": publishing(_messages(), 10), "listener": listening(_KINDS, len(_KINDS), 10)}
    ),
    "late listener": System({"listener": late(LATCHED, 3)}, {"talker": serving(latching)}),
    "late volatile listener": System({"listener": late(QoSProfile(depth=10), 0)}, {"talker": serving(latching)}),
    "wait for message": System({"waiting": waiting}, {"talker": serving(latching)}),
    "keep last": alone(keeping(QoSProfile(depth=3))),
    "keep all": alone(keeping(QoSProfile(history=HistoryPolicy.KEEP_ALL))),
    "best effort": alone(unreliable),
    "coming and going": alone(coming_and_going),
    "names": alone(named),
}
