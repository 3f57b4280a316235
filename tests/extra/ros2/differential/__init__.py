"""Small systems of `rclpy` that run on a real middleware and in virtual time, and have to log the same in both."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.extra.ros2.differential.common import System

NAMES = {
    "topics": (
        *("topic", "two listeners", "messages of all kinds", "late listener", "late volatile listener"),
        *("wait for message", "keep last", "keep all", "best effort", "raw messages", "about messages"),
        *("coming and going", "names", "wrong names"),
    ),
    "qos": (
        *("incompatible", "incompatible reliability", "incompatible durability", "incompatible deadline"),
        *("incompatible liveliness", "all profiles", "matched events", "deadline", "liveliness", "lifespan"),
        *("overridden profile", "two types"),
    ),
    "services": (
        *("service", "requests in a row", "nested services", "services as coroutines", "late answers"),
        *("call with a time-out", "error in a service", "no response", "services come and go"),
        *("two clients", "futures", "introspection", "calls in callbacks"),
    ),
    "actions": (
        *("action", "cancelled action", "rejected action", "aborted goals", "refused cancellation"),
        *("all goals cancelled", "deferred goals", "goals that replace others", "two goals at a time"),
        *("identifiers and kept results", "states of goals", "actions as coroutines", "blocking goal"),
        *("action servers come and go",),
    ),
    "parameters": (
        *("parameters", "services of parameters", "callbacks of parameters", "descriptors of parameters"),
        *("parameters from arguments", "events of parameters"),
    ),
    "managed": (*("managed node", "errors of a managed node", "transitions", "lifecycle publisher"),),
    "timing": (
        *("timers", "timers that are changed", "calls of timers", "slow callbacks", "rates"),
        *("times and clocks", "simulated time", "sleep in simulated time"),
    ),
    "executors": (
        *("errors in callbacks", "errors in threads", "order of callbacks", "one thread"),
        *("threads, one exclusive group", "threads, two exclusive groups", "threads, a reentrant group"),
        *("one by one", "time-outs", "tasks", "coroutines", "guard conditions", "nodes of executors"),
        *("executors in threads", "asyncio", "futures in asyncio"),
    ),
    "contexts": (*("several contexts", "the end of a context", "before and after", "the end from outside", "logs"),),
    "graph": (*("graph", "wait for nodes"),),
}
"""Module -> its systems: their names are known without `rclpy`."""


def system(name: str) -> System:
    """The system with this name; imports `rclpy`."""
    module = next(module for module, names in NAMES.items() if name in names)
    systems = import_module(f"{__name__}.{module}").SYSTEMS
    assert tuple(systems) == NAMES[module]
    return systems[name]  # type: ignore[no-any-return]
