"""Questions about the graph: nodes, names, types, end points, and waiting for nodes."""

from __future__ import annotations

import threading
from typing import Any

import rclpy
from rclpy.action import ActionClient, ActionServer, get_action_names_and_types
from rclpy.action.graph import get_action_client_names_and_types_by_node, get_action_server_names_and_types_by_node
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32, String
from test_msgs.action import Fibonacci
from test_msgs.srv import BasicTypes

from tests.extra.ros2.differential.common import PATIENCE_S, Log, System, alone, raised, serving, until

_PROFILE = QoSProfile(depth=7, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE)


def populated(log: Log) -> Node:
    node = Node("server", namespace="/cell")
    node.kept = [
        node.create_publisher(Int32, "numbers", _PROFILE),
        node.create_publisher(String, "~/texts", 10),
        node.create_subscription(
            String, "/orders", print, QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        ),
        node.create_service(BasicTypes, "add", lambda request, response: response),
        node.create_client(BasicTypes, "/elsewhere"),
        ActionServer(node, Fibonacci, "fibonacci", execute_callback=print),
        ActionClient(node, Fibonacci, "/other"),
    ]
    return node


_HIDDEN = ("parameter", "rosout", "describe", "list_", "get_", "set_")


def _shown(names_and_types: Any) -> list[Any]:
    """Without those that each node has: which they are differs between distributions."""
    shown = [[name, list(kinds)] for name, kinds in names_and_types]
    return sorted(each for each in shown if not any(part in each[0].rpartition("/")[2] for part in _HIDDEN))


def asking(log: Log) -> None:
    """All questions, of another process."""
    rclpy.init()
    node = Node("asking")
    client = ActionClient(node, Fibonacci, "/cell/fibonacci")
    client.wait_for_server(timeout_sec=PATIENCE_S)
    until(node, lambda: node.count_publishers("/cell/server/texts") == 1 and node.count_subscribers("/orders") == 1)
    until(node, lambda: ("server", "/cell") in node.get_node_names_and_namespaces())
    until(node, lambda: node.count_clients("/elsewhere") == 1 and node.count_services("/cell/add") == 1)
    until(
        node, lambda: len(get_action_names_and_types(node)) == 2 and node.count_clients("/other/_action/send_goal") == 1
    )
    log("names", sorted(node.get_node_names()))
    log("names", sorted(node.get_node_names_and_namespaces()))
    log("names", sorted(node.get_fully_qualified_node_names()))
    log("topics", _shown(node.get_topic_names_and_types()))
    log("services", _shown(node.get_service_names_and_types()))
    of = ("server", "/cell")
    log("publishers", _shown(node.get_publisher_names_and_types_by_node(*of)))
    log("subscriptions", _shown(node.get_subscriber_names_and_types_by_node(*of)))
    log("services", _shown(node.get_service_names_and_types_by_node(*of)))
    log("clients", _shown(node.get_client_names_and_types_by_node(*of)))
    log("nobody", raised(lambda: node.get_publisher_names_and_types_by_node("nobody", "/")))
    log("actions", _shown(get_action_names_and_types(node)))
    log("actions", _shown(get_action_server_names_and_types_by_node(node, *of)))
    log("actions", _shown(get_action_client_names_and_types_by_node(node, *of)))
    for name in ("/cell/numbers", "numbers", "/nothing"):
        log("counts", [name, node.count_publishers(name), node.count_subscribers(name)])
    log(
        "counts",
        [
            node.count_services("/cell/add"),
            node.count_clients("/elsewhere"),
            raised(lambda: node.count_services("a b")),
        ],
    )
    for about in (
        *node.get_publishers_info_by_topic("/cell/numbers"),
        *node.get_subscriptions_info_by_topic("/orders"),
    ):
        profile = about.qos_profile
        log("end points", [about.node_name, about.node_namespace, about.topic_type, about.endpoint_type.name])
        log("end points", [profile.reliability.name, profile.durability.name, profile.liveliness.name])
        log("end points", [len(about.endpoint_gid), str(about.topic_type_hash)[:6]])


def waiting(log: Log) -> None:
    """A node that is waited for: it comes, it goes."""
    rclpy.init()
    node = Node("node")
    log("itself", node.wait_for_node("/node", PATIENCE_S))
    log("nobody", node.wait_for_node("/cell/late", 0.1))
    made: list[Node] = []
    thread = threading.Timer(0.2, lambda: made.append(Node("late", namespace="/cell")))
    thread.start()
    log("late", node.wait_for_node("/cell/late", PATIENCE_S))
    thread.join()
    made[0].destroy_node()
    log("gone", until(node, lambda: "late" not in node.get_node_names()))


SYSTEMS = {
    "graph": System({"asking": asking}, {"server": serving(populated)}),
    "wait for nodes": alone(waiting),
}
