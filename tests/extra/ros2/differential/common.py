"""What the systems have in common: how they wait, and how a server is spun."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node

Log = Callable[[str, object], None]
Main = Callable[[Log], None]

PATIENCE_S = 20.0


@dataclass(frozen=True)
class System:
    """Some processes: those that end by themselves, and servers, which are ended when the others are over."""

    ending: Mapping[str, Main]
    servers: Mapping[str, Main] = field(default_factory=dict)


def alone(main: Main) -> System:
    """A system of one process, which may have several nodes."""
    return System({"process": main})


def until(spun: Node | Executor, condition: Callable[[], bool], patience_s: float = PATIENCE_S) -> bool:
    """Spin a node or an executor until something holds; whether it does."""
    end_s = time.monotonic() + patience_s
    while not condition() and time.monotonic() < end_s:
        if isinstance(spun, Executor):
            spun.spin_once(timeout_sec=0.05)
        else:
            rclpy.spin_once(spun, timeout_sec=0.05)
    return condition()


def elapse(spun: Node | Executor, duration_s: float) -> None:
    """Spin for some time: where something is not to happen, there is no event to wait for."""
    end_s = time.monotonic() + duration_s
    until(spun, lambda: time.monotonic() > end_s)


def answered(spun: Node | Executor, future: Any) -> Any:
    """Spin until a future is done; its result."""
    if isinstance(spun, Executor):
        spun.spin_until_future_complete(future, timeout_sec=PATIENCE_S)
    else:
        rclpy.spin_until_future_complete(spun, future, timeout_sec=PATIENCE_S)
    return future.result()


def raised(action: Callable[[], object]) -> str:
    """The class of what a call raises; empty if it raises nothing."""
    try:
        action()
    except Exception as error:
        return type(error).__name__
    return ""


def together(*nodes: Node) -> SingleThreadedExecutor:
    """An executor with these nodes."""
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    return executor


def serving(make: Callable[[Log], Node], threads: int = 1) -> Main:
    """The main function of a server: its node is spun until the process is ended."""

    def main(log: Log) -> None:
        rclpy.init()
        executor = MultiThreadedExecutor(num_threads=threads) if threads > 1 else SingleThreadedExecutor()
        executor.add_node(make(log))
        with suppress(KeyboardInterrupt, ExternalShutdownException):
            executor.spin()

    return main
