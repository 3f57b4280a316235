"""Contexts: several in a process, domains, what is left when one is shut down; logs."""

from __future__ import annotations

import threading
import time
from typing import Any

import rclpy
from rcl_interfaces.msg import Log as LogMessage
from rclpy.executors import ExternalShutdownException
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Int32
from test_msgs.srv import BasicTypes

from tests.extra.ros2.differential.common import Log, System, alone, raised, together, until


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
    "the end of a context": alone(ending),
    "the end from outside": alone(ending_from_outside),
    "logs": System({"logging": logging_, "hearing": hearing_logs}),
}
