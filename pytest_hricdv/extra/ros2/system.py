"""Runs a ROS 2 system as the code under test: `Ros2Overlay` starts its nodes, with `rclpy` in virtual time.

`Ros2Execution.middleware` makes one for each run. The world joins the graph through the `StartedSystem` that
`Ros2Overlay.start` returns. After the run, `stuck_nodes` names nodes that wait for ever. `prepare` replaces the
extension of `rclpy` in this process.
"""

from __future__ import annotations

import importlib.util
import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from types import FrameType
from typing import Any, cast

from pytest_hricdv.declarations.ros2 import Launch, LaunchError, Ros2, Ros2Error, RosNode
from pytest_hricdv.extra.ros2.actions import ActionClient
from pytest_hricdv.extra.ros2.arguments import UnknownROSArgsError, command_line, parse
from pytest_hricdv.extra.ros2.bridge import Bridge
from pytest_hricdv.extra.ros2.clocks import need_no_clock_topic
from pytest_hricdv.extra.ros2.delivery import Delivery
from pytest_hricdv.extra.ros2.executables import entry_point, load, require_virtual_package
from pytest_hricdv.extra.ros2.graph import all_graphs, carry_with, notes_of
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.launch_files import PACKAGES as LAUNCH_SYSTEM
from pytest_hricdv.extra.ros2.launch_files import find, launch_body, launch_process
from pytest_hricdv.extra.ros2.launch_processes import Processes
from pytest_hricdv.extra.ros2.overlay import adapt_rclpy, replace_extension
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process, process_of
from pytest_hricdv.extra.ros2.services import Client
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.runtime import Bus, Kernel
from pytest_hricdv.runtime.kernel import Node
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual import VirtualModules

# Modules and functions that are on the stack of a node while it waits
_WAITING_FOR_RESPONSES = {
    ("rclpy.client", "call"),
    ("rclpy.executors", "spin_until_future_complete"),
    ("rclpy.action.client", "send_goal"),
}
_WAITING_FOR_SERVERS = {("rclpy.client", "wait_for_service"), ("rclpy.action.client", "wait_for_server")}
_CALLING_BACK = {("rclpy.executors", "handler")}
_AT_A_TERMINAL = {("pytest_hricdv.runtime.virtual.terminal", "wait_readable")}
_SPINNING = {
    ("rclpy.executors", "_wait_for_ready_callbacks"),
    ("pytest_hricdv.extra.ros2.executor", "wait_for_ready_callbacks"),
}


def stuck_nodes(kernel: Kernel, idle_timeout_s: float, *, is_idle: bool) -> list[str]:
    """A sentence on each node that waits for ever.

    This is certain for nodes that wait, without a time-out, for a service that nobody serves or for a response that
    only they can take; and, if the run is idle, for nodes that wait in a callback. Others count after a wait of
    `idle_timeout_s`.

    Args:
        kernel: the kernel after a run, before its nodes are ended.
        idle_timeout_s: how long a node may wait (simulated s).
        is_idle: whether no node could continue.
    """
    nodes = [_Wait(kernel, node, frames) for node in kernel.nodes if (frames := _frames(node))]
    least_s = 0.0 if is_idle else idle_timeout_s
    blocked = [sentence for node in nodes if (sentence := node.block_reason(least_s))]
    return blocked + [request for node in nodes for request in node.requests_without_server(least_s)]


def _frames(node: Node) -> list[FrameType]:
    """The frames of a waiting node of the system, innermost first."""
    frames, frame = [], node.frame if process_of(node) is not None and not node.ended else None
    while frame is not None:
        frames.append(frame)
        frame = frame.f_back
    return frames


def _function(frame: FrameType) -> tuple[str, str]:
    """Module and name of a function."""
    return str(frame.f_globals.get("__name__")), frame.f_code.co_name


def _line(place: str) -> str:
    """File and line without the folder."""
    return Path(place).name


@dataclass
class _Wait:
    """A node of the kernel that waits."""

    kernel: Kernel
    node: Node
    frames: Sequence[FrameType]
    functions: set[tuple[str, str]] = field(init=False)

    def __post_init__(self) -> None:
        self.functions = {_function(frame) for frame in self.frames}

    def block_reason(self, least_s: float) -> str:
        """Where and for what it waits in vain, for this long or for ever; empty if it may continue."""
        since_s, why = self._for_server(least_s)
        if not why and self.kernel.waits_for_ever(self.node):
            since_s, why = self.node.blocked_s, self._for_ever(least_s)
        place = _line(place_of(self.frames[0]))
        return f"{self.node.name} has waited at {place} since {since_s:.3f} s: {why}" if why else ""

    def _for_server(self, least_s: float) -> tuple[float, str]:
        """Since when it has waited for a server, as in `wait_for_service`, and for which."""
        for frame in self.frames:
            if _function(frame) not in _WAITING_FOR_SERVERS:
                continue
            client, timeout_s = _client_of(frame.f_locals.get("self")), frame.f_locals.get("timeout_sec")
            if client is None or client.missed_since_s is None or client.servers():
                break
            is_endless = timeout_s is None or math.isinf(timeout_s)
            # At least an instant: a client that looks for the first time now has not waited in vain yet.
            if is_endless or self.kernel.now_s - client.missed_since_s >= max(least_s, 1e-6):
                return client.missed_since_s, f"for {_client_text(client)}, which nobody serves"
        return 0.0, ""

    def _for_ever(self, least_s: float) -> str:
        """What it waits for without a time-out, if this cannot come or has not come for this long."""
        clients = self._last_clients() if self.functions & _WAITING_FOR_RESPONSES else []
        for client in clients:
            if not client.servers():
                return f"for the response of {_client_text(client)}, which nobody serves"
            if client.was_answered_before():
                return f"for the response of {_client_text(client)}, which only the executor that waits here could take"
        waited_s = self.kernel.now_s - self.node.blocked_s
        reads_keys = bool(self.functions & _AT_A_TERMINAL)  # a person may take as long as they like
        if waited_s < least_s or reads_keys or not self.functions & _CALLING_BACK:
            return ""
        so_far = f"in a callback, for {waited_s:.1f} s so far, without a time-out"
        for client in clients:
            if client.is_unanswered():
                server = client.servers()[0].node.get_fully_qualified_name()
                return f"for the response of {_client_text(client)} of {server}, {so_far}"
        return so_far

    def _last_clients(self) -> list[Client]:
        """The clients whose last request is its own."""
        graphs = all_graphs(self.kernel)
        clients = [client for graph in graphs for group in graph.clients.values() for client in group]
        return [client for client in cast("list[Client]", clients) if client.asked_by is self.node]

    def requests_without_server(self, least_s: float) -> Iterator[str]:
        """Requests of its executor's clients that still wait for a response, but have no server."""
        spinning = next((frame for frame in self.frames if _function(frame) in _SPINNING), None)
        nodes = [] if spinning is None else spinning.f_locals["self"].get_nodes()
        for client, numbers in (pending for node in nodes for pending in _open_requests(node)):
            lost = [client.lost[number] for number in numbers if number in client.lost]
            if lost and not client.servers() and self.kernel.now_s - lost[0].time_s >= least_s:
                where = f"at {_line(lost[0].place)} at {lost[0].time_s:.3f} s"
                yield f"{self.node.name} calls {_client_text(client)} {where}: nobody serves it"


def _client_of(owner: Any) -> Client | None:
    """The client behind an object of `rclpy`: of a service or an action."""
    handle = getattr(owner, "handle", None) or getattr(owner, "_client_handle", None)
    if isinstance(handle, ActionClient):
        return handle.goal
    return handle if isinstance(handle, Client) else None


def _open_requests(node: Any) -> Iterator[tuple[Client, list[int]]]:
    """The clients of a node of `rclpy`, and the numbers of the requests whose responses it still wants."""
    for owner, wanted in (
        *((client, "_pending_requests") for client in node.clients),
        *((waitable, "_pending_goal_requests") for waitable in node.waitables),
    ):
        client = _client_of(owner)
        if client is not None:
            yield client, list(getattr(owner, wanted, ()))


def _client_text(client: Client) -> str:
    """The client's service or action, as its author calls it."""
    name, _, part = client.service_name.partition("/_action/")
    return f"the action {name}" if part else f"the service {name}"


__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_OLDEST = (7, 1)
"""The oldest supported version of `rclpy`, that of ROS 2 jazzy."""

_LIBRARIES = ("rclpy", "tf2_ros", "message_filters")
"""Packages of a distribution that wait with `threading` and `time`: they always see virtual time."""

_USED = ("rclpy", "rclpy.executors", "rclpy.lifecycle.node", "rclpy.time_source", "rclpy.action")
"""Imported before any node runs, so that the initial values of their variables are known."""

_CHECK_FIELDS = "ROS_PYTHON_CHECK_FIELDS"
"""The environment variable that generated messages read on import, into a module variable of the same name."""

Wrapper = Callable[[Callable[[], None]], Callable[[], None]]


class Ros2Overlay:
    """`rclpy` and the packages under test in virtual time, for one run. Raises Ros2Error as `prepare` does."""

    virtual = frozenset({"time", "threading"})
    """The APIs that ROS 2 nodes wait with."""

    def __init__(self, declared: Ros2, code: Sequence[str]) -> None:
        prepare()
        self._declared = declared
        self._packages = (*_LIBRARIES, *LAUNCH_SYSTEM, *code, *declared.packages)
        self.modules = VirtualModules(self._packages)
        self.notes: tuple[str, ...] = ()
        """Notes on the run that fail nothing, a sentence each."""
        self._delivery: Delivery | None = None
        self.stuck_nodes: list[str] = []
        """Nodes that wait for what never comes, a sentence each."""

    def start(
        self, kernel: Kernel, bus: Bus, measured: Wrapper, nodes: Sequence[RosNode | Launch], seed: int = 0
    ) -> StartedSystem:
        """Start nodes, each in a process of its own.

        Raises:
            Ros2Error: a node is in none of the packages.
            LaunchError: the code of a node is not found.
        """
        for name in _USED:
            importlib.import_module(name)
        bridge = Bridge(bus, self._declared, seed)
        self._delivery = bridge.delivery
        carry_with(kernel, bridge)
        need_no_clock_topic(kernel)
        files = [find(launch) for launch in nodes if isinstance(launch, Launch)]
        started = [(node, self._load_node(node)) for node in nodes if not isinstance(node, Launch)]
        variables = ModuleVariables(self._packages)
        self._update_modules(variables)
        self.modules.imported.append(lambda: self._update_modules(variables))
        for node, main in started:
            process = Process(kernel, variables, command_line(node), node.label)
            kernel.spawn(node.label, measured(process.wrap(_until_exit(main))))
        for file in files:
            kernel.virtual |= {"asyncio"}  # the launch system is a program of asyncio
            processes = Processes(kernel, variables, self._packages, file.executables, measured)
            body = launch_process(processes, file).wrap(launch_body(file, processes))
            kernel.spawn(f"launch {file.path.name}", body)
        return StartedSystem(kernel)

    def notice_stuck_nodes(self, kernel: Kernel, *, is_idle: bool) -> None:
        """Note stuck nodes; called after a run, before its nodes are ended; `is_idle` if nothing could continue."""
        self.notes = notes_of(kernel)
        self.stuck_nodes = stuck_nodes(kernel, self._declared.idle_timeout_s, is_idle=is_idle)
        if self._delivery is not None:
            graphs = all_graphs(kernel)
            names = [name for graph in graphs for part in (graph.publishers, graph.subscriptions) for name in part]
            names += [name for graph in graphs for part in (graph.services, graph.clients) for name in part]
            self.stuck_nodes += self._delivery.find_unused_names(names)

    @staticmethod
    def _update_modules(variables: ModuleVariables) -> None:
        variables.update()
        adapt_rclpy()

    def _load_node(self, node: RosNode) -> Callable[[], object]:
        if not isinstance(node, RosNode):
            raise LaunchError(f"expected RosNode(...) or Launch(...), not {node!r}")
        try:
            parse(command_line(node))
        except (RCLError, UnknownROSArgsError) as error:
            raise LaunchError(f"{node}: {error}") from None
        require_virtual_package(str(node), entry_point(node), self._packages)
        return load(node)


def _until_exit(main: Callable[[], object]) -> Callable[[], None]:
    """Let a process end with `sys.exit()`."""

    def body() -> None:
        try:
            main()
        except SystemExit as error:
            if error.code not in (None, 0):
                raise

    return body


def prepare() -> None:
    """Make `rclpy` run in virtual time in this process.

    Raises:
        Ros2Error: there is no `rclpy`, it is too old, or it was imported with its real extension.
    """
    _require_rclpy()
    try:
        replace_extension()
    except KernelError as error:
        raise Ros2Error(str(error)) from None
    _check_fields()


def _check_fields() -> None:
    """Make messages check their fields on assignment, unless the user's environment says otherwise.

    Since jazzy they do not by default: a wrong name is ignored, a value of a wrong type arrives as an arbitrary one.
    """
    wanted = os.environ.setdefault(_CHECK_FIELDS, "1")
    for module in list(sys.modules.values()):
        names = getattr(module, "__dict__", {})
        if _CHECK_FIELDS.lower() in names:
            names[_CHECK_FIELDS.lower()] = wanted


def _require_rclpy() -> None:
    if importlib.util.find_spec("rclpy") is None:
        raise Ros2Error(
            "rclpy cannot be imported: run `source /opt/ros/DISTRIBUTION/setup.bash` of a ROS 2 distribution (jazzy or "
            "later) before pytest, in a Python of its version; or, on Linux, `pip install ros-rclpy "
            "ros-common-interfaces` and then `pip install --force-reinstall lark`"
        )
    try:
        version = metadata.version("rclpy")
    except metadata.PackageNotFoundError:
        return  # a checkout without a version; what it lacks raises later
    if tuple(int(part) for part in version.split(".")[:2] if part.isdigit()) < _OLDEST:
        oldest = ".".join(map(str, _OLDEST))
        raise Ros2Error(f"rclpy {version} is not supported: expected {oldest} (ROS 2 jazzy) or later")
