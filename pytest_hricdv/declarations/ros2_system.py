"""The interface of a ROS 2 system in a run, for testbenches and for the execution; `extra.ros2` implements it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from pytest_hricdv.declarations.ros2 import Launch, RosNode
from pytest_hricdv.runtime import Bus, Kernel
from pytest_hricdv.runtime.virtual import VirtualModules

Body = Callable[[], None]


class RosPublisher(Protocol):
    """A publisher of a topic."""

    def publish(self, message: Any) -> None:
        """Deliver a copy to each subscription that matches. Raises TypeError for a message of another type."""


class RosQueue(Protocol):
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


class RosSentGoal(Protocol):
    """A goal of an action that was sent, and accepted."""

    def feedback(self, timeout_s: float) -> Any | None:
        """The oldest feedback not yet taken; None if there is none within `timeout_s`."""

    def result(self, timeout_s: float) -> Any | None:
        """The `status` of the goal and its `result`, once it is over; None if it is not within `timeout_s`."""

    def cancel(self, timeout_s: float) -> bool:
        """Ask to cancel it; whether the server will. It is over when there is a result."""


class RosActionCaller(Caller, Protocol):
    """A client of an action."""

    def send(self, timeout_s: float, **fields: Any) -> RosSentGoal | None:
        """Send a goal that has these fields, besides others; None if it is not accepted within `timeout_s`."""


class RosServedGoal(Protocol):
    """A goal that the world has accepted."""

    request: Any
    """The goal's message."""

    @property
    def is_over(self) -> bool:
        """Whether it has succeeded, was aborted or is cancelled."""

    @property
    def is_canceling(self) -> bool:
        """Whether a client has asked to cancel it, and may."""

    def wait(self, timeout_s: float) -> bool:
        """Go on with the goal for `timeout_s`; True, at once, when it is to be cancelled, or is over."""

    def feedback(self, **fields: Any) -> None:
        """Publish feedback that has these fields."""

    def succeed(self, **fields: Any) -> None:
        """End it: it has succeeded, with a result that has these fields."""

    def abort(self, **fields: Any) -> None:
        """End it: it has failed, with a result that has these fields."""

    def cancel(self, **fields: Any) -> None:
        """End it as cancelled, which a client has asked for, with a result that has these fields."""


class RosWorldNode(Protocol):
    """A node of the simulated world in the ROS graph. Types are named as "std_msgs/msg/String", or are classes."""

    def publisher(self, topic: str, kind: str | type[Any], depth: int = 10, *, latched: bool = False) -> RosPublisher:
        """A publisher: call its `publish(message)`.

        Args:
            latched: whether a later subscription gets the last message ("transient local").
        """

    def subscribe(self, topic: str, kind: str | type[Any], depth: int = 1000) -> RosQueue:
        """A queue of the messages of a topic from now on. It takes what any publisher offers."""

    def serve(self, name: str, kind: str | type[Any], answer: Callable[[Any, Any], Any]) -> None:
        """Serve from now on: `answer(request, response)` returns the response, and may block."""

    def client(self, name: str, kind: str | type[Any]) -> Caller:
        """A client of a service."""

    def action(self, name: str, kind: str | type[Any]) -> RosActionCaller:
        """A client of an action."""

    def serve_action(
        self,
        name: str,
        kind: str | type[Any],
        execute: Callable[[Any], object],
        *,
        accept: Callable[[Any], bool] = ...,
        may_cancel: Callable[[Any], bool] = ...,
    ) -> None:
        """Serve an action from now on.

        Args:
            execute: called with each goal that was accepted (`RosServedGoal`), in a node of its own; it may block, and
                ends the goal with `succeed`, `abort` or `cancel`.
            accept: whether a goal is accepted, by its message.
            may_cancel: whether a goal is cancelled when a client asks for it.
        """


class Ros2System(Protocol):
    """The world's side of a system that was started."""

    @property
    def kernel(self) -> Kernel:
        """The kernel of the run: fakes wait in its time."""

    def node(self, name: str, namespace: str = "/") -> RosWorldNode:
        """A node of the world in the ROS graph, such as a simulated sensor."""


class Middleware(Protocol):
    """The middleware of the code under test in one run, in virtual time."""

    @property
    def modules(self) -> VirtualModules:
        """Lets the code under test and the libraries of the middleware see virtual time."""

    @property
    def virtual(self) -> frozenset[str]:
        """The APIs that its nodes wait with, as in `VirtualTime.apis`."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the run that fail nothing, a sentence each."""

    @property
    def stuck_nodes(self) -> Sequence[str]:
        """Nodes that waited at the end of the run for what never comes, a sentence each."""

    def start(
        self,
        kernel: Kernel,
        bus: Bus,
        measured: Callable[[Body], Body],
        nodes: Sequence[RosNode | Launch],
        seed: int = 0,
    ) -> Ros2System:
        """Start nodes, each as if in a process of its own; the seed of the test is that of when messages arrive.

        Raises:
            InputError: a node cannot be start.
        """

    def notice_stuck_nodes(self, kernel: Kernel, *, is_idle: bool) -> None:
        """Note stuck nodes; called after a run, before its nodes are ended; `is_idle` if nothing could continue."""
