"""Small ROS 2 systems for tests, on what stands for the extension itself: nothing of ROS has to be installed."""

from __future__ import annotations

import array
from collections.abc import Callable, Sequence
from typing import Any

from pytest_hricdv.extra.ros2 import contexts
from pytest_hricdv.extra.ros2.handles import Waitable
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual.outside import guard_run


class _Generated:
    """What the classes that `rosidl` generates of messages have in common."""

    __slots__: tuple[str, ...] = ()

    def __init__(self, **values: Any) -> None:
        for slot in self.__slots__:
            setattr(self, slot, values.get(slot.removeprefix("_")))

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return dict.fromkeys(cls.__slots__, "any")


class Point(_Generated):
    __slots__ = ("_x", "_y")


class Reading(_Generated):
    __slots__ = ("_points", "_range", "_ranges", "_seen")


class _Stamp(_Generated):
    __slots__ = ("nanosec", "sec")


class _Info(_Generated):
    __slots__ = ("client_gid", "event_type", "sequence_number", "stamp")


class Grasp:
    """A service."""

    class Request(_Generated):
        __slots__ = ("_force",)

    class Response(_Generated):
        __slots__ = ("_held",)

    class Event(_Generated):
        __slots__ = ("info", "request", "response")

        def __init__(self) -> None:
            super().__init__(info=_Info(stamp=_Stamp()), request=[], response=[])


def reading(value: float) -> Reading:
    points = [Point(x=value, y=0.0)]
    return Reading(range=value, points=points, ranges=array.array("d", [value]), seen=Point(x=0, y=0))


def run(*bodies: Callable[[Kernel], None], limit_s: float = 100.0) -> tuple[Kernel, str]:
    """Run each of them as a node that is called as the function; why the run ended, and its kernel."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading"})
    for body in bodies:

        def enter(body: Callable[[Kernel], None] = body) -> None:
            body(kernel)

        kernel.spawn(body.__name__, enter)
    try:
        with guard_run(kernel):
            return kernel, kernel.run(limit_s)
    finally:
        kernel.close()


def node(name: str, *arguments: str, namespace: str = "/", domain: int = contexts.DEFAULT_DOMAIN) -> contexts.GraphNode:
    """A node in a context of its own, as in a process of its own."""
    return contexts.GraphNode(name, namespace, contexts.Context(list(arguments), domain), None, True, False)


def wait(kind: str, entities: Sequence[Waitable], timeout_s: float | None = None) -> list[int]:
    """Wait for them; the indices of those that are ready."""
    waiting = WaitSet()
    for entity in entities:
        getattr(waiting, f"add_{kind}")(entity)
    waiting.wait(-1 if timeout_s is None else round(timeout_s * 1e9))
    return [index for index in range(len(entities)) if waiting.is_ready(kind, index)]
