"""Runs the installed `rclpy` in virtual time, by replacing its C++ extension before `rclpy` is imported.

`replace_extension` does so once per process; `system.prepare` calls it, or the process that imports the code under
test for coverage (`Ros2Execution.before_imports`). `Ros2Overlay` calls `adapt_rclpy` after each import of a module.
"""

from __future__ import annotations

import asyncio
import inspect
import sys
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, MutableSet
from contextlib import contextmanager
from types import ModuleType
from typing import Any, TypeVar

from pytest_hricdv.extra.ros2.clocks import whole_ns
from pytest_hricdv.extra.ros2.executor import POLL_NS, check_entities_when_waiting
from pytest_hricdv.extra.ros2.extension import NAME, extension
from pytest_hricdv.extra.ros2.tf2 import replace_tf2
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.virtual.modules import VirtualModules

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

T = TypeVar("T", bound=Hashable)

_TYPE_SUPPORTS = "rosidl_generator_py"  # the module that imports C type supports

_VISITING_SETS = ("rclpy.executors", "rclpy.time_source", "rclpy.lifecycle.node")
"""Modules that iterate over sets of nodes. The order of a set depends on addresses, which differ between runs."""


class _TypeSupport:
    """Replaces the C type support of a message class, which must exist although nothing is converted."""

    def __getattr__(self, name: str) -> object:
        if name.startswith("__"):
            raise AttributeError(name)
        return f"{name}: not converted"


class OrderedSet(MutableSet[T]):
    """A set in insertion order: executors visit their nodes in a reproducible order."""

    def __init__(self, items: Iterable[T] = ()) -> None:
        self._items = dict.fromkeys(items)

    def __contains__(self, item: object) -> bool:
        return item in self._items

    def __iter__(self) -> Iterator[T]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def add(self, value: T) -> None:
        """Add it at the end, unless it is in it."""
        self._items[value] = None

    def discard(self, value: T) -> None:
        """Take it out, if it is in it."""
        self._items.pop(value, None)

    def copy(self) -> OrderedSet[T]:
        """Another one with the same items."""
        return OrderedSet(self._items)


def replace_extension() -> None:
    """Replace the extension by our module in this process; a second call has no effect.

    Raises:
        KernelError: `rclpy` has its real extension already.
    """
    if isinstance(sys.modules.get(NAME), ModuleType) and vars(sys.modules[NAME]).get("__file__"):
        importers = _importers()
        raise KernelError(
            f"rclpy is loaded with its real middleware, {vars(sys.modules[NAME])['__file__']}"
            f"{', for ' if importers else ''}{', '.join(importers[:_MAX_IMPORTERS])}: it has to be imported after the "
            "testbench is loaded. In a conftest, import it in the functions that use it; switch a plugin off that "
            "imports it: `pytest -p no:PLUGIN`, such as `-p no:launch_testing_ros`"
        )
    if NAME not in sys.modules:
        sys.modules[NAME] = extension()
        supports = ModuleType(_TYPE_SUPPORTS)
        vars(supports)["import_type_support"] = lambda package: _TypeSupport()
        sys.modules[_TYPE_SUPPORTS] = supports
        replace_tf2()


_MAX_IMPORTERS = 3
"""Number of modules listed in a message."""


def _importers() -> list[str]:
    """Files other than its own that have names of `rclpy`, first those of the project and of plugins."""
    files = []
    for name, module in list(sys.modules.items()):
        file = vars(module).get("__file__") if isinstance(module, ModuleType) else None
        if not file or name.partition(".")[0] in ("rclpy", "pytest_hricdv"):
            continue
        values = list(vars(module).values())
        owners = [value.__name__ if isinstance(value, ModuleType) else _module_of(value) for value in values]
        if any(isinstance(owner, str) and f"{owner}.".startswith("rclpy.") for owner in owners):
            files.append(str(file))
    return sorted(dict.fromkeys(files), key=lambda file: "site-packages" in file)


def _module_of(value: object) -> object:
    return getattr(value, "__module__", "") if isinstance(value, type) or inspect.isfunction(value) else ""


@contextmanager
def virtual_rclpy(*packages: str) -> Iterator[None]:
    """Run `rclpy` and these packages of the code under test in virtual time within the block.

    Nodes of the kernel that use them need `Kernel.virtual` with "time" and "threading".
    """
    replace_extension()
    modules = VirtualModules(["rclpy", *packages])
    modules.imported.append(adapt_rclpy)
    with modules.install():
        yield


def adapt_rclpy() -> None:
    """Adapt the loaded modules of `rclpy`: the order of sets, the waiting of executors, and tracebacks in pytest."""
    _order_sets()
    for name in [module for module in sys.modules if module.partition(".")[0] == "rclpy"]:
        vars(sys.modules[name])["__tracebackhide__"] = True
    _round_up()
    _let_asyncio_await()
    if "rclpy.executors" in sys.modules:
        check_entities_when_waiting(sys.modules["rclpy.executors"])


_IN_NS = "timeout_sec_to_nsec"


def _in_ns(timeout_sec: float | None) -> int:
    """Like `rclpy`'s function of this name, which truncates; -1: for ever."""
    return -1 if timeout_sec is None or timeout_sec < 0 else whole_ns(float(timeout_sec))


def _round_up() -> None:
    """Let what is longer than nothing be no 0 for what is loaded of `rclpy`: see `clocks.whole_ns`."""
    for name, module in [*sys.modules.items()]:
        # Not in `rclpy.utilities`, where it is defined: its callers there get the original.
        if name.partition(".")[0] == "rclpy" and name != "rclpy.utilities" and _IN_NS in vars(module):
            vars(module)[_IN_NS] = _in_ns
    _replace_once("rclpy.duration", "Duration", "__init__", _round_up_init)


def _replace_once(module: str, kind: str, method: str, replacement: Callable[[Any], Any]) -> None:
    """Replace a method of a class, unless its module is not loaded, or is in the middle of its import."""
    owner = getattr(sys.modules.get(module), kind, None)
    if owner is not None and getattr(owner, method).__module__ != __name__:
        setattr(owner, method, replacement(getattr(owner, method)))


def _round_up_init(original: Callable[..., None]) -> Callable[..., None]:
    """The initialization of a duration, which truncates."""

    def __init__(self: Any, *, seconds: float = 0, nanoseconds: float = 0) -> None:  # noqa: N807 (it takes its place)
        original(self, seconds=seconds, nanoseconds=nanoseconds)
        handle = self._duration_handle
        if handle.nanoseconds == 0 and seconds * 1e9 + nanoseconds > 0:
            handle.nanoseconds = 1

    return __init__


def _order_sets() -> None:
    """Let the loaded modules of `rclpy` create ordered sets from now on."""
    for name in _VISITING_SETS:
        if name in sys.modules:
            vars(sys.modules[name])["set"] = OrderedSet


_SUSPENDED = inspect.CO_COROUTINE | inspect.CO_GENERATOR | inspect.CO_ITERABLE_COROUTINE | inspect.CO_ASYNC_GENERATOR


def _let_asyncio_await() -> None:
    """Let tasks of asyncio await futures of `rclpy`.

    `rclpy` yields until there is a result, so that asyncio would look again and again without time passing.
    """
    _replace_once("rclpy.task", "Future", "__await__", _await_method)


def _await_method(original: Callable[..., Generator[Any, Any, Any]]) -> Callable[[Any], Generator[Any, Any, Any]]:
    """The method by which a future is awaited."""

    def __await__(self: Any) -> Generator[Any, Any, Any]:  # noqa: N807 (it takes its place)
        if _is_awaited_by_asyncio():
            while not self.done():
                yield from asyncio.sleep(POLL_NS / 1e9).__await__()
        return (yield from original(self))

    return __await__


def _is_awaited_by_asyncio() -> bool:
    """Whether a task of asyncio runs the coroutine that is called; an executor that it spins may run another one."""
    try:
        task = asyncio.current_task()
    except RuntimeError:  # no event loop runs here
        return False
    coroutine = task.get_coro() if task is not None else None
    outermost = getattr(coroutine, "cr_frame", None) or getattr(coroutine, "gi_frame", None)
    frame = inspect.currentframe()
    frame = frame.f_back if frame is not None else None
    while frame is not None and frame.f_code.co_flags & _SUSPENDED:
        if frame is outermost:
            return True
        frame = frame.f_back
    return False
