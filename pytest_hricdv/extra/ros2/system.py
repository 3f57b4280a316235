"""A ROS 2 system in a run: starts its nodes as the code under test, and gives the world its side of the graph."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable, Sequence
from importlib import metadata

from pytest_hricdv.declarations.ros2 import Launch, LaunchError, Ros2, Ros2Error, RosNode
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
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.extra.ros2.stuck import stuck_nodes
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.runtime import Bus, Kernel
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.virtual import VirtualModules

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_OLDEST = (7, 1)
"""The version of `rclpy` of the distribution jazzy."""

_LIBRARIES = ("rclpy", "tf2_ros", "message_filters")
"""Packages of a distribution that wait with `threading` and `time`: they see virtual time in each testbench."""

_USED = ("rclpy", "rclpy.executors", "rclpy.lifecycle.node", "rclpy.time_source", "rclpy.action")
"""Imported before any node runs, so that what they set is known as it is after the import."""

_CHECK_FIELDS = "ROS_PYTHON_CHECK_FIELDS"
"""The variable of the environment that generated messages read when they are imported, into one of the same name."""

Wrapper = Callable[[Callable[[], None]], Callable[[], None]]


class Ros2Overlay:
    """`rclpy` in virtual time, for one run.

    Args:
        declared: by the testbench.
        code: the packages under test.

    Raises:
        Ros2Error: as of `prepare`.
    """

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
        self._know(variables)
        self.modules.imported.append(lambda: self._know(variables))
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
    def _know(variables: ModuleVariables) -> None:
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
    """A process that ends with `sys.exit()` has not failed."""

    def body() -> None:
        try:
            main()
        except SystemExit as error:
            if error.code not in (None, 0):
                raise

    return body


def prepare() -> None:
    """Let this process be one in which `rclpy` runs in virtual time.

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
    """Let messages check their fields when they are set, unless the user's environment says otherwise.

    Since jazzy they do not by default: a wrong name is ignored, a value of a wrong type becomes any value on its way.
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
        return  # a checkout; what it lacks says so itself
    if tuple(int(part) for part in version.split(".")[:2] if part.isdigit()) < _OLDEST:
        oldest = ".".join(map(str, _OLDEST))
        raise Ros2Error(f"rclpy {version} is not supported: expected {oldest} (ROS 2 jazzy) or later")
