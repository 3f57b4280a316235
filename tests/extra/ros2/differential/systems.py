"""A dozen small systems. Each node logs what it hears, by topic; nothing depends on how fast a machine is."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import SetParametersResult
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Int32

Log = Callable[[str, object], None]
Main = Callable[[Log], None]

PATIENCE_S = 20.0


@dataclass(frozen=True)
class System:
    """Some processes: those that end by themselves, and servers, which are ended when the others are over."""

    ending: Mapping[str, Main]
    servers: Mapping[str, Main]


def until(node: Node, condition: Callable[[], bool]) -> bool:
    """Spin until something holds; whether it does."""
    end_s = time.monotonic() + PATIENCE_S
    while not condition() and time.monotonic() < end_s:
        rclpy.spin_once(node, timeout_sec=0.05)
    return condition()


def answered(node: Node, future: Any) -> Any:
    """Spin until a future is done; its result."""
    rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE_S)
    return future.result()


def serving(make: Callable[[Log], Node], threads: int = 1) -> Main:
    """The main function of a server: its node is spun until the process is ended."""

    def main(log: Log) -> None:
        rclpy.init()
        executor = MultiThreadedExecutor(num_threads=threads) if threads > 1 else SingleThreadedExecutor()
        executor.add_node(make(log))
        with suppress(KeyboardInterrupt, ExternalShutdownException):
            executor.spin()

    return main


def publishing(count: int, profile: QoSProfile | int, *, listeners: int = 1) -> Main:
    """Publishes numbers once somebody listens, and stays until somebody says that all is heard."""

    def main(log: Log) -> None:
        rclpy.init()
        node, over = Node("talker"), []
        publisher = node.create_publisher(Int32, "numbers", profile)
        node.create_subscription(Int32, "over", over.append, 10)
        until(node, lambda: publisher.get_subscription_count() >= listeners)
        for number in range(count):
            publisher.publish(Int32(data=number))
        log("over", until(node, lambda: len(over) == listeners))

    return main


def listening(name: str, count: int, profile: QoSProfile | int) -> Main:
    """Logs numbers until it has heard so many."""

    def main(log: Log) -> None:
        rclpy.init()
        node, heard = Node(name), []
        node.create_subscription(Int32, "numbers", lambda message: heard.append(message.data), profile)
        over = node.create_publisher(Int32, "over", 10)
        until(node, lambda: len(heard) == count)
        log("numbers", heard)
        until(node, lambda: over.get_subscription_count() > 0)
        over.publish(Int32())
        until(node, lambda: over.get_subscription_count() == 0)

    return main


LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


def latching(log: Log) -> Node:
    """Publishes five messages before anybody listens."""
    node = Node("talker")
    publisher = node.create_publisher(Int32, "numbers", LATCHED)
    for number in range(5):
        publisher.publish(Int32(data=number))
    node.kept = publisher  # type: ignore[attr-defined]
    return node


def late(log: Log) -> None:
    rclpy.init()
    node, heard = Node("listener"), []
    node.create_subscription(Int32, "numbers", lambda message: heard.append(message.data), LATCHED)
    until(node, lambda: len(heard) == 3)
    log("numbers", heard)


def unreliable(log: Log) -> Node:
    node = Node("talker")
    publisher = node.create_publisher(Int32, "numbers", BEST_EFFORT)
    node.create_timer(0.1, lambda: publisher.publish(Int32(data=1)))
    return node


def demanding(log: Log) -> None:
    """Asks for more than is offered: it matches nobody, and hears nothing."""
    rclpy.init()
    node, heard = Node("listener"), []
    subscription = node.create_subscription(Int32, "numbers", heard.append, QoSProfile(depth=10))
    until(node, lambda: node.count_publishers("numbers") > 0)
    end_s = time.monotonic() + 1.0
    until(node, lambda: time.monotonic() > end_s)
    log("numbers", heard)
    log("publishers", subscription.get_publisher_count())


def adding(log: Log) -> Node:
    node = Node("adder")

    def add(request: Any, response: Any) -> Any:
        log("add", [request.a, request.b])
        response.sum = request.a + request.b
        return response

    node.create_service(AddTwoInts, "add", add)
    return node


def asking(log: Log) -> None:
    rclpy.init()
    node = Node("asker")
    client = node.create_client(AddTwoInts, "add")
    log("server", client.wait_for_service(timeout_sec=PATIENCE_S))
    for number in range(3):
        log("sum", answered(node, client.call_async(AddTwoInts.Request(a=number, b=40))).sum)
    log("no server", node.create_client(AddTwoInts, "subtract").wait_for_service(timeout_sec=0.3))


def asking_in_a_row(log: Log) -> None:
    """All requests are sent before the first answer is looked at."""
    rclpy.init()
    node = Node("asker")
    client = node.create_client(AddTwoInts, "add")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    futures = [client.call_async(AddTwoInts.Request(a=number, b=1)) for number in range(5)]
    log("sums", [answered(node, future).sum for future in futures])


def relaying(log: Log) -> Node:
    """A service whose callback asks another service, and waits: it needs a reentrant group and threads."""
    node, group = Node("relay"), ReentrantCallbackGroup()
    client = node.create_client(AddTwoInts, "add", callback_group=group)

    def relay(request: Any, response: Any) -> Any:
        client.wait_for_service(timeout_sec=PATIENCE_S)
        log("relay", request.a)
        response.sum = 2 * client.call(request).sum
        return response

    node.create_service(AddTwoInts, "twice", relay, callback_group=group)
    return node


def asking_the_relay(log: Log) -> None:
    rclpy.init()
    node = Node("asker")
    client = node.create_client(AddTwoInts, "twice")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    log("sum", answered(node, client.call_async(AddTwoInts.Request(a=20, b=1))).sum)


def fibonacci(log: Log) -> Node:
    node, group = Node("fibonacci"), ReentrantCallbackGroup()

    def execute(goal: Any) -> Any:
        sequence = [0, 1]
        for _ in range(goal.request.order):
            if goal.is_cancel_requested:
                goal.canceled()
                log("canceled", len(sequence) >= 2)
                return Fibonacci.Result(sequence=sequence)
            sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=sequence))
            time.sleep(0.1)
        goal.succeed()
        return Fibonacci.Result(sequence=sequence)

    def accept(request: Any) -> Any:
        log("goal", request.order)
        return GoalResponse.ACCEPT if request.order >= 0 else GoalResponse.REJECT

    node.server = ActionServer(  # type: ignore[attr-defined]
        node,
        Fibonacci,
        "fibonacci",
        execute_callback=execute,
        goal_callback=accept,
        cancel_callback=lambda goal: CancelResponse.ACCEPT,
        callback_group=group,
    )
    return node


def calling(order: int, *, cancels: bool = False) -> Main:
    """Calls the action."""

    def main(log: Log) -> None:
        rclpy.init()
        node, heard = Node("caller"), []
        client = ActionClient(node, Fibonacci, "fibonacci")
        log("server", client.wait_for_server(timeout_sec=PATIENCE_S))
        sent = client.send_goal_async(
            Fibonacci.Goal(order=order), feedback_callback=lambda each: heard.append(list(each.feedback.sequence))
        )
        goal = answered(node, sent)
        log("accepted", goal.accepted)
        if not goal.accepted:
            return
        if cancels:
            until(node, lambda: len(heard) > 0)
            log("cancelling", len(answered(node, goal.cancel_goal_async()).goals_canceling))
        result = answered(node, goal.get_result_async())
        log("status", result.status)
        if not cancels:
            log("result", list(result.result.sequence))
            log("feedback", heard)

    return main


def configurable(log: Log) -> Node:
    node = Node("configurable")
    node.declare_parameter("speed", 0.5)

    def check(parameters: list[Parameter]) -> SetParametersResult:
        log("set", [[each.name, each.value] for each in parameters])
        return SetParametersResult(successful=all(each.value <= 1.0 for each in parameters), reason="too fast")

    node.add_on_set_parameters_callback(check)
    return node


def configuring(log: Log) -> None:
    rclpy.init()
    node = Node("configuring")
    client = AsyncParameterClient(node, "configurable")
    client.wait_for_services(PATIENCE_S)
    log("before", answered(node, client.get_parameters(["speed"])).values[0].double_value)
    for speed in (0.75, 2.0):
        found = answered(node, client.set_parameters([Parameter("speed", value=speed)])).results[0]
        log("set", [found.successful, found.reason])
    log("after", answered(node, client.get_parameters(["speed"])).values[0].double_value)


class Managed(LifecycleNode):
    """Logs its transitions; it cannot be activated the first time."""

    def __init__(self, log: Log) -> None:
        super().__init__("managed")
        self._log, self._tries = log, 0

    def on_configure(self, state: Any) -> Any:
        self._log("transition", ["configure", state.label])
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> Any:
        self._tries += 1
        self._log("transition", ["activate", state.label])
        return TransitionCallbackReturn.SUCCESS if self._tries > 1 else TransitionCallbackReturn.FAILURE


def managing(log: Log) -> None:
    rclpy.init()
    node = Node("manager")
    change, state = (
        node.create_client(ChangeState, "managed/change_state"),
        node.create_client(GetState, "managed/get_state"),
    )
    change.wait_for_service(timeout_sec=PATIENCE_S)
    state.wait_for_service(timeout_sec=PATIENCE_S)
    first, second = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE
    # None that its state does not have: with jazzy the node fails, later ones refuse.
    for transition in (first, second, second, Transition.TRANSITION_DEACTIVATE):
        request = ChangeState.Request(transition=Transition(id=transition))
        log("done", answered(node, change.call_async(request)).success)
        log("state", answered(node, state.call_async(GetState.Request())).current_state.label)


def waiting(log: Log) -> None:
    rclpy.init()
    node = Node("waiting")
    found, message = wait_for_message(Int32, node, "numbers", qos_profile=LATCHED, time_to_wait=PATIENCE_S)
    log("found", [found, message.data >= 2])
    log("nothing", wait_for_message(Int32, node, "silence", time_to_wait=0.3)[0])


def ticking(log: Log) -> None:
    """Two timers of one node, the second of which ends the first."""
    rclpy.init()
    node, ticks = Node("ticking"), []
    fast = node.create_timer(0.2, lambda: ticks.append("fast"))
    slow = node.create_timer(0.5, lambda: (ticks.append("slow"), fast.cancel()))
    until(node, lambda: ticks.count("slow") == 2)
    log("ticks", ticks)
    log("canceled", [fast.is_canceled(), slow.is_canceled()])


def logging_(log: Log) -> None:
    rclpy.init()
    node = Node("logging")
    node.get_logger().info("first")
    node.get_logger().debug("not seen")
    node.get_logger().get_child("arm").warning("second")
    heard = node.create_publisher(Int32, "logged", 10)
    until(node, lambda: heard.get_subscription_count() > 0)


def hearing_logs(log: Log) -> None:
    from rcl_interfaces.msg import Log as LogMessage

    rclpy.init()
    node, lines = Node("hearing"), []
    profile = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)

    def hear(message: Any) -> None:
        if message.name.startswith("logging"):
            lines.append([message.name, message.level, message.msg])

    node.create_subscription(LogMessage, "/rosout", hear, profile)
    until(node, lambda: len(lines) == 2)
    log("lines", sorted(lines))
    node.create_subscription(Int32, "logged", lambda message: None, 10)
    until(node, lambda: node.count_publishers("logged") == 0)


SYSTEMS = {
    "topic": System({"talker": publishing(20, 50), "listener": listening("listener", 20, 50)}, {}),
    "two listeners": System(
        {
            "talker": publishing(10, 50, listeners=2),
            "left": listening("left", 10, 50),
            "right": listening("right", 10, 50),
        },
        {},
    ),
    "late listener": System({"listener": late}, {"talker": serving(latching)}),
    "incompatible": System({"listener": demanding}, {"talker": serving(unreliable)}),
    "service": System({"asker": asking}, {"adder": serving(adding)}),
    "requests in a row": System({"asker": asking_in_a_row}, {"adder": serving(adding)}),
    "nested services": System(
        {"asker": asking_the_relay}, {"adder": serving(adding), "relay": serving(relaying, threads=4)}
    ),
    "action": System({"caller": calling(5)}, {"server": serving(fibonacci, threads=4)}),
    "cancelled action": System({"caller": calling(100, cancels=True)}, {"server": serving(fibonacci, threads=4)}),
    "rejected action": System({"caller": calling(-1)}, {"server": serving(fibonacci, threads=4)}),
    "parameters": System({"configuring": configuring}, {"configurable": serving(configurable)}),
    "managed node": System({"manager": managing}, {"managed": serving(Managed)}),
    "wait for message": System({"waiting": waiting}, {"talker": serving(latching)}),
    "timers": System({"ticking": ticking}, {}),
    "logs": System({"logging": logging_, "hearing": hearing_logs}, {}),
}
