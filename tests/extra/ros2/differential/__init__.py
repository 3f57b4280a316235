"""Small systems of `rclpy` that run on a real middleware and in virtual time, and have to log the same in both."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.extra.ros2.differential.common import System

NAMES = {
    "topics": (
        *("topic", "two listeners", "messages of all kinds", "late listener"),
        *("late volatile listener", "wait for message", "keep last", "keep all", "best effort"),
        *("coming and going", "names"),
    ),
    "qos": (
        *("incompatible", "incompatible reliability", "incompatible durability"),
        *("incompatible deadline", "incompatible liveliness", "matched events", "deadline"),
        *("lifespan",),
    ),
    "services": (
        *("service", "requests in a row", "nested services", "services as coroutines"),
        *("late answers", "call with a time-out", "error in a service", "no response"),
        *("introspection", "calls in callbacks"),
    ),
    "actions": (
        *("action", "cancelled action", "rejected action", "aborted goals", "refused cancellation"),
        *("all goals cancelled", "deferred goals", "identifiers and kept results"),
        *("actions as coroutines", "blocking goal"),
    ),
    "parameters": (
        *("parameters", "services of parameters", "callbacks of parameters"),
        *("parameters from arguments",),
    ),
    "managed": (*("managed node", "errors of a managed node", "transitions", "lifecycle publisher"),),
    "timing": (
        *("timers", "timers that are changed", "calls of timers", "rates", "simulated time"),
        *("sleep in simulated time",),
    ),
    "executors": (
        *("errors in callbacks", "order of callbacks", "one thread", "threads, one exclusive group"),
        *("threads, two exclusive groups", "threads, a reentrant group", "time-outs", "tasks"),
        *("coroutines", "asyncio"),
    ),
    "contexts": (*("the end of a context", "the end from outside", "logs"),),
    "graph": (*("graph", "wait for nodes"),),
}
"""Module -> its systems: their names are known without `rclpy`."""


def system(name: str) -> System:
    """The system with this name; imports `rclpy`."""
    module = next(module for module, names in NAMES.items() if name in names)
    systems = import_module(f"{__name__}.{module}").SYSTEMS
    assert tuple(systems) == NAMES[module]
    return systems[name]  # type: ignore[no-any-return]
