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


def raising_in_threads(log: Log) -> None:
    """An error in a thread of an executor ends its `spin`."""
    rclpy.init()
    for kind in ("timer", "task"):
        node = Node("node")
        done: list[Any] = []
        executor = MultiThreadedExecutor(num_threads=2)
        executor.add_node(node)
        if kind == "timer":
            node.create_timer(0.02, lambda done=done: None if done else _fail("timer", done))
        else:
            executor.create_task(lambda done=done: _fail("task", done))
        node.create_timer(0.05, lambda: None)  # the error comes out when something else happens
        log("spin", [kind, raised(executor.spin), done])
        executor.shutdown()
        node.destroy_node()


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


def one_by_one(log: Log) -> None:
    """`spin_once` calls one callback; nothing to do ends it after its time-out."""
    rclpy.init()
    node, heard = Node("node"), []
    publisher = node.create_publisher(Int32, "numbers", 10)
    node.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), 10)
    executor = together(node)
    until(executor, lambda: publisher.get_subscription_count() == 1)
    elapse(executor, 0.1)
    for number in range(3):
        publisher.publish(Int32(data=number))
    publisher.wait_for_all_acked(Duration(seconds=PATIENCE_S))
    for _ in range(4):
        executor.spin_once(timeout_sec=0.1)
        log("heard", len(heard))
    for timeout_s in (0, 0.0, 1e-9, 0.1):
        start_s = time.monotonic()
        executor.spin_once(timeout_sec=timeout_s)
        log("time-out", timeout_s <= time.monotonic() - start_s + 0.02 < timeout_s + 5.0)


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


def guarded(log: Log) -> None:
    """Guard conditions: triggered twice they call once, also from another thread."""
    rclpy.init()
    node, calls = Node("node"), []
    guard = node.create_guard_condition(lambda: calls.append(1))
    executor = together(node)
    for _ in range(3):
        guard.trigger()
    until(executor, lambda: len(calls) > 0)
    elapse(executor, 0.1)
    log("calls", len(calls))
    thread = threading.Thread(target=guard.trigger)
    thread.start()
    until(executor, lambda: len(calls) == 2)
    thread.join()
    log("calls", len(calls))
    log("destroyed", node.destroy_guard_condition(guard))
    log("after the end", raised(guard.trigger))


def adding(log: Log) -> None:
    """Nodes are added to executors, taken away, and destroyed while they are in one."""
    rclpy.init()
    left, right, ticks = Node("left"), Node("right"), {"left": 0, "right": 0}

    def tick(name: str) -> None:
        ticks[name] += 1

    for name, node in (("left", left), ("right", right)):
        node.create_timer(0.02, lambda name=name: tick(name))
    executor, other = SingleThreadedExecutor(), SingleThreadedExecutor()
    log("added", [executor.add_node(left), executor.add_node(left), other.add_node(right), executor.add_node(right)])
    log("nodes", [sorted(node.get_name() for node in each.get_nodes()) for each in (executor, other)])
    until(executor, lambda: min(ticks.values()) > 1)
    log("executor", [left.executor is executor, right.executor is executor])
    executor.remove_node(left)
    log("removed", left.executor is None)
    ticks["left"] = 0
    elapse(executor, 0.1)
    log("ticks", ticks["left"])
    right.destroy_node()
    ticks["right"] = 0
    elapse(executor, 0.1)
    log("ticks", ticks["right"])
    log("shut down", [executor.shutdown(), raised(lambda: executor.spin_once(timeout_sec=0.0))])


def threaded(log: Log) -> None:
    """Executors in threads: a publisher in one, its listener in another; work for them from a third."""
    rclpy.init()
    talker, listener, heard = Node("talker"), Node("listener"), []
    publisher = talker.create_publisher(Int32, "numbers", 10)
    done = threading.Event()

    def hear(message: Any) -> None:
        heard.append(message.data)
        if len(heard) == 5:
            done.set()

    listener.create_subscription(Int32, "numbers", hear, 10)
    executors = [together(talker), together(listener)]
    threads = [threading.Thread(target=executor.spin) for executor in executors]
    for thread in threads:
        thread.start()
    while publisher.get_subscription_count() == 0:
        time.sleep(0.01)
    for number in range(3):
        publisher.publish(Int32(data=number))
    for number in (3, 4):
        executors[0].create_task(lambda number=number: publisher.publish(Int32(data=number)))
    log("in time", done.wait(PATIENCE_S))
    for executor in executors:
        executor.shutdown()
    for thread in threads:
        thread.join()
    log("numbers", heard)


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


def awaited_by_asyncio(log: Log) -> None:
    """Futures of `rclpy` that tasks of `asyncio` await: with a result, an error, too late; a task of an executor."""
    rclpy.init()
    node = Node("node")
    executor = together(node)
    late, failing = Future(), Future()
    node.create_timer(0.1, lambda: failing.done() or failing.set_exception(ValueError("no result")))

    async def inner() -> str:
        return str(await later)

    later = Future()
    node.create_timer(0.2, lambda: later.done() or later.set_result("later"))
    task = executor.create_task(inner)

    async def spin() -> None:
        while True:
            executor.spin_once(timeout_sec=0.01)
            await asyncio.sleep(0.001)

    async def talk() -> None:
        spinning = asyncio.ensure_future(spin())
        try:
            await failing
        except ValueError as error:
            log("error", str(error))
        log("results", await asyncio.gather(later, task))
        try:
            await asyncio.wait_for(late, 0.1)
        except TimeoutError:
            log("late", late.done())
        spinning.cancel()

    asyncio.run(asyncio.wait_for(talk(), PATIENCE_S))


SYSTEMS = {
    "errors in callbacks": alone(raising),
    "errors in threads": alone(raising_in_threads),
    "order of callbacks": alone(in_order),
    "one thread": alone(concurrent(ReentrantCallbackGroup, 1)),
    "threads, one exclusive group": alone(concurrent(None, 4)),
    "threads, two exclusive groups": alone(concurrent(MutuallyExclusiveCallbackGroup, 4)),
    "threads, a reentrant group": alone(concurrent(ReentrantCallbackGroup, 4)),
    "one by one": alone(one_by_one),
    "time-outs": alone(waiting),
    "tasks": alone(tasks),
    "coroutines": alone(coroutines),
    "guard conditions": alone(guarded),
    "nodes of executors": alone(adding),
    "executors in threads": alone(threaded),
    "asyncio": alone(with_asyncio),
    "futures in asyncio": alone(awaited_by_asyncio),
}
