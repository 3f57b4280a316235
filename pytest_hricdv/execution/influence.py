"""`Influence` detects whether people, sensors or the world had any effect on the code under test in a run.

Code that connects to a bus of its own gets no messages of the testbench, and passes every test. A run *reached* the
code if a node of the code took a message from outside it or was woken from outside, or if the code shares an object,
such as a queue or a device, with people, sensors or the world. `case.execute` gives each run an `Influence` and a
`ParameterLog`; the feature `unused` reports code that no run reached, and parameters that no run read.
"""

from __future__ import annotations

import gc
import logging
import re
import sys
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import Enum
from functools import partial
from io import IOBase
from types import BuiltinFunctionType, CellType, CodeType, FrameType, FunctionType, MethodType, ModuleType
from typing import Any
from zlib import crc32

from pytest_hricdv.runtime import Bus, Kernel, Node

MAX_OBJECTS = 100_000
"""Maximum number of objects of the code that are searched for shared ones; code with more counts as reached."""

MAX_SECONDS = 600
"""Length (simulated s) of the part of a run whose waits are compared with those of other runs (`Influence.waits`)."""

_LEAVES = (
    *(ModuleType, CodeType, FrameType, BuiltinFunctionType, Enum, IOBase, re.Pattern),
    *(logging.Logger, logging.Handler, logging.Manager),
)
_WEAK: tuple[type, ...] = (weakref.ref, weakref.ProxyType, weakref.CallableProxyType)
_IMMUTABLE = (
    str,
    bytes,
    int,
    float,
    complex,
    tuple,
    frozenset,
    type(None),
    FunctionType,
    MethodType,
    CellType,
    partial,
)


class ParameterLog(dict[str, float]):
    """The parameters of a run, which record which of them are read. Copying all of them counts as reading each.

    Attributes:
        unread: names that nobody has read.
    """

    def __init__(self, parameters: Mapping[str, float]) -> None:
        super().__init__(parameters)
        self.unread = set(parameters)

    def __getitem__(self, name: str) -> float:
        self.unread.discard(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """See `dict`."""
        self.unread.discard(name)
        return super().get(name, default)

    def __iter__(self) -> Iterator[str]:
        self.unread.clear()
        return super().__iter__()

    def items(self) -> Any:
        """See `dict`."""
        self.unread.clear()
        return super().items()

    def values(self) -> Any:
        """See `dict`."""
        self.unread.clear()
        return super().values()

    def __or__(self, other: Any) -> Any:
        return dict(self) | other

    def copy(self) -> dict[str, float]:
        """See `dict`."""
        return dict(self)


class Influence:
    """Detects in one run whether anything influenced the code under test.

    Args:
        is_code: whether a node, or None for the world and the kernel, is one of the code under test.
        packages: the packages of the code under test.
    """

    def __init__(
        self, kernel: Kernel, bus: Bus, is_code: Callable[[Node | None], bool], packages: Iterable[str]
    ) -> None:
        self._kernel = kernel
        self._bus = bus
        self._is_code = is_code
        self._packages = tuple(packages)
        self.waits = ""
        """A digest of the code's waits until each simulated second, four digits each, if nothing reached the code in a
        run that has ended; otherwise empty."""
        self._is_seen = False
        self._digest = 0
        self._digests: list[int] = []
        kernel.notice_wake, kernel.notice_wait = self._notice_wake, self._notice_wait
        bus.notice_taking = self._notice_taking

    def _notice_wake(self, node: Node) -> None:
        if self._is_code(node) and not self._is_code(self._kernel.own_node()):
            self._see()

    def _notice_wait(self, node: Node, timeout_s: float | None) -> None:
        if self._is_code(node):
            self._fill(min(int(self._kernel.now_s), MAX_SECONDS))
            self._digest = crc32(repr((node.name, self._kernel.now_us, timeout_s)).encode(), self._digest)

    def _fill(self, seconds: int) -> None:
        self._digests += [self._digest & 0xFFFF] * (seconds - len(self._digests))

    def _notice_taking(self) -> None:
        if self._is_code(self._kernel.own_node()):
            self._see()

    def _see(self) -> None:
        self._is_seen = True
        self._stop()

    def _stop(self) -> None:
        self._kernel.notice_wake = self._kernel.notice_wait = self._bus.notice_taking = None

    def finish(self) -> None:
        """Decide, while the nodes are still where they wait."""
        if not self._is_seen:
            self._fill(min(int(self._kernel.now_s), MAX_SECONDS))
            self.waits = "" if self._may_share() else "".join(f"{digest:04x}" for digest in [0, *self._digests])
        self._stop()

    def _may_share(self) -> bool:
        """Whether the code shares an object with others, or has ended so that its objects are not known."""
        nodes = self._kernel.nodes
        waiting = [node for node in nodes if self._is_code(node) and node.frame is not None]
        if not waiting:
            return True
        roots = [
            value for node in waiting for frame in _frames(node) if self._is_of_code(frame) for value in _values(frame)
        ]
        others: list[Any] = [self._kernel.world]
        for node in nodes:
            if not self._is_code(node):
                others += [node.body, *(value for frame in _frames(node) for value in _values(frame))]
        own = self._follow(roots, with_globals=False)
        theirs = self._follow(others, with_globals=True)
        return own is None or theirs is None or bool(own.keys() & theirs.keys())

    def _is_of_code(self, frame: FrameType) -> bool:
        return self._is_package(frame.f_globals.get("__name__", ""))

    def _is_package(self, module: object) -> bool:
        return any(module == name or str(module).startswith(f"{name}.") for name in self._packages)

    def _follow(self, roots: Iterable[Any], *, with_globals: bool) -> dict[int, Any] | None:
        """The mutable objects reachable from some objects, by id; None if there are too many.

        Args:
            roots: the first objects. with_globals: whether globals of the modules of functions and classes count, too.
        """
        found: dict[int, Any] = {}
        kept: dict[int, Any] = {}  # an id is of one object as long as it is kept
        modules: set[str] = set()
        pending = list(roots)
        while pending:
            value = pending.pop()
            if issubclass(type(value), _WEAK):
                value = _target(value)
            is_named = isinstance(value, FunctionType | type)
            module = getattr(value if is_named else type(value), "__module__", "")
            if id(value) in kept or isinstance(value, _LEAVES) or _is_of_tool(module):
                continue
            kept[id(value)] = value
            if len(kept) > MAX_OBJECTS:
                return None
            is_testbench = self._is_testbench(module)
            if is_testbench if isinstance(value, type) else not isinstance(value, _IMMUTABLE):
                found[id(value)] = value
            if is_testbench and with_globals and module not in modules:
                modules.add(module)
                pending += vars(sys.modules[module]).values()
            pending += _referents(value, is_class_followed=is_testbench)
        return found

    def _is_testbench(self, module: object) -> bool:
        """Whether a module is of the testbench: not of Python, not installed, and not the code's own."""
        if not isinstance(module, str) or module not in sys.modules or self._is_package(module):
            return False
        file = getattr(sys.modules[module], "__file__", None) or ""
        top = module.partition(".")[0]
        return top not in (*sys.stdlib_module_names, "pytest_hricdv") and "-packages" not in file


def _is_of_tool(module: object) -> bool:
    """Bus, kernel and record, which all have, and whose use is noticed; stand-ins of Python's modules are others."""
    name = str(module)
    return name.startswith(("pytest_hricdv.", "greenlet")) and not name.startswith("pytest_hricdv.runtime.virtual")


def _frames(node: Node) -> Iterator[FrameType]:
    frame = node.frame
    while frame is not None:
        yield frame
        frame = frame.f_back


def _values(frame: FrameType) -> list[Any]:
    return list(frame.f_locals.values())


def _referents(value: Any, *, is_class_followed: bool) -> list[Any]:
    """The referents of an object; for a class, its attributes and the referents of its methods."""
    if isinstance(value, type):
        return (
            [attribute for name, attribute in vars(value).items() if _is_own(name, attribute)]
            if is_class_followed
            else []
        )
    if isinstance(value, FunctionType):
        if value.__globals__.get("__name__") == "reprlib":
            return []  # all representations of a dataclass share what is being written
        return [*(value.__closure__ or ()), *(value.__defaults__ or ()), *(value.__kwdefaults__ or {}).values()]
    return gc.get_referents(value) if gc.is_tracked(value) else []


def _target(weak: Any) -> Any:
    """What a weak reference or a proxy refers to; None if it is gone."""
    try:
        return weak() if isinstance(weak, weakref.ref) else weak.__reduce_ex__.__self__
    except ReferenceError:
        return None


def _is_own(name: str, attribute: object) -> bool:
    return isinstance(attribute, FunctionType) or not name.startswith("__")
