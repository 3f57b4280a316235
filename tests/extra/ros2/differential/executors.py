"""Executors: orders, groups, threads, tasks, guard conditions, time-outs, errors in callbacks."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import Any

import rclpy
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Int32
from test_msgs.srv import BasicTypes

from tests.extra.ros2.differential.common import PATIENCE_S, Log, Main, alone, elapse, raised, together, until


def _fail(where: str, done: list[str]) -> Any:
    done.append(where)
    raise ValueError(where)


def raising(log: Log) -> None:
    """Errors in callbacks of each kind come out of `spin_once`, which can go on afterwards."""
    rclpy.init()
    node = Node("node")
    done: list[Any] = []
    publisher = node.create_publisher(Int32, "numbers", 10)
    executor = together(node)
    guard = node.create_guard_condition(lambda: _fail("guard", done))
    node.create_subscription(Int32, "numbers", lambda each: _fail("subscription", done), 10)
    node.create_service(BasicTypes, "service", lambda request, response: _fail("service", done))
    client = node.create_client(BasicTypes, "service")
    client.wait_for_service(timeout_sec=PATIENCE_S)
    until(executor, lambda: publisher.get_subscription_count() == 1)
    timer = node.create_timer(0.02, lambda: _fail("timer", done), autostart=False)
    for cause in (
        lambda: publisher.publish(Int32()),
        guard.trigger,
        lambda: client.call_async(BasicTypes.Request()),
        timer.reset,
        lambda: executor.create_task(lambda: _fail("task", done)),
        lambda: executor.create_task(_coroutine(done)),
    ):
        cause()
        log("errors", _error_of(executor, done))
        timer.cancel()


async def _coroutine(done: list[str]) -> None:
    _fail("coroutine", done)


def _error_of(executor: Executor, done: list[str]) -> list[str]:
    """What spinning raises until one more callback was called."""
    before = len(done)
    try:
        until(executor, lambda: len(done) > before)
    except ValueError as error:
        return [done[-1], str(error)]
    return [done[-1], ""]


def in_order(log: Log) -> None:
    """What is ready at a time is called one by one: timers, then subscriptions, guards, clients, services, events."""
    rclpy.init()
    node, calls = Node("node"), []
    publisher = node.create_publisher(Int32, "numbers", 10)

    def serve(request: Any, response: Any) -> Any:
        calls.append("service")
        return response

    node.create_service(BasicTypes, "service", serve)
    client = node.create_client(BasicTypes, "service")
    guard = node.create_guard_condition(lambda: calls.append("guard"))
    for name in ("first", "second"):
        node.create_subscription(Int32, "numbers", lambda each, name=name: calls.append(f"{name} {each.data}"), 10)
    client.wait_for_service(timeout_sec=PATIENCE_S)
    executor = together(node)
    until(executor, lambda: publisher.get_subscription_count() == 2)
    elapse(executor, 0.1)

    def once() -> None:
        calls.append("timer")
        timer.cancel()

    timer = node.create_timer(0.05, once)
    client.call_async(BasicTypes.Request()).add_done_callback(lambda done: calls.append("response"))
    for number in range(2):
        publisher.publish(Int32(data=number))
    publisher.wait_for_all_acked(Duration(seconds=PATIENCE_S))
    guard.trigger()
    guard.trigger()
    time.sleep(0.2)
    for _ in range(3):
        executor.spin_once(timeout_sec=PATIENCE_S)
        log("after a call", list(calls))
    until(executor, lambda: len(calls) == 8)
    log("calls", calls)


def concurrent(kind: type[CallbackGroup] | None, threads: int) -> Main:
    """Two timers whose callbacks wait for each other: whether they run at the same time."""

    def main(log: Log) -> None:
        rclpy.init()
        node = Node("node")
        groups = [None, None] if kind is None else [kind(), kind()]
        if kind is ReentrantCallbackGroup:
            groups[1] = groups[0]
        here = [threading.Event(), threading.Event()]
        met: dict[int, bool] = {}

        def meet(own: int) -> None:
            if own not in met:
                here[own].set()
                met[own] = here[1 - own].wait(0.4)

        for number, group in enumerate(groups):
            node.create_timer(0.05, lambda number=number: meet(number), callback_group=group)
        executor = MultiThreadedExecutor(num_threads=threads) if threads > 1 else SingleThreadedExecutor()
        executor.add_node(node)
        until(executor, lambda: len(met) == 2)
        log("met", [sorted(met.values())])
        executor.shutdown()

    return main


def waiting(log: Log) -> None:
    """`spin_until_future_complete` and its like, with time-outs that are over or not."""
    rclpy.init()
    node = Node("node")
    executor = together(node)
    for timeout_s in (0.05, 0.0, 1e-9):
        future: Future = Future()
        executor.spin_until_future_complete(future, timeout_sec=timeout_s)
        log("not done", [timeout_s, future.done()])
    for limit_s in (None, PATIENCE_S, -1.0):
        future = Future()
        timer = node.create_timer(0.05, lambda future=future: future.set_result("result"))
        executor.spin_until_future_complete(future, timeout_sec=limit_s)
        log("done", [limit_s, future.result()])
        node.destroy_timer(timer)
    done: Future = Future()
    done.set_result(1)
    executor.spin_until_future_complete(done)
    executor.spin_once_until_future_complete(done, timeout_sec=0.1)
    log("done before", done.result())
    for _ in range(3):
        rclpy.spin_until_future_complete(node, Future(), timeout_sec=0.05)
    log("three times", True)


def tasks(log: Log) -> None:
    """Tasks: functions and coroutines, results, errors, and futures that they await."""
    rclpy.init()
    node, order = Node("node"), []
    executor = together(node)
    future: Future = Future()

    async def await_it(name: str) -> str:
        order.append(f"{name} begins")
        value = await future
        order.append(f"{name} ends")
        return f"{name} {value}"

    made = [executor.create_task(await_it, "first"), executor.create_task(await_it, name="second")]
    plain = executor.create_task(lambda left, right: left + right, 1, right=2)
    node.create_timer(0.05, lambda: future.done() or future.set_result("over"))
    for task in (*made, plain):
        executor.spin_until_future_complete(task, timeout_sec=PATIENCE_S)
        log("result", task.result())
    log("order", order)
    wrong = executor.create_task(_coroutine([]))
    log("raised", raised(lambda: executor.spin_until_future_complete(wrong, timeout_sec=PATIENCE_S)))
    log("exception", [wrong.done(), type(wrong.exception()).__name__])
    cancelled = executor.create_task(await_it, "third")
    cancelled.cancel()
    elapse(executor, 0.1)
    log("cancelled", [cancelled.cancelled(), cancelled.done()])


def coroutines(log: Log) -> None:
    """Callbacks that are coroutines: while one waits, its group is taken or not."""
    rclpy.init()
    for name, group in (("exclusive", MutuallyExclusiveCallbackGroup()), ("reentrant", ReentrantCallbackGroup())):
        node = Node("node")
        order: list[Any] = []
        future: Future = Future()

        async def first(future: Any = future, order: Any = order) -> None:
            if "first begins" not in order:
                order.append("first begins")
                await future
                order.append("first ends")

        def second(order: Any = order) -> None:
            if "second" not in order:
                order.append("second")

        node.create_timer(0.05, first, callback_group=group)
        node.create_timer(0.1, second, callback_group=group)
        other = MutuallyExclusiveCallbackGroup()
        node.create_timer(0.3, lambda future=future: future.done() or future.set_result(1), callback_group=other)
        executor = together(node)
        until(executor, lambda order=order: len(order) == 3)
        log(name, order)
        executor.shutdown()
        node.destroy_node()


def with_asyncio(log: Log) -> None:
    """`asyncio` beside an executor that is spun in it bit by bit."""
    rclpy.init()
    node, heard = Node("node"), []
    publisher = node.create_publisher(Int32, "numbers", 10)
    node.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), 10)
    executor = together(node)

    async def spin() -> None:
        while len(heard) < 3:
            executor.spin_once(timeout_sec=0)
            await asyncio.sleep(0.01)

    async def talk() -> None:
        while publisher.get_subscription_count() == 0:
            await asyncio.sleep(0.01)
        for number in range(3):
            publisher.publish(Int32(data=number))
            await asyncio.sleep(0.02)

    async def both() -> None:
        await asyncio.wait_for(asyncio.gather(spin(), talk()), PATIENCE_S)

    asyncio.run(both())
    log("numbers", heard)


SYSTEMS = {
    "errors in callbacks": alone(raising),
    "order of callbacks": alone(in_order),
    "one thread": alone(concurrent(ReentrantCallbackGroup, 1)),
    "threads, one exclusive group": alone(concurrent(None, 4)),
    "threads, two exclusive groups": alone(concurrent(MutuallyExclusiveCallbackGroup, 4)),
    "threads, a reentrant group": alone(concurrent(ReentrantCallbackGroup, 4)),
    "time-outs": alone(waiting),
    "tasks": alone(tasks),
    "coroutines": alone(coroutines),
    "asyncio": alone(with_asyncio),
}
