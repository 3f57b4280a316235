"""`Ros2` declares the ROS 2 system of a testbench: topics, services and actions by type; `Launch` the nodes to start.

The protocols of a started system (`Ros2System`) are here, too: testbenches use them, and `extra.ros2` implements them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from pytest_hricdv._base.message import InputError
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.runtime import Bus, Kernel
from pytest_hricdv.runtime.virtual import VirtualModules

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class Ros2Error(InputError):
    """The ROS 2 declaration of a testbench is wrong; the message says what, and what was expected."""


class LaunchError(InputError):
    """A node cannot be started; the message says which, what was expected, and what to do."""


class MissingExecutableError(LaunchError):
    """A package or an executable is missing: no test of the session can start the node."""


@dataclass(frozen=True)
class Ros2:
    """The ROS 2 system of a testbench. Types are named as ROS names them: "sensor_msgs/msg/LaserScan".

    In requirements, a topic has its full name without the first slash, with "_" for the others: "/arm/state" is
    `arm_state`, and its fields `arm_state.pose.position.x`. Of an array there is the length, `arm_state.name.length`.
    A service "/grasp" is the topics `grasp_request` and `grasp_response`; an action "/fetch" is `fetch_goal`,
    `fetch_answer` (field `accepted`), `fetch_feedback`, `fetch_cancel` and `fetch_result` (with `status`). What nodes
    log is `rosout`, with `name`, `level` and `msg`, without being declared.

    Args:
        topics: full name -> type of its messages.
        services: full name -> type.
        actions: full name -> type.
        packages: the packages of nodes that are not under test; they see virtual time, too.
        idle_timeout_s: how long a node may have waited when a run ends (simulated s), in a callback without a time-out
            or for a service that nobody serves.
        interfaces: folders of packages of interfaces that are not installed, such as "third_party/nav2_msgs": their
            `.msg`, `.srv` and `.action` files are enough to import them. Paths are relative to where pytest is started.
        delay_s: full name of a topic, service or action, or a pattern such as `"/camera/*"` -> how long each message is
            on its way (s): a number, or a `Uniform`, from which it is drawn by the seed of the test. Names come before
            patterns, and earlier patterns before later ones.
        drop: likewise, the share of messages that are lost, from 0 to 1. Only best effort loses any: a name whose
            messages are carried reliably is an error, a pattern does not mean them.
        reorder: names and patterns of those whose messages may overtake each other, if their delays say so; otherwise
            those of one sender stay in order. As of `drop`, reliable ones keep their order.
    """

    topics: Mapping[str, str] = field(default_factory=dict, hash=False)
    services: Mapping[str, str] = field(default_factory=dict, hash=False)
    actions: Mapping[str, str] = field(default_factory=dict, hash=False)
    packages: tuple[str, ...] = ()
    idle_timeout_s: float = 30.0
    interfaces: tuple[str | Path, ...] = ()
    delay_s: Mapping[str, Uniform | float] = field(default_factory=dict, hash=False)
    drop: Mapping[str, float] = field(default_factory=dict, hash=False)
    reorder: tuple[str, ...] = ()


@dataclass(frozen=True)
class RosNode:
    """One process with a node, as `launch_ros.actions.Node` describes it.

    Args:
        package: the package of an executable, or empty if there is an entry.
        executable: a console script of the package.
        entry: instead of both, where its code is: "package.module:main" for a function without arguments, or
            "package.module:Class" for a class of nodes, which is made without arguments, and spun.
        name: the node's name instead of its own.
        namespace: its namespace, such as "/arm".
        remappings: pairs of names, from and to.
        parameters: mappings of names to values, or paths of YAML files; later ones win.
        arguments: further ones of its command line.
        workspace: folders with sources of packages, in addition to the one where pytest is started and what is
            installed. A package needs no build.

    Raises:
        LaunchError: neither an executable nor an entry, or both.
    """

    package: str = ""
    executable: str = ""
    entry: str = ""
    name: str = ""
    namespace: str = ""
    remappings: Sequence[tuple[str, str]] = ()
    parameters: Sequence[Mapping[str, Any] | str | Path] = ()
    arguments: Sequence[str] = ()
    workspace: Sequence[str | Path] = ()

    def __post_init__(self) -> None:
        if bool(self.entry) == bool(self.executable) or bool(self.package) != bool(self.executable):
            raise LaunchError(f'{self}: expected package="..." and executable="...", or entry="package.module:name"')

    def __str__(self) -> str:
        return f"RosNode {self.entry or f'{self.package} {self.executable}'}"

    @property
    def label(self) -> str:
        """The name of its process in messages."""
        module, _, function = self.entry.partition(":")
        return self.name or self.executable or (module.rpartition(".")[2] if function == "main" else function)


Process = Callable[[Any], object]
"""The replacement for an executable that a testbench runs; see `Launch.executables`."""

IGNORED = "ignored"
"""A value in `Launch.executables`: it is not started, and the launch file continues as if it ran."""


@dataclass(frozen=True)
class Launch:
    """A launch file of ROS 2, of Python, XML or YAML, as it is: what it starts is the code under test.

    Args:
        file: its path; with a package, the name that `ros2 launch` gets, or its path in the package's share folder.
        package: the package of the launch file, installed or as source; empty where `file` is a path.
        arguments: launch arguments, name -> value.
        executables: what runs in the place of executables that are not Python: "package/executable" -> a function, an
            entry "package.module:main", or `IGNORED`. The function is called in a process of its own, with a
            `LaunchedProcess` if it takes an argument. A composable node is called "package/package::Class", a command
            that is not a node, such as of `ExecuteProcess`, by its first word. `*` and `?` stand for any string.
        workspace: folders with sources of packages, besides those around the launch file and what is installed.

    Raises:
        LaunchError: a value of `executables` is none of these.
    """

    file: str | Path
    package: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict, hash=False)
    executables: Mapping[str, Process | str] = field(default_factory=dict, hash=False)
    workspace: Sequence[str | Path] = ()

    def __post_init__(self) -> None:
        for name, value in self.executables.items():
            if not callable(value) and value != IGNORED and ":" not in str(value):
                raise LaunchError(
                    f"{self}: executables[{name!r}] is {value!r}; expected a function, an entry "
                    f'"package.module:main", or "{IGNORED}"'
                )

    def __str__(self) -> str:
        return f"Launch {self.package} {self.file}" if self.package else f"Launch {self.file}"


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
        """Wait for `timeout_s`; True, at once, when the goal is to be cancelled, or is over."""

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
            InputError: a node cannot be started.
        """

    def notice_stuck_nodes(self, kernel: Kernel, *, is_idle: bool) -> None:
        """Note stuck nodes; called after a run, before its nodes are ended; `is_idle` if nothing could continue."""
