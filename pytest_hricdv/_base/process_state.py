"""`ProcessState`: process-wide state that the session needs, restored after each run of the code under test.

Deleting something, or replacing it by an object that is not callable, is a fault of the run. A callable replacement, as
libraries make when they are imported, is in place again in the next run, and only there: pytest, reports and other
tests never see it. `case.execute` makes a `ProcessState` for each run; `self_check` tests such replacements.
"""

from __future__ import annotations

import builtins
import contextlib
import gc
import logging
import operator
import os
import pathlib
import signal
import sys
import threading
import tracemalloc
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

import greenlet
import msgspec
import pytest

from pytest_hricdv._base import self_check
from pytest_hricdv._base.descriptors import StandardDescriptors
from pytest_hricdv._base.message import list_names
from pytest_hricdv._base.self_check import places_of_change

# Bound on import, before code under test can replace them: restoring uses them.
_CALLABLE, _SETATTR, _DICT, _HASATTR = callable, setattr, dict, hasattr
_MODULES = sys.modules
_MODULE, _ISINSTANCE = types.ModuleType, isinstance
_SET_IN_MODULE = types.ModuleType.__setattr__
_ALL, _MAP, _IS = all, map, operator.is_
# `signal.getsignal` makes an enumeration's member of each answer, which takes a fifth of the time of `put_back`.
_HANDLER: Callable[[int], Any] = import_module("_signal").getsignal
_HANDLE, _MASK = signal.signal, getattr(signal, "pthread_sigmask", None)
_SIGNALS = tuple(map(int, signal.valid_signals()))
_VALUES = {("os", "environ")} | {
    ("sys", name) for name in ("stdin", "stdout", "stderr", "__stdin__", "__stdout__", "__stderr__")
}


def _set(kept: types.ModuleType | type, name: str, value: object) -> None:
    """Set it as it was, even if a module refuses changes meanwhile."""
    (_SET_IN_MODULE if _ISINSTANCE(kept, _MODULE) else _SETATTR)(kept, name, value)


def _umask() -> int:
    mask = os.umask(0o77)
    os.umask(mask)
    return mask


def _count_traced_frames() -> int:
    return tracemalloc.get_traceback_limit() if tracemalloc.is_tracing() else 0


def _trace_memory(frames: int) -> None:
    tracemalloc.stop()
    if frames:
        tracemalloc.start(frames)


_SETTINGS: tuple[tuple[Callable[[], Any], Callable[[Any], object]], ...] = (
    (gc.get_debug, gc.set_debug),
    (lambda: [*gc.callbacks], lambda callbacks: gc.callbacks.__setitem__(slice(None), callbacks)),
    (gc.get_threshold, lambda threshold: gc.set_threshold(*threshold)),
    (gc.isenabled, lambda enabled: gc.enable() if enabled else gc.disable()),
    (sys.getswitchinterval, sys.setswitchinterval),
    (sys.get_int_max_str_digits, sys.set_int_max_str_digits),
    (threading.stack_size, threading.stack_size),
    (sys.getrecursionlimit, sys.setrecursionlimit),
    (sys.get_coroutine_origin_tracking_depth, sys.set_coroutine_origin_tracking_depth),
    (_count_traced_frames, _trace_memory),
    (_umask, os.umask),
)
"""Process-wide settings: a getter and a setter for each."""

_MADE: dict[tuple[str, str], tuple[object, object]] = {}
"""Replacements by code in runs of this process: module or class and name -> the original and the present value."""

_THIRD = (greenlet, msgspec, msgspec.json, pytest)
_CLASSES: tuple[type, ...] = (pathlib.Path, pathlib.PurePath, logging.Handler, logging.Logger)
_LIBRARY = {
    id(module): (name, module)  # once where it has several names, under that of its users: posixpath, os.path
    for name, module in [*sys.modules.items()]
    if name.partition(".")[0] in sys.stdlib_module_names and type(module) is types.ModuleType
}
_KEPT: Mapping[str, types.ModuleType | type] = (
    dict(_LIBRARY.values())
    | {module.__name__: module for module in _THIRD}
    | {f"{kind.__module__.partition('.')[0]}.{kind.__name__}": kind for kind in _CLASSES}
)
"""All loaded modules of Python's library: pytest uses many of them, and each of them may use the others."""

_OWN = sys.stdlib_module_names | {
    "_pytest",
    "coverage",
    "execnet",
    "greenlet",
    "jinja2",
    "lark",
    "markupsafe",
    "msgspec",
}
_OWN |= {"pluggy", "pytest", "pytest_hricdv", "xdist"}
"""Packages whose modules the session imports itself; others may be taken out of `sys.modules`, to import them again."""


def _finds(finder: Any) -> bool:
    """Whether a module finder works: a finder that raises would break every import of the session."""
    try:
        spec = finder.find_spec(_NO_MODULE, None)
    except Exception:  # whatever it raises
        return not hasattr(finder, "find_spec")  # Python asks the next one
    return spec is None or hasattr(spec, "loader")


def _hooks(hook: Any) -> bool:
    """Whether a path hook works; it raises ImportError for folders that are not its own."""
    try:
        hook(_NO_MODULE)
    except ImportError:
        pass
    except Exception:
        return False
    return True


_NO_MODULE = "pytest_hricdv_asks_for_no_module"
_FINDERS: Mapping[str, Callable[[Any], bool]] = {"path": lambda entry: True, "meta_path": _finds, "path_hooks": _hooks}
"""Lists of `sys` by which Python imports -> whether an entry that code has added may stay."""


class Finders:
    """A snapshot of how Python finds modules."""

    def __init__(self) -> None:
        self._found = [(name, finders, [*finders]) for name in _FINDERS for finders in [getattr(sys, name)]]

    def put_back(self) -> Iterator[str]:
        """Remove finders that block every import, and restore emptied lists; yields the lists with removed finders."""
        for name, finders, before in self._found:
            kept = [finder for finder in finders if any(finder is other for other in before) or _FINDERS[name](finder)]
            if len(kept) < len(finders):
                yield f"sys.{name}"
            finders[:] = kept or before
            setattr(sys, name, finders)


@contextlib.contextmanager
def hide_arguments() -> Iterator[None]:
    """Hide the command line: code that parses one, in a run or where it is imported, must not get that of pytest."""
    before, sys.argv = sys.argv, sys.argv[:1]
    try:
        yield
    finally:
        sys.argv = before


class ProcessState:
    """A snapshot of the process, taken before replacements of earlier runs are put in place again."""

    def __init__(self) -> None:
        self._names = {name: _DICT(kept.__dict__) for name, kept in _KEPT.items()}
        self._modules = _DICT(_MODULES)
        self._is_main = threading.current_thread() is threading.main_thread()
        self._handlers = {number: _HANDLER(number) for number in _SIGNALS}
        self._mask = _MASK(signal.SIG_BLOCK, ()) if _MASK is not None else None
        self._folder = _folder()
        self._variables = _DICT(os.environ)
        self._finders = Finders()
        self._settings = [ask() for ask, _ in _SETTINGS]
        self._descriptors = StandardDescriptors()
        for (kept, name), (before, made) in _MADE.items():
            if _KEPT[kept].__dict__.get(name) is before:
                _set(_KEPT[kept], name, made)

    def put_back(self, code: Iterable[str] = ()) -> tuple[str, ...]:
        """Restore everything; returns a sentence for each forbidden thing that the code did to the process.

        Args:
            code: names of the modules and packages under test.
        """
        changes = self._changes()
        lost = [*self._put_back_lost(changes), *self._put_back_modules(), *self._finders.put_back()]
        wrong = self_check.wrong_answers()
        for kept, name, before, made in changes:
            is_lost = _KEPT[kept].__dict__.get(name) is before
            if not is_lost and (_CALLABLE(before) or (kept, name) in _VALUES):
                _MADE[kept, name] = before, made
                _set(_KEPT[kept], name, before)
        self._descriptors.put_back()
        self._put_back_signals()
        if self._folder != _folder():
            with contextlib.suppress(OSError):
                os.chdir(self._folder)
        for name, value in self._variables.items():
            os.environ.setdefault(name, value)
        for (ask, set_again), setting in zip(_SETTINGS, self._settings, strict=True):
            if ask() != setting:
                set_again(setting)
        return (*([complaint(lost, code)] if lost else ()), *([self_check.complaint(wrong, code)] if wrong else ()))

    def _changes(self) -> list[tuple[str, str, object, object]]:
        """Module or class, name, what was there, and what is there now."""
        found: list[tuple[str, str, object, object]] = []
        for kept, before in self._names.items():
            now = _KEPT[kept].__dict__.get  # once for all its names: there are thirteen thousand
            if _ALL(_MAP(_IS, before.values(), _MAP(now, before))):
                continue
            found += [
                (kept, name, value, now(name))
                for name, value in before.items()
                if now(name) is not value and value is not None
            ]
        return found

    def _put_back_lost(self, changes: Iterable[tuple[str, str, object, object]]) -> Iterator[str]:
        for kept, name, before, taken in changes:
            # Not values that may well be None, such as an emptied cache.
            is_whole = type(before) is _MODULE or name == "environ" or type(before).__module__ == kept.partition(".")[0]
            is_lost = not _CALLABLE(taken) if _CALLABLE(before) else taken is None and is_whole
            if is_lost:
                _set(_KEPT[kept], name, before)
                yield f"{kept}.{name}"

    def _put_back_modules(self) -> Iterator[str]:
        sys.modules = _MODULES
        if _MODULES.get("sys") is not sys or _MODULES.get("builtins") is not builtins:
            _MODULES.update(self._modules)
            yield "sys.modules"
            return
        own = [
            name
            for name, module in self._modules.items()
            if _MODULES.get(name) is not module and name.partition(".")[0] in _OWN
        ]
        for name in own:
            _MODULES[name] = self._modules[name]
        if own:
            yield f"sys.modules[{min(own)!r}]"

    def _put_back_signals(self) -> None:
        for number, handler in self._handlers.items():
            if self._is_main and handler is not None and _HANDLER(number) is not handler:
                _HANDLE(number, handler)
        if _MASK is not None:
            _MASK(signal.SIG_SETMASK, self._mask)


def _folder() -> str:
    """The current folder; empty if it was removed."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def complaint(names: Sequence[str], code: Iterable[str]) -> str:
    """A sentence on what was restored, and where modules under test had changed it."""
    place = next((f" at {place}" for place in places_of_change(names, code)), "")
    return (
        f"the code under test changed {list_names(names, 5)} for the whole process{place}, pytest included; it was "
        "restored: change it in the code's own modules only"
    )
