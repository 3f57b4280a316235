"""A ROS 2 system in a run, as the testbench's `run` and the execution of tests see it; `extra.ros2` is behind it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from pytest_hricdv.declarations.ros2 import RosNode
from pytest_hricdv.runtime import Bus, Kernel
from pytest_hricdv.runtime.virtual import VirtualModules

Body = Callable[[], None]


class Publisher(Protocol):
    """Of a topic."""

    def publish(self, message: Any) -> None:
        """Deliver a copy to each subscription that matches. Raises TypeError for a message of another type."""


class MessageQueue(Protocol):
    """The messages of a topic, as `runtime.Subscription` has those of the bus."""

    def poll(self) -> Any | None:
        """The oldest message not yet taken, or None; never blocks."""

    def wait(self, timeout_s: float) -> Any | None:
        """Block until there is a message, at most `timeout_s`; None on time-out."""


class Caller(Protocol):
    """A client of a service or an action."""

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Send a request or a goal that has these fields, and wait until it is answered or over.

        Returns:
            The response of a service. Of an action, the `status` of the goal, as `action_msgs/msg/GoalStatus` numbers
            it, and its `result`. None if there is neither within `timeout_s`, or the goal was not accepted.
        """


class WorldNode(Protocol):
    """A node of the simulated world in the ROS graph. Types are named as "std_msgs/msg/String", or are classes."""

    def publisher(self, topic: str, kind: str | type[Any], depth: int = 10, *, latched: bool = False) -> Publisher:
        """A publisher: call its `publish(message)`.

        Args:
            latched: whether a later subscription gets the last message ("transient local").
        """

    def subscribe(self, topic: str, kind: str | type[Any], depth: int = 1000) -> MessageQueue:
        """A queue of the messages of a topic from now on. It takes what any publisher offers."""

    def serve(self, name: str, kind: str | type[Any], answer: Callable[[Any, Any], Any]) -> None:
        """Serve from now on: `answer(request, response)` returns the response, and may block."""

    def client(self, name: str, kind: str | type[Any]) -> Caller:
        """A client of a service."""

    def action(self, name: str, kind: str | type[Any]) -> Caller:
        """A client of an action."""


class Ros2System(Protocol):
    """The world's side of a system that was started."""

    def node(self, name: str, namespace: str = "/") -> WorldNode:
        """A node of the world in the ROS graph, such as a simulated sensor."""


class Middleware(Protocol):
    """What the code under test runs on in one run, in virtual time."""

    @property
    def modules(self) -> VirtualModules:
        """Lets the code under test and the libraries of the middleware see virtual time."""

    @property
    def virtual(self) -> frozenset[str]:
        """What its nodes wait with, as in `Testbench.virtual`."""

    @property
    def stuck_nodes(self) -> Sequence[str]:
        """Nodes that waited at the end of the run for what never comes, a sentence each."""

    def started(
        self, kernel: Kernel, bus: Bus, measured: Callable[[Body], Body], nodes: Sequence[RosNode]
    ) -> Ros2System:
        """Start nodes, each as if in a process of its own.

        Raises:
            InputError: a node cannot be started.
        """

    def notice_stuck_nodes(self, kernel: Kernel, *, is_idle: bool) -> None:
        """To be called when a run is over, before its nodes are ended; `is_idle` where nothing could go on."""
