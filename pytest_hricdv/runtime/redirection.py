"""Redirects functions such as `time.sleep` to others in place, so that it affects every reference to them.

`runtime.virtual` and `random_numbers` install a `Redirection` during a run, for clocks, blocking calls and random
numbers; `original` gives a function that stays as it is. A function in Python gets another code object. In a function
in C, the pointers to its definition and module are replaced by `PyObject_Call` and a callable (CPython's layout).
"""

from __future__ import annotations

import ctypes
import gc
import platform
import sys
import time
from collections.abc import Iterable, Sequence
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, ModuleType
from typing import Any

_ADDRESS = ctypes.c_void_p
_ANY_ARGUMENTS = 3
"""METH_VARARGS | METH_KEYWORDS of Python's `methodobject.h`."""


class _Definition(ctypes.Structure):
    """A PyMethodDef: the function, and how it takes its arguments."""

    _fields_ = (("name", ctypes.c_char_p), ("call", _ADDRESS), ("flags", ctypes.c_int), ("text", ctypes.c_char_p))


class _Builtin(ctypes.Structure):
    """A PyCFunctionObject."""

    _fields_ = (
        ("head", ctypes.c_char * object.__basicsize__),
        *((name, _ADDRESS) for name in ("definition", "owner", "module", "references", "vectorcall")),
    )


_call = ctypes.cast(ctypes.pythonapi.PyObject_Call, _ADDRESS).value
_make = ctypes.PYFUNCTYPE(ctypes.py_object, _ADDRESS, ctypes.py_object, ctypes.py_object)(
    ("PyCFunction_NewEx", ctypes.pythonapi)
)


def is_redirectable(function: object) -> bool:
    """Whether it is a function in Python, or one in C of a module."""
    is_in_c = type(function) is BuiltinFunctionType and issubclass(type(function.__self__), ModuleType)
    return is_in_c or type(function) is FunctionType


def original(function: Any, closure: tuple[CellType, ...] | None = None) -> Any:
    """A function that does what this one does now, and goes on doing so when this one is redirected.

    Args:
        closure: other variables of it, for a function in Python.
    """
    if not is_redirectable(function):
        return function
    if id(function) in _ORIGINALS:
        return _ORIGINALS[id(function)]
    if type(function) is BuiltinFunctionType:
        return _make(_Builtin.from_address(id(function)).definition, function.__self__, function.__module__)
    closure = closure or function.__closure__
    copy = FunctionType(function.__code__, function.__globals__, function.__name__, function.__defaults__, closure)
    copy.__kwdefaults__ = function.__kwdefaults__
    return copy


def redirect(function: Any, other: Any) -> None:
    """Let a function in C call another one from now on."""
    kind, name, _, call = _redirect(function, other)
    setattr(kind, name, call)


def replace_in_class(kind: type, name: str, value: object) -> Any:
    """Replace an attribute of a class in C, which refuses to be changed; returns what it was."""
    (names,) = gc.get_referents(vars(kind))
    before, names[name] = names[name], value
    ctypes.pythonapi.PyType_Modified(ctypes.py_object(kind))
    return before


class Redirection:
    """Functions that call others while it is installed, and do what they did before at all other times.

    Args:
        pairs: functions, and Python functions that take their place; what is not a function is left alone.
    """

    def __init__(self, pairs: Iterable[tuple[Any, Any]]) -> None:
        redirected = [pair for pair in pairs if is_redirectable(pair[0])]
        keyed = _containers_by_key([function for function, _ in redirected])
        self._redirected = [_redirect(*pair) for pair in redirected]
        self._depth = 0
        for container in keyed:
            items = [*(container.items() if isinstance(container, dict) else container)]
            container.clear()
            container.update(items)

    def install(self) -> None:
        """Let them call the others; within another installation, nothing changes."""
        self._depth += 1
        for owner, name, _, other in self._redirected if self._depth == 1 else ():
            setattr(owner, name, other)

    def remove(self) -> None:
        """Let them do what they did before."""
        self._depth -= 1
        for owner, name, before, _ in self._redirected if self._depth == 0 else ():
            setattr(owner, name, before)


def _containers_by_key(functions: Sequence[Any]) -> list[dict[Any, Any] | set[Any]]:
    """Dictionaries and sets that have one of these as a key, as `os.supports_fd`: another hash is as another key."""
    identities = {*map(id, functions)}
    referring = gc.get_referrers(*functions)
    return [
        holder for holder in referring if type(holder) in (dict, set) and not identities.isdisjoint(map(id, holder))
    ]


def _redirect(function: Any, other: Any) -> tuple[Any, str, Any, Any]:
    """Whose attribute decides what a function does, its name, and its values."""
    if type(function) is FunctionType:
        return function, "__code__", function.__code__, _code_that_calls(other, function.__code__)
    before = staticmethod(_ORIGINALS.setdefault(id(function), original(function)))
    # A module, as `repr` and `pickle` ask whether it is one.
    kind = type(function.__name__, (ModuleType,), {"__call__": before})
    owner, builtin = kind(str(function.__module__)), _Builtin.from_address(id(function))
    was = _Definition.from_address(builtin.definition)
    definition = _Definition(was.name, _call, _ANY_ARGUMENTS, was.text)
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(owner))  # the function refers to it from now on
    _KEPT.append((definition, function))
    # Once, as its hash is made of these, and it may be a key. And at once: no other thread runs in between.
    builtin.definition, builtin.owner, builtin.vectorcall = ctypes.addressof(definition), id(owner), None
    return kind, "__call__", before, staticmethod(other)


_KEPT: list[object] = []
"""The functions in C that were redirected, and what they refer to."""
_ORIGINALS: dict[int, Any] = {}
"""Identity of such a function -> one that does what it did before."""


def _call_other(*arguments: Any, **keywords: Any) -> Any:
    other: Any = "the other function"
    return other(*arguments, **keywords)


def _code_that_calls(other: object, code: CodeType) -> CodeType:
    """The code of a function that calls another one; it has as many variables of a closure as the former code."""
    pattern: Any = _call_other.__code__
    constants = tuple(other if value == "the other function" else value for value in pattern.co_consts)
    made: CodeType = pattern.replace(co_consts=constants, co_freevars=code.co_freevars, co_name=code.co_name)
    return made


def _check() -> None:
    """Raise RuntimeError unless this Python has functions as described here."""
    sample = time.localtime
    builtin, size = _Builtin.from_address(id(sample)), BuiltinFunctionType.__basicsize__
    is_known = size == ctypes.sizeof(_Builtin) and BuiltinFunctionType.__weakrefoffset__ == _Builtin.references.offset
    is_known = is_known and builtin.owner == id(time) and builtin.module == id(sample.__module__)
    is_known = is_known and getattr(sys, "_is_gil_enabled", lambda: True)()
    if not is_known or _Definition.from_address(builtin.definition).name != b"localtime":
        raise RuntimeError(
            f"pytest-hricdv does not know how {platform.python_implementation()} {platform.python_version()} keeps "
            "functions in C; expected CPython with its global lock"
        )


_check()
