"""Runs the processes of a launch file as nodes of the kernel; its event handlers see them start, get signals and exit.

`launch_files` replaces `osrf_pycommon.process_utils.async_execute_process`, which starts real processes, by
`Processes.start`. A function that a testbench declares in place of an executable gets a `LaunchedProcess`.
"""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from inspect import signature
from typing import Any

from greenlet import GreenletExit

from pytest_hricdv._base.message import InputError
from pytest_hricdv.declarations.ros2 import IGNORED, RosNode
from pytest_hricdv.declarations.ros2 import Process as Function
from pytest_hricdv.extra.ros2.arguments import parse, without_ros, yaml_text
from pytest_hricdv.extra.ros2.contexts import DEFAULT_DOMAIN, Context
from pytest_hricdv.extra.ros2.entries import load_entry
from pytest_hricdv.extra.ros2.executables import (
    Command,
    Executables,
    command,
    is_container,
    require_virtual_package,
)
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.extra.ros2.world import WorldNode
from pytest_hricdv.runtime.kernel import Kernel, Node

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

Wrapper = Callable[[Callable[[], None]], Callable[[], None]]
"""Returns a function that does the same, with its coverage measured."""


@dataclass(frozen=True)
class LaunchedProcess:
    """A process of a launch file, as passed to the function that replaces it.

    Attributes:
        name: the name of its node in the launch file, else the executable's.
        namespace: the namespace of its node.
        arguments: its command-line arguments, without the program and those for ROS.
        parameters: the parameters of its node, name -> value.
        argv: its whole command line, from the launch file.
    """

    name: str
    namespace: str
    arguments: tuple[str, ...]
    parameters: Mapping[str, Any]
    _kernel: Kernel = field(repr=False)
    argv: tuple[str, ...] = field(repr=False)

    @cached_property
    def node(self) -> WorldNode:
        """Its node in the graph, with the remappings of the launch file, like one of `run.ros2(...).node(...)`."""
        context = Context(list(self.argv), DEFAULT_DOMAIN, self._kernel)
        return WorldNode(self._kernel, self.name, self.namespace, context)

    def sleep(self, duration_s: float) -> None:
        """Wait in simulated time."""
        self._kernel.sleep(duration_s)


def describe_process(kernel: Kernel, wanted: Command) -> LaunchedProcess:
    """The process of a command, for the function that replaces it."""
    parsed = parse(wanted.argv)
    name = parsed.new_name("__node", "") or wanted.name.rpartition("/")[2]
    namespace = parsed.new_name("__ns", "") or "/"
    parameters = parsed.parameters_of(f"{namespace.rstrip('/')}/{name}")
    return LaunchedProcess(name, namespace, tuple(without_ros(wanted.argv[1:])), parameters, kernel, wanted.argv)


def void(_: object) -> None:
    """Discard an unused return value."""


@dataclass
class Processes:
    """Starts the processes of a launch file.

    Args:
        variables: the module variables, of which each process has its own values.
        packages: the packages that see virtual time.
        executables: finds the code of an executable.
        measured: wraps the body of a node of the code under test.
    """

    kernel: Kernel
    variables: ModuleVariables
    packages: Sequence[str]
    executables: Executables
    measured: Wrapper
    failed: Callable[[Exception], None] = void
    """Called with the error of a failed start; it ends the run."""
    _started: int = 0

    def start(self, words: Sequence[str], environ: Mapping[str, str]) -> Transport:
        """Start a process at this instant.

        Args:
            words: its command line.
            environ: its environment variables.

        Raises:
            LaunchError, Ros2Error: there is no such program, or it is not Python.
        """
        wanted = command(words)
        target = self.executables.of(wanted)
        self._started += 1
        transport = Transport(self.kernel, self._started)
        if target == IGNORED:
            if is_container(wanted.name):
                container = describe_process(self.kernel, wanted).node
                container.serve("~/_container/load_node", "composition_interfaces/srv/LoadNode", self._load)
            return transport
        main = self._main(wanted, target)
        name = parse(wanted.argv).new_name("__node", "") or wanted.name
        process = Process(self.kernel, self.variables, wanted.argv, name, environ)
        body = process.wrap(partial(_run_to_its_end, main, transport, process))
        transport.process = process
        transport.node = self.kernel.spawn(name, body if callable(target) else self.measured(body))
        return transport

    def _main(self, wanted: Command, target: Function | str) -> Callable[[], object]:
        if not isinstance(target, str):
            has_parameter = any(
                parameter.default is parameter.empty for parameter in signature(target).parameters.values()
            )
            return partial(target, describe_process(self.kernel, wanted)) if has_parameter else partial(target)
        node = f"{self.executables.launch}: {wanted.name}"
        require_virtual_package(node, target, self.packages)
        return load_entry(node, target, list(wanted.argv))

    def _load(self, request: Any, response: Any) -> Any:
        """Answer a `composition_interfaces/srv/LoadNode` request, in place of a real container."""
        try:
            return self._load_component(request, response)
        except InputError as error:
            self.failed(error)
            response.success, response.error_message = False, str(error)
            return response

    def _load_component(self, request: Any, response: Any) -> Any:
        target = self.executables.component(request.package_name, request.plugin_name)
        name = request.node_name or request.plugin_name.rpartition("::")[2]
        rules = [f"__node:={name}", f"__ns:={request.node_namespace or '/'}", *request.remap_rules]
        argv = [request.plugin_name, "--ros-args", *(word for rule in rules for word in ("-r", rule))]
        for parameter in request.parameters:
            argv += ["-p", f"{parameter.name}:={_text_of(parameter.value)}"]
        if target != IGNORED:
            wanted = Command(f"{request.package_name}/{request.plugin_name}", tuple(argv))
            main = self._main(wanted, target)
            body = Process(self.kernel, self.variables, argv, name).wrap(lambda: void(main()))
            self.kernel.spawn(name, body if callable(target) else self.measured(body))
        self._started += 1
        response.success, response.unique_id = True, self._started
        response.full_node_name = f"{(request.node_namespace or '/').rstrip('/')}/{name}"
        return response


def _text_of(value: Any) -> str:
    """A `rcl_interfaces/msg/ParameterValue` as text for a command line."""
    from rclpy.parameter import parameter_value_to_python  # type: ignore[import-not-found, unused-ignore]

    plain = parameter_value_to_python(value)
    return yaml_text(RosNode(entry="component:parameter"), "", list(plain) if hasattr(plain, "tolist") else plain)


class Transport:
    """Replaces asyncio's transport of a subprocess, which the launch system reads and signals."""

    def __init__(self, kernel: Kernel, pid: int) -> None:
        self._kernel = kernel
        self._pid = pid
        self.code: int | None = None
        self.ended: Callable[[int], None] = void
        self.node: Node | None = None
        """None for an ignored executable, which runs until it gets a signal."""
        self.process: Process | None = None
        self.is_expected_to_fail = False
        """Whether the launch file handles its exit: then an exit code does not fail the run."""

    def get_pid(self) -> int:
        """A number, counted from 1 in each run."""
        return self._pid

    def get_returncode(self) -> int | None:
        """Its exit code; None while it runs."""
        return self.code

    def get_pipe_transport(self, number: int) -> None:
        """It has no pipes: its output is that of pytest's process."""

    def close(self) -> None:
        """Do nothing: there is nothing to close."""

    def end(self, code: int) -> None:
        """Set its exit code and report it, once."""
        if self.code is None:
            self.code = code
            self.ended(code)

    def send_signal(self, number: int | signal.Signals) -> None:
        """Interrupt it where it waits: SIGINT as Ctrl+C, SIGTERM as `rclpy` handles it, SIGKILL at once.

        Raises:
            ProcessLookupError: it has ended.
        """
        if self.code is not None:
            raise ProcessLookupError
        if self.process is None:
            self.end(-int(number))
        elif number == signal.SIGKILL:
            self.kill()
        elif number in (signal.SIGINT, signal.SIGTERM):
            self.process.interrupt(number)
        # Others, such as SIGUSR1, have no effect: Python's default would end it, but handlers are not simulated.

    def kill(self) -> None:
        """End it at once."""
        if self.process is not None:
            self.process.interrupt(signal.SIGKILL)
        self.end(-int(signal.SIGKILL))


def _run_to_its_end(main: Callable[[], object], transport: Transport, process: Process) -> None:
    """The body of a process: an exception in it fails the run, unless a signal raised it."""

    def end(code: int) -> None:
        process.at_end.append(partial(transport.end, code))  # its threads may continue

    try:
        main()
    except SystemExit as error:
        code = 0 if error.code is None else error.code if isinstance(error.code, int) else 1
        if code and not transport.is_expected_to_fail:
            raise
        end(code)
    except KeyboardInterrupt:
        if not process.was_interrupted:
            raise
        end(-int(signal.SIGINT))
    except GreenletExit:
        if process.was_interrupted:
            end(-int(process.was_interrupted))
        raise
    else:
        end(0)


def connect_protocol(loop: asyncio.AbstractEventLoop, make: Any, transport: Transport) -> Any:
    """Connect the launch system's protocol to a process; `complete` is done when the process has ended."""
    protocol = make()
    protocol.connection_made(transport)

    def complete_soon(code: int) -> None:
        def complete() -> None:
            if not protocol.complete.done():
                protocol.complete.set_result(code)

        if not loop.is_closed():
            loop.call_soon_threadsafe(complete)

    transport.ended = complete_soon
    if transport.code is not None:
        complete_soon(transport.code)
    return protocol


class NoSignals:
    """Replaces `AsyncSafeSignalManager`: Ctrl+C interrupts the session, and launch files never see it."""

    def __init__(self, loop: object) -> None: ...

    def __enter__(self) -> NoSignals:
        return self

    def __exit__(self, *_: object) -> None: ...

    def handle(self, number: int, handler: object) -> None:
        """Do nothing: there are no signals."""
