"""Simulated processes of a ROS 2 system: each has its own module variables, in one process of the machine.

`rclpy.init()` keeps its context in a variable of a module, and so does code that is written for a process of its own.
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

_PROCESS = "ros2 process"


def process_of(node: Node | None) -> Process | None:
    """The process of a ROS 2 system that a node of the kernel runs in; None: in none."""
    process = None if node is None else node.own.get(_PROCESS)
    return process if isinstance(process, Process) else None


@dataclass(frozen=True, eq=False)  # a key by identity: what it is of need not be hashable
class ModuleVariable:
    """A variable of a module, which functions of the module set; and what it is when the module has been imported."""

    module: dict[str, Any]
    name: str
    initial: Any


@cache
def _set_by_functions(file: str) -> frozenset[str]:
    """The names that functions of a file declare as `global`."""
    try:
        source = Path(file).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return frozenset()  # an extension module, or one without a source
    if "global " not in source:  # parsing every module of a distribution takes seconds
        return frozenset()
    declared = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Global)]
    return frozenset(name for statement in declared for name in statement.names)


class ModuleVariables:
    """The variables that functions of some packages set, each with its value after the import.

    Args:
        packages: by name.
    """

    def __init__(self, packages: Iterable[str]) -> None:
        self._packages = frozenset(package.partition(".")[0] for package in packages)
        self._known: set[str] = set()
        self._variables = [ModuleVariable(vars(sys), "argv", sys.argv), ModuleVariable(vars(os), "environ", os.environ)]

    def __iter__(self) -> Iterator[ModuleVariable]:
        return iter(self._variables)

    def update(self) -> None:
        """Know those of the modules that were imported since; to be called before a function of them is."""
        for name, module in list(sys.modules.items()):
            if name in self._known or name.partition(".")[0] not in self._packages:
                continue
            if not getattr(module.__spec__, "_initializing", False):  # else it is in the middle of its import
                self._known.add(name)
                self._add(module)

    def _add(self, module: ModuleType) -> None:
        names = vars(module)
        file = names.get("__file__") or ""
        for name in sorted(_set_by_functions(str(file)) & names.keys()):
            self._variables.append(ModuleVariable(names, name, names[name]))


class Process:
    """One process of a system: the variables have its values only while its kernel nodes run.

    It ends when its main function and its threads have ended, in whatever way; daemon threads end with it, wherever
    they are.

    Args:
        variables: that it has values of its own of.
        arguments: its command line, `sys.argv`.
        name: of its terminal.
        environ: its variables of the environment, `os.environ`; None: those of the session.
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
        """Called when it ends: its entities in the graph end with it."""
        self._has_ended = False
        self._going = 0
        self._daemons: list[Node] = []
        self._nodes: list[Node] = []
        """The main one, and its threads."""
        self._signal: int | None = None
        self.was_interrupted: int | None = None
        """The signal that ended what it did; None if none has."""

    def wrap(self, body: Body, *, daemon: bool = False) -> Body:
        """A body of a node of the kernel that runs in this process; its threads do, too.

        Args:
            daemon: whether the process ends without waiting for it.
        """
        self._going += not daemon

        def within() -> None:
            node = self._kernel.current()
            if self._has_ended:
                return
            if daemon:
                self._daemons.append(node)
            wrap_thread = node.wrap_thread
            node.wrap_thread = lambda thread, daemon: wrap_thread(self.wrap(thread, daemon=daemon), daemon)
            # The last to go on: what it raises must not keep the others from it.
            node.leaving.insert(0, self._interruptible)
            node.leaving.append(self._leave)
            node.own[_PROCESS] = self
            self._nodes.append(node)
            if HAS_TERMINALS:
                sits_at(node, self._name, is_main=not self._has_main)
                self._has_main = True
            self._enter()
            try:
                body()
            finally:
                self._leave()
                node.leaving.remove(self._leave)
                node.leaving.remove(self._interruptible)
                self._going -= not daemon
                if not self._going:
                    self._end()

        return within

    def _end(self) -> None:
        """Once: as the system ends a process, without a word to its threads."""
        if self._has_ended:
            return
        self._has_ended = True
        for node in self._daemons:
            if not node.ended:
                node.leave_for_ever()
        for end in self.at_end:
            end()

    def interrupt(self, number: int) -> None:
        """Deliver a signal: what it raises is raised where the process waits, at this instant.

        SIGINT raises KeyboardInterrupt in its main thread. SIGTERM, which `rclpy` handles, lets its spinning end, and
        ends what does not use `rclpy`; SIGKILL ends it.
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
            # A variable that a process has set is its own from then on, even if it has the initial value again.
            if value is not variable.initial or variable in self._values:
                self._values[variable] = value
                variable.module[variable.name] = variable.initial
        return self._enter
