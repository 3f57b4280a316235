"""Services: answers, several clients, time-outs, errors, services that come and go."""

from __future__ import annotations

import threading
from typing import Any

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from test_msgs.srv import BasicTypes

from tests.extra.ros2.differential.common import (
    PATIENCE_S,
    Log,
    System,
    alone,
    answered,
    elapse,
    raised,
    serving,
    together,
    until,
)


def _add(request: Any, response: Any) -> Any:
    response.int64_value = request.int32_value + request.int64_value
    return response


def _numbers(left: int, right: int) -> Any:
    return BasicTypes.Request(int32_value=left, int64_value=right)


def adding(log: Log) -> Node:
    node = Node("adder")

    def add(request: Any, response: Any) -> Any:
        log("add", [request.int32_value, request.int64_value])
        return _add(request, response)

    node.create_service(BasicTypes, "add", add)
    return node


def asking(log: Log) -> None:
    rclpy.init()
    node = Node("asker")
    client = node.create_client(BasicTypes, "add")
    log("server", client.wait_for_service(timeout_sec=PATIENCE_S))
    for number in range(3):
        log("sum", answered(node, client.call_async(_numbers(number, 40))).int64_value)
    log("no server", node.create_client(BasicTypes, "subtract").wait_for_service(timeout_sec=0.3))
    log("ready", [client.service_is_ready(), client.service_name])
    log("wrong request", raised(lambda: client.call_async(BasicTypes.Response())))


def asking_in_a_row(log: Log) -> None:
    """All requests are sent before the first answer is looked at."""
    rclpy.init()
    node = Node("asker")
    client = node.create_client(BasicTypes, "add")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    futures = [client.call_async(_numbers(number, 1)) for number in range(5)]
    log("sums", [answered(node, future).int64_value for future in futures])


def relaying(log: Log) -> Node:
    """A service whose callback asks another service, and waits: it needs a reentrant group and threads."""
    node, group = Node("relay"), ReentrantCallbackGroup()
    client = node.create_client(BasicTypes, "add", callback_group=group)

    def relay(request: Any, response: Any) -> Any:
        client.wait_for_service(timeout_sec=PATIENCE_S)
        log("relay", request.int32_value)
        response.int64_value = 2 * client.call(request).int64_value
        return response

    node.create_service(BasicTypes, "twice", relay, callback_group=group)
    return node


def relaying_as_coroutine(log: Log) -> Node:
    """The same, with one thread: the callback awaits the answer."""
    node, group = Node("relay"), ReentrantCallbackGroup()
    client = node.create_client(BasicTypes, "add", callback_group=group)

    async def relay(request: Any, response: Any) -> Any:
        client.wait_for_service(timeout_sec=PATIENCE_S)
        log("relay", request.int32_value)
        answer = await client.call_async(request)
        response.int64_value = 2 * answer.int64_value
        return response

    node.create_service(BasicTypes, "twice", relay, callback_group=group)
    return node


def asking_the_relay(log: Log) -> None:
    rclpy.init()
    node = Node("asker")
    client = node.create_client(BasicTypes, "twice")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    # One after the other: two at a time come in any order where threads take them.
    log("sums", [answered(node, client.call_async(_numbers(number, 1))).int64_value for number in (20, 30)])


def silent(log: Log) -> None:
    """Nobody spins the server: clients that wait give up, forget their request, and the answer comes too late."""
    rclpy.init()
    server, asker = Node("server"), Node("asker")
    server.create_service(BasicTypes, "add", _add)
    client = asker.create_client(BasicTypes, "add")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    first, second = client.call_async(_numbers(1, 1)), client.call_async(_numbers(2, 2))
    rclpy.spin_until_future_complete(asker, first, timeout_sec=0.2)
    log("in time", first.done())
    client.remove_pending_request(first)
    spun = together(server, asker)
    log("second", answered(spun, second).int64_value)
    elapse(spun, 0.1)
    log("first", [first.done(), first.cancelled()])


def calling_with_time_out(log: Log) -> None:
    """`call` in a thread that does not spin, with and without a time-out that is too short."""
    rclpy.init()
    server, asker = Node("server"), Node("asker")
    server.create_service(BasicTypes, "add", _add)
    client = asker.create_client(BasicTypes, "add")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    of_asker = together(asker)
    thread = threading.Thread(target=of_asker.spin)
    thread.start()
    log("too short", raised(lambda: client.call(_numbers(1, 2), timeout_sec=0.2)))
    of_server = together(server)
    other = threading.Thread(target=of_server.spin)
    other.start()
    log("long", client.call(_numbers(3, 4), timeout_sec=PATIENCE_S).int64_value)
    log("for ever", client.call(_numbers(5, 6)).int64_value)
    of_asker.shutdown()
    of_server.shutdown()
    thread.join()
    other.join()
    log("in vain", raised(lambda: client.call(_numbers(7, 8), timeout_sec=0.1)))


def failing(log: Log) -> None:
    """A callback that raises: the server's executor does, too, and the client gets no answer to this request."""
    rclpy.init()
    server, asker = Node("server"), Node("asker")

    def check(request: Any, response: Any) -> Any:
        if request.int32_value < 0:
            raise ValueError("negative")
        return _add(request, response)

    server.create_service(BasicTypes, "add", check)
    client = asker.create_client(BasicTypes, "add")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    spun = together(server, asker)
    wrong = client.call_async(_numbers(-1, 0))
    log("raised", raised(lambda: until(spun, wrong.done)))
    log("answered", answered(spun, client.call_async(_numbers(1, 2))).int64_value)
    log("wrong one", wrong.done())


def forgetting(log: Log) -> None:
    """Callbacks that return nothing, or what is no response."""
    rclpy.init()
    server, asker = Node("server"), Node("asker")
    clients = []
    for name, returned in (("nothing", None), ("number", 3)):
        server.create_service(BasicTypes, name, lambda request, response, returned=returned: returned)
        clients.append((name, asker.create_client(BasicTypes, name)))
    spun = together(server, asker)
    for name, client in clients:
        client.wait_for_service(timeout_sec=PATIENCE_S)
        future = client.call_async(_numbers(1, 2))
        log(name, raised(lambda future=future: until(spun, future.done, 0.5)))
        log(name, future.done())


def introspected(log: Log) -> None:
    """What is published about requests and responses."""
    rclpy.init()
    server = Node("server")
    asker = Node("asker")
    heard: list[Any] = []
    service = server.create_service(BasicTypes, "add", _add)
    client = asker.create_client(BasicTypes, "add")
    asker.create_subscription(BasicTypes.Event, "add/_service_event", heard.append, 10)
    spun = together(server, asker)
    client.wait_for_service(timeout_sec=PATIENCE_S)
    for node, endpoint, state in (
        (server, service, ServiceIntrospectionState.METADATA),
        (asker, client, ServiceIntrospectionState.CONTENTS),
    ):
        endpoint.configure_introspection(node.get_clock(), qos_profile_system_default, state)
    until(spun, lambda: asker.count_publishers("add/_service_event") == 2)
    elapse(spun, 0.3)
    answered(spun, client.call_async(_numbers(1, 2)))
    until(spun, lambda: len(heard) == 4)
    for event in sorted(heard, key=lambda each: each.info.event_type):
        sums = [response.int64_value for response in event.response]
        log("events", [event.info.event_type, event.info.sequence_number, len(event.request), sums])
    service.configure_introspection(server.get_clock(), qos_profile_system_default, ServiceIntrospectionState.OFF)
    client.configure_introspection(asker.get_clock(), qos_profile_system_default, ServiceIntrospectionState.OFF)
    answered(spun, client.call_async(_numbers(1, 2)))
    elapse(spun, 0.2)
    log("after it was switched off", len(heard))


def exclusive(log: Log) -> None:
    """A callback that waits for an answer which its own executor would have to take, with two kinds of groups."""
    rclpy.init()
    for name, group in (("own group", None), ("reentrant", ReentrantCallbackGroup())):
        server = Node("server")
        server.create_service(BasicTypes, "add", _add, callback_group=group)
        client = server.create_client(BasicTypes, "add", callback_group=group)
        client.wait_for_service(timeout_sec=PATIENCE_S)
        results: list[str] = []

        def call(client: Any = client, results: list[str] = results) -> None:
            if not results:
                results.append("")
                results[0] = raised(lambda: client.call(_numbers(1, 2), timeout_sec=0.3)) or "answered"
                results.append("over")

        server.create_timer(0.05, call, callback_group=group)
        executor: SingleThreadedExecutor | MultiThreadedExecutor = MultiThreadedExecutor(num_threads=4)
        executor.add_node(server)
        until(executor, lambda results=results: len(results) == 2)
        log(name, results[0])
        executor.shutdown()
        server.destroy_node()


SYSTEMS = {
    "service": System({"asker": asking}, {"adder": serving(adding)}),
    "requests in a row": System({"asker": asking_in_a_row}, {"adder": serving(adding)}),
    "nested services": System(
        {"asker": asking_the_relay}, {"adder": serving(adding), "relay": serving(relaying, threads=4)}
    ),
    "services as coroutines": System(
        {"asker": asking_the_relay}, {"adder": serving(adding), "relay": serving(relaying_as_coroutine)}
    ),
    "late answers": alone(silent),
    "call with a time-out": alone(calling_with_time_out),
    "error in a service": alone(failing),
    "no response": alone(forgetting),
    "introspection": alone(introspected),
    "calls in callbacks": alone(exclusive),
}
