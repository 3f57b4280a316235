"""`rclpy.experimental.EventsExecutor` in virtual time, with the real `rclpy` where there is one that has it."""

from __future__ import annotations

import importlib
import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.runtime import Kernel, NodeError
from pytest_hricdv.runtime.virtual.outside import guard_run


def _has_it() -> bool:
    """Whether there is one; found without importing `rclpy`, whose real extension would be loaded."""
    spec = find_spec("rclpy")
    folders = [] if spec is None else spec.submodule_search_locations or []
    return any(Path(folder, "experimental").is_dir() for folder in folders)


pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),  # of rclpy itself
    pytest.mark.skipif(not _has_it(), reason="needs rclpy of kilted"),
]

_CODE = """
import threading, time
import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger
from test_msgs.action import Fibonacci

log = []


def executor_of(*names):
    rclpy.init()
    executor, nodes = EventsExecutor(), [Node(name) for name in names]
    for node in nodes:
        executor.add_node(node)
    return executor, *nodes


def order():
    # Of one node the first of its subscriptions would be first; here it is what came first.
    executor, node = executor_of("a")
    for topic in ("first", "second"):
        node.create_subscription(String, topic, lambda m, topic=topic: log.append(topic + m.data), 10)
    publishers = {topic: node.create_publisher(String, topic, 10) for topic in ("first", "second")}
    for topic, text in (("second", "1"), ("first", "2"), ("second", "3")):
        publishers[topic].publish(String(data=text))
    node.create_timer(0.5, lambda: log.append("timer"))
    executor.spin_until_future_complete(Future(), 0.6)
    log.append(round(time.monotonic(), 3))


def coroutine():
    # The response waits for a timer of the same group: the events executor asks no groups.
    executor, server, client = executor_of("server", "client")
    group = MutuallyExclusiveCallbackGroup()
    async def answer(request, response):
        done = Future()
        timer = server.create_timer(1.0, lambda: done.set_result(None), callback_group=group)
        await done
        timer.cancel()
        response.message = "waited"
        return response
    server.create_service(Trigger, "ask", answer, callback_group=group)
    future = client.create_client(Trigger, "ask").call_async(Trigger.Request())
    executor.spin_until_future_complete(future, 10.0)
    log.extend([future.result().message, round(time.monotonic(), 1)])


def action():
    executor, server, client = executor_of("server", "client")
    def execute(goal):
        goal.publish_feedback(Fibonacci.Feedback(sequence=[0, 1]))
        goal.succeed()
        return Fibonacci.Result(sequence=[0, 1, 1])
    ActionServer(server, Fibonacci, "count", execute)
    actions = ActionClient(client, Fibonacci, "count")
    actions.wait_for_server()
    sent = actions.send_goal_async(
        Fibonacci.Goal(order=2), feedback_callback=lambda m: log.append(list(m.feedback.sequence))
    )
    executor.spin_until_future_complete(sent, 1.0)
    result = sent.result().get_result_async()
    executor.spin_until_future_complete(result, 1.0)
    log.append(list(result.result().result.sequence))


def timers():
    # Each cancels the other: only one is called.
    executor, node = executor_of("a")
    made = []
    def call():
        log.append("called")
        for timer in made:
            timer.cancel()
    made.extend(node.create_timer(0.1, call) for _ in range(2))
    executor.spin_until_future_complete(Future(), 1.0)


def shutdown():
    executor, node = executor_of("a")
    node.create_timer(1.0, rclpy.shutdown)
    executor.spin()
    log.append(time.monotonic())


def once():
    executor, node = executor_of("a")
    node.create_timer(0.1, lambda: log.append(round(time.monotonic(), 1)))
    for _ in range(2):
        executor.spin_once()
    executor.spin_once(timeout_sec=0.05)
    log.append(round(time.monotonic(), 2))


def tasks():
    executor, node = executor_of("a")
    waited = executor.create_future()
    async def work():
        return await waited
    task = executor.create_task(work)
    threading.Timer(2.0, waited.set_result, args=("from another thread",)).start()
    executor.spin_until_future_complete(task, 10.0)
    log.extend([task.result(), round(time.monotonic(), 1)])


def twice():
    executor, node = executor_of("a")
    node.create_timer(0.1, executor.spin_once)
    executor.spin()


def guarded():
    executor, node = executor_of("a")
    node.create_guard_condition(lambda: None)
    executor.spin_once()


def failing():
    executor, node = executor_of("a")
    node.create_timer(0.1, lambda: 1 / 0)
    executor.spin()
"""


@pytest.fixture(scope="module")
def code(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    from pytest_hricdv.extra.ros2.overlay import virtual_rclpy

    folder = tmp_path_factory.mktemp("code")
    Path(folder, "events_executed.py").write_text(_CODE)
    sys.path.insert(0, str(folder))
    try:
        with virtual_rclpy("events_executed"):
            return importlib.import_module("events_executed")
    finally:
        sys.path.remove(str(folder))


def _run(code: ModuleType, name: str) -> list[object]:
    from pytest_hricdv.extra.ros2.overlay import virtual_rclpy

    code.log.clear()
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading", "asyncio"})

    def body() -> None:
        try:
            getattr(code, name)()
        finally:
            code.rclpy.try_shutdown()

    with virtual_rclpy("events_executed"):
        kernel.spawn(name, body)
        try:
            with guard_run(kernel):
                assert kernel.run(100.0) == "idle"
        finally:
            kernel.close()
    return list(code.log)


@pytest.mark.parametrize(
    ("name", "log"),
    [
        ("order", ["second1", "first2", "second3", "timer", 0.6]),
        ("coroutine", ["waited", 1.0]),
        ("action", [[0, 1], [0, 1, 1]]),
        ("timers", ["called"]),
        ("shutdown", [1.0]),
        ("once", [0.1, 0.2, 0.25]),
        ("tasks", ["from another thread", 2.0]),
    ],
)
def test_callbacks_are_called_in_the_order_of_events(name: str, log: list[object], code: ModuleType) -> None:
    assert _run(code, name) == log


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("twice", "Attempt to spin an already-spinning Executor"),
        ("guarded", "Guard conditions not supported"),
        ("failing", "division by zero"),
    ],
)
def test_what_it_refuses_and_what_fails_is_raised(name: str, problem: str, code: ModuleType) -> None:
    with pytest.raises(NodeError, match=problem):
        _run(code, name)
