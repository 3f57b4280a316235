"""Simulates the processes of a ROS 2 system in one operating-system process, by giving each its own module variables.

`Ros2Overlay` and `launch_processes` make a `Process` for each node, and the kernel runs the function that its `wrap`
returns; `process_of` returns the process of a kernel's node. Each process has its own values of the `ModuleVariables`,
since `rclpy.init()` stores its context in a module variable, as does code that expects a process of its own.
"""

from __future__ import annotations

import ast
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from greenlet import GreenletExit

from pytest_hricdv.runtime.blocking_calls import HAS_TERMINALS
from pytest_hricdv.runtime.kernel import Kernel, Node

if HAS_TERMINALS:
    from pytest_hricdv.runtime.virtual.terminal import sits_at

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

Body = Callable[[], None]
"""A function that a process runs."""

_PROCESS = "ros2 process"  # key of `Node.own`


def process_of(node: Node | None) -> Process | None:
    """The simulated process that a node of the kernel belongs to; None if it belongs to none."""
    process = None if node is None else node.own.get(_PROCESS)
    return process if isinstance(process, Process) else None


@dataclass(frozen=True, eq=False)  # hashed by identity, since the value need not be hashable
class ModuleVariable:
    """A module variable that functions of the module set, with its value after the import."""

    module: dict[str, Any]
    name: str
    initial: Any


@cache
def _set_by_functions(file: str) -> frozenset[str]:
    """The names that functions of a source file declare as `global`."""
    try:
        source = Path(file).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return frozenset()  # an extension module, or no source
    if "global " not in source:  # parsing every module of a distribution takes seconds
        return frozenset()
    declared = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Global)]
    return frozenset(name for statement in declared for name in statement.names)


class ModuleVariables:
    """The module variables that functions of some packages set, and `sys.argv` and `os.environ`."""

    def __init__(self, packages: Iterable[str]) -> None:
        self._packages = frozenset(package.partition(".")[0] for package in packages)
        self._seen_modules: set[str] = set()
        self._variables = [ModuleVariable(vars(sys), "argv", sys.argv), ModuleVariable(vars(os), "environ", os.environ)]

    def __iter__(self) -> Iterator[ModuleVariable]:
        return iter(self._variables)

    def update(self) -> None:
        """Add the variables of newly imported modules; call it before any function of theirs."""
        for name, module in list(sys.modules.items()):
            if name in self._seen_modules or name.partition(".")[0] not in self._packages:
                continue
            if not getattr(module.__spec__, "_initializing", False):  # else it is being imported
                self._seen_modules.add(name)
                self._add(module)

    def _add(self, module: ModuleType) -> None:
        names = vars(module)
        file = names.get("__file__") or ""
        for name in sorted(_set_by_functions(str(file)) & names.keys()):
            self._variables.append(ModuleVariable(names, name, names[name]))


class Process:
    """A simulated process: module variables have its values while its kernel nodes run.

    It ends when its main function and all its threads have returned or raised; daemon threads end with it.

    Args:
        variables: the module variables that have values of their own in it.
        arguments: its `sys.argv`.
        name: the name of its terminal.
        environ: its `os.environ`; None for that of the session.
    """

    def __init__(
        self,
        kernel: Kernel,
        variables: ModuleVariables,
        arguments: Iterable[str],
        name: str = "",
        environ: Mapping[str, str] | None = None,
    ) -> None:
        self._kernel = kernel
        self._name = name
        self._has_main = False
        self._variables = variables
        own: dict[str, Any] = {"argv": list(arguments)}
        if environ is not None:
            own["environ"] = dict(environ)
        self._values: dict[ModuleVariable, Any] = {
            variable: own[variable.name]
            for variable in variables
            if variable.name in own and variable.module in (vars(sys), vars(os))
        }
        self.at_end: list[Body] = []
        """Functions to call when it ends, such as those that remove its entities from the ROS graph."""
        self._has_ended = False
        self._unfinished = 0
        self._daemons: list[Node] = []
        self._nodes: list[Node] = []
        """The node of the main function, then those of threads."""
        self._signal: int | None = None
        self.was_interrupted: int | None = None
        """The signal that interrupted it; None without one."""

    def wrap(self, body: Body, *, daemon: bool = False) -> Body:
        """Make a body for a node of the kernel that runs in this process, as do threads that it starts.

        Args:
            body: the function to run.
            daemon: whether the process ends without waiting for it.
        """
        self._unfinished += not daemon

        def within() -> None:
            node = self._kernel.current()
            if self._has_ended:
                return
            if daemon:
                self._daemons.append(node)
            self._adopt(node)
            self._enter()
            try:
                body()
            finally:
                self._leave()
                node.leaving.remove(self._leave)
                node.leaving.remove(self._interruptible)
                self._unfinished -= not daemon
                if not self._unfinished:
                    self._end()

        return within

    def _adopt(self, node: Node) -> None:
        """Make a node of the kernel one of this process."""
        wrap_thread = node.wrap_thread
        node.wrap_thread = lambda thread, daemon: wrap_thread(self.wrap(thread, daemon=daemon), daemon)
        # First to leave and last to resume: the exception that it raises must not keep the others from resuming.
        node.leaving.insert(0, self._interruptible)
        node.leaving.append(self._leave)
        node.own[_PROCESS] = self
        self._nodes.append(node)
        if HAS_TERMINALS:
            sits_at(node, self._name, is_main=not self._has_main)
            self._has_main = True

    def _end(self) -> None:
        """End the process once, and its daemon threads without an exception, as the operating system does."""
        if self._has_ended:
            return
        self._has_ended = True
        for node in self._daemons:
            if not node.ended:
                node.leave_for_ever()
        for end in self.at_end:
            end()

    def interrupt(self, number: int) -> None:
        """Deliver a signal at this instant; its exception is raised where the process waits.

        SIGINT raises KeyboardInterrupt in the main thread. SIGTERM ends `rclpy.spin` with ExternalShutdownException, or
        the main thread if `rclpy` is not used. SIGKILL ends all threads.
        """
        self._signal = number
        for node in self._nodes if number == signal.SIGKILL else self._nodes[:1]:
            if not node.ended:
                self._kernel.wake(node)

    def _interruptible(self) -> Body:
        return self._raise_signal

    def _raise_signal(self) -> None:
        number, node = self._signal, self._kernel.own_node()
        if number is None or (number != signal.SIGKILL and node is not self._nodes[0]):
            return
        self.was_interrupted = number
        if number == signal.SIGKILL:
            raise GreenletExit
        self._signal = None
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        executors = sys.modules.get("rclpy.executors")
        raise GreenletExit if executors is None else vars(executors)["ExternalShutdownException"]

    def _enter(self) -> None:
        for variable, value in self._values.items():
            variable.module[variable.name] = value

    def _leave(self) -> Body:
        for variable in self._variables:
            value = variable.module[variable.name]
            # Once set by a process, a variable stays its own, even if it has the initial value again.
            if value is not variable.initial or variable in self._values:
                self._values[variable] = value
                variable.module[variable.name] = variable.initial
        return self._enter
