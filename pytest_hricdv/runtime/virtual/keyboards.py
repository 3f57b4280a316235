"""Libraries that read a keyboard without standard input, or draw on the terminal: nodes may not use them.

`curses` sets the terminal that pytest was started in; `pynput` and `keyboard` listen to the machine's keyboard, in
threads of their own. None of it is a person of the model.
"""

from __future__ import annotations

import sys
from functools import wraps
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.real_time import RealTimeError

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

ROOTS = frozenset({"curses", "_curses", "pynput", "keyboard"})
"""Packages, by name."""

_PARTS = (ModuleType, type, FunctionType, BuiltinFunctionType)


def is_keyboard(value: Any) -> bool:
    """Whether it is a module, a function or a class of such a library, and not of a project's own `keyboard.py`."""
    if not issubclass(type(value), _PARTS):
        return False
    name = vars(value).get("__name__") if issubclass(type(value), ModuleType) else value.__module__
    if not isinstance(name, str) or name.partition(".")[0] not in ROOTS:
        return False
    file = str(getattr(sys.modules.get(name.partition(".")[0]), "__file__", None) or "")
    return name.partition(".")[0] in sys.stdlib_module_names or "-packages" in file


class RefusingModule(ModuleType):
    """A module whose functions and classes no node may call; what is no code, as `curses.KEY_UP`, is as it is."""

    def __init__(self, real: ModuleType) -> None:
        super().__init__(real.__name__, real.__doc__)
        self.__real = real

    def __dir__(self) -> list[str]:
        return dir(self.__real)

    def __getattr__(self, name: str) -> Any:
        return refuse_in_nodes(getattr(self.__real, name))


def refuse_in_nodes(value: Any) -> Any:
    """The replacement for a member of such a library: its modules, functions and classes refuse to work in nodes."""
    if isinstance(value, ModuleType):
        return RefusingModule(value) if is_keyboard(value) else value
    if not callable(value) or (isinstance(value, type) and issubclass(value, BaseException)):
        return value
    if isinstance(value, type):
        return type(value.__name__, (value,), {"__new__": _new_that_refuses(value), "__module__": value.__module__})

    @wraps(value)
    def call(*arguments: Any, **keywords: Any) -> Any:
        _refuse(f"{value.__module__}.{value.__name__}")
        return value(*arguments, **keywords)

    return call


def _new_that_refuses(kind: type) -> Any:
    def new(cls: type, *arguments: Any, **keywords: Any) -> Any:
        _refuse(f"{kind.__module__}.{kind.__name__}")
        make: Any = kind.__new__
        return make(cls) if make is object.__new__ else make(cls, *arguments, **keywords)

    return new


def _refuse(name: str) -> None:
    node = current_node()
    if node is None:
        return
    raise RealTimeError(
        f"{place_of(sys._getframe(1))}: node {node.name} uses {name}, which reads the keyboard of this machine: a "
        "person of a model presses none of its keys. Let the node read standard input (sys.stdin, termios, select), "
        "where run.terminal(...) has a person's keys, or replace what reads the keyboard by a port"
    )
