"""Contexts: several in a process, domains, what is left when one is shut down; logs."""

from __future__ import annotations

import threading
import time
from typing import Any

import rclpy
from rcl_interfaces.msg import Log as LogMessage
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Int32
from test_msgs.srv import BasicTypes

from tests.extra.ros2.differential.common import Log, System, alone, elapse, raised, together, until


def several(log: Log) -> None:
    """Contexts of two domains: nodes of one domain hear each other, those of the other do not."""
    contexts = [Context(), Context(), Context()]
    for context, domain in zip(contexts, (151, 151, 152), strict=True):
        context.init(domain_id=domain)
    log("domains", [context.get_domain_id() for context in contexts])
    heard: dict[int, list[int]] = {0: [], 1: [], 2: []}
    nodes = [Node(f"node{number}", context=context) for number, context in enumerate(contexts)]
    executors = [SingleThreadedExecutor(context=context) for context in contexts]
    for number, (node, executor) in enumerate(zip(nodes, executors, strict=True)):
        node.create_subscription(Int32, "numbers", lambda each, number=number: heard[number].append(each.data), 10)
        executor.add_node(node)
    publisher = nodes[0].create_publisher(Int32, "numbers", 10)
    until(executors[0], lambda: publisher.get_subscription_count() == 2)
    publisher.publish(Int32(data=1))
    for number in (0, 1):
        until(executors[number], lambda number=number: bool(heard[number]))
    elapse(executors[2], 0.2)
    log("heard", list(heard.values()))
    log("mixed", executors[0].add_node(nodes[2]))
    contexts[1].shutdown()
    log("ok", [context.ok() for context in contexts])
    log("shut down", raised(lambda: executors[1].spin_once(timeout_sec=0.1)))
    until(executors[0], lambda: publisher.get_subscription_count() == 1, 0.5)
    publisher.publish(Int32(data=2))
    log("goes on", until(executors[0], lambda: len(heard[0]) == 2))
    for context in (contexts[0], contexts[2]):
        context.shutdown()


def ending(log: Log) -> None:
    """A callback shuts the context down: what spinning does, what is called, what is not possible afterwards."""
    rclpy.init()
    node, called = Node("node"), []
    publisher = node.create_publisher(Int32, "numbers", 10)
    service = node.create_service(BasicTypes, "service", lambda request, response: response)
    rclpy.get_default_context().on_shutdown(lambda: called.append("on shutdown"))
    node.create_timer(0.05, rclpy.shutdown)
    log("spin", raised(lambda: rclpy.spin(node)))
    log("called", called)
    log("ok", [rclpy.ok(), rclpy.get_default_context().ok()])
    log("again", [raised(rclpy.shutdown), raised(rclpy.try_shutdown)])
    log("spin again", raised(lambda: rclpy.spin_once(node, timeout_sec=0.1)))
    log("publish", raised(lambda: publisher.publish(Int32())))
    log("new publisher", raised(lambda: node.create_publisher(Int32, "others", 10)))
    log("new timer", raised(lambda: node.create_timer(1.0, print)))
    log("new node", raised(lambda: Node("other")))
    log("log", raised(lambda: node.get_logger().info("after the end")))
    log("destroyed", [node.destroy_service(service), raised(node.destroy_node)])
    rclpy.init()
    other = Node("other")
    log("a new life", [rclpy.ok(), other.get_name()])


def beginning(log: Log) -> None:
    """What is not possible before `init`, and twice."""
    log("ok", rclpy.ok())
    log("node", raised(lambda: Node("node")))
    log("shutdown", [raised(rclpy.shutdown), raised(rclpy.try_shutdown)])
    rclpy.init(args=["--ros-args", "--log-level", "warn"])
    log("twice", raised(rclpy.init))
    node = Node("node")
    log("level", [node.get_logger().get_effective_level().name])
    log("destroyed", [raised(node.destroy_node), raised(node.destroy_node)])
    log(
        "after the end",
        [raised(lambda: node.create_publisher(Int32, "numbers", 10)), raised(node.get_topic_names_and_types)],
    )
    rclpy.shutdown()
    with rclpy.init() as context:
        log("context manager", context.context.ok())
    log("context manager", rclpy.ok())
    log("wrong arguments", raised(lambda: rclpy.init(args=["--ros-args", "--remap", "wrong"])))


def ending_from_outside(log: Log) -> None:
    """A thread shuts the context down: what others who wait in it do."""
    rclpy.init()
    node, outcomes = Node("node"), {}

    def wait(name: str, action: Any) -> threading.Thread:
        def note() -> None:
            outcomes[name] = raised(action)

        thread = threading.Thread(target=note)
        thread.start()
        return thread

    executor = together(node)
    client = node.create_client(BasicTypes, "nobody")
    threads = [wait("spin", executor.spin), wait("wait for service", lambda: client.wait_for_service(timeout_sec=10.0))]
    time.sleep(0.2)
    rclpy.shutdown()
    for thread in threads:
        thread.join()
    log("outcomes", [[name, outcomes[name]] for name in sorted(outcomes)])
    log("exception", issubclass(ExternalShutdownException, Exception))


def logging_(log: Log) -> None:
    rclpy.init()
    node = Node("logging")
    logger = node.get_logger()
    logger.info("first")
    logger.debug("not seen")
    logger.get_child("arm").warning("second")
    for _ in range(3):
        logger.info("once", once=True)
        logger.info("skipped first", skip_first=True)
        logger.error("throttled", throttle_duration_sec=60.0)
    logger.set_level(LoggingSeverity.ERROR)
    logger.warning("not seen, either")
    logger.fatal("last")
    log("levels", [logger.get_effective_level().name, logger.get_child("arm").get_effective_level().name])
    log("enabled", [logger.is_enabled_for(each) for each in (LoggingSeverity.WARN, LoggingSeverity.ERROR)])
    heard = node.create_publisher(Int32, "logged", 10)
    until(node, lambda: heard.get_subscription_count() > 0)


def hearing_logs(log: Log) -> None:
    rclpy.init()
    node, lines = Node("hearing"), []
    profile = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)

    def hear(message: Any) -> None:
        if message.name.startswith("logging"):
            level = message.level if isinstance(message.level, int) else message.level[0]
            lines.append([message.name, level, message.msg, message.function, bool(message.line)])

    node.create_subscription(LogMessage, "/rosout", hear, profile)
    until(node, lambda: any(line[2] == "last" for line in lines))
    log("lines", lines)
    node.create_subscription(Int32, "logged", lambda message: None, 10)
    until(node, lambda: node.count_publishers("logged") == 0)


SYSTEMS = {
    "several contexts": alone(several),
    "the end of a context": alone(ending),
    "before and after": alone(beginning),
    "the end from outside": alone(ending_from_outside),
    "logs": System({"logging": logging_, "hearing": hearing_logs}),
}
