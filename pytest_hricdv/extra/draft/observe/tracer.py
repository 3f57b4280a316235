"""`BorderTracer`: records calls between a package and the rest of a program, for `hricdv record`.

It is installed in each process of the recorded program by `sitecustomize` (see `extra.draft.record`), and sees calls of
Python functions through `sys.setprofile`. The arguments of functions in C are not visible there.
"""

from __future__ import annotations

import atexit
import dis
import inspect
import json
import os
import sys
import sysconfig
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from pytest_hricdv.extra.draft.observe.observations import Observations, Site, write_atomically
from pytest_hricdv.extra.draft.observe.shape import MAX_LENGTH, is_secret

VARIABLE = "HRICDV_RECORD"
"""The environment variable that tells a process what to record, and to which file."""

CALLBACK = "callback "
"""Prefix of the name of a function that the code has passed to a port, among the observed functions."""

LIBRARY = "library"
"""The location of a function that libraries call, as those of threads, event loops and state machines do."""

MAX_SAMPLES = 500
"""Calls of a function whose arguments are kept; all others only count."""

FLUSH_S = 2.0
"""Period at which the recording is written, as a process may be killed."""

MAX_OBJECTS = 2_000
"""Most objects that are followed."""

_RETURN = frozenset(dis.opmap[name] for name in ("RETURN_VALUE", "RETURN_CONST") if name in dis.opmap)
_LIBRARIES = tuple({sysconfig.get_path(name) + os.sep for name in ("stdlib", "platstdlib", "purelib", "platlib")})
_PLAIN = (bool, int, float, str, bytes, type(None))


@dataclass
class BorderTracer:
    """Records what crosses the border of a package.

    Args:
        folders: the folders of the package's source.
        outside: names of modules and folders in it that are not the code, as "tests" and "demo".
        file: where the recording goes; each process adds its number.
    """

    folders: Sequence[str]
    outside: Sequence[str]
    file: Path
    seen: Observations = field(default_factory=Observations)
    _own: dict[CodeType, bool] = field(default_factory=dict)
    _ports: dict[int, tuple[str, Any]] = field(default_factory=dict)
    _made: dict[int, tuple[str, Any]] = field(default_factory=dict)
    _open: dict[int, tuple[Site, FrameType]] = field(default_factory=dict)
    _states: dict[tuple[int, str], str] = field(default_factory=dict)
    _members: dict[int, tuple[str, FrameType]] = field(default_factory=dict)
    _member_ids: set[int] = field(default_factory=set)
    _flushed_s: float = 0.0

    def start(self) -> None:
        """Begin; the recording is written when the process ends, and from time to time before."""
        atexit.register(self.flush)
        if hasattr(os, "register_at_fork"):  # what the parent has seen is in its own file
            os.register_at_fork(after_in_child=lambda: setattr(self, "seen", Observations()))
        threading.setprofile(self.profile)
        sys.setprofile(self.profile)

    def flush(self) -> None:
        """Write what there is."""
        self._flushed_s = time.monotonic()
        if not self.seen.is_empty:
            write_atomically(self.file.with_name(f"{self.file.name}.{os.getpid()}"), self.seen.to_json())

    def profile(self, frame: FrameType, event: str, argument: Any) -> None:
        """Called by the interpreter at each call and return."""
        if event == "call":
            self._call(frame)
        elif event == "return":
            self._return(frame, argument)

    def _is_own(self, frame: FrameType | None) -> bool:
        if frame is None:
            return False
        code = frame.f_code
        own = self._own.get(code)
        if own is None:
            own = self._own[code] = self._is_of_package(code.co_filename)
        return own and frame.f_globals.get("__name__") != "__main__"

    def _is_of_package(self, file: str) -> bool:
        for folder in self.folders:
            if file == folder or file.startswith(folder + os.sep):
                parts = file[len(folder) :].removesuffix(".py").split(os.sep)
                return not any(part in self.outside or part.startswith("test_") for part in parts)
        return False

    def _call(self, frame: FrameType) -> None:
        back = frame.f_back
        to_own, from_own = self._is_own(frame), self._is_own(back)
        if not (to_own or from_own) or id(frame) in self._open:
            return
        if from_own and back is not None and frame.f_code.co_argcount and not frame.f_code.co_filename.startswith("<"):
            port = self._ports.get(id(_self_of(frame)))
            if port is not None and frame.f_code.co_name == "__getattr__":
                name = next(iter(_arguments(frame).values()), "")
                self._members[id(frame)] = f"{port[0]}.{name}", frame
            elif port is not None and _self_of(back) is not _self_of(frame):
                self._sample(back)
                name = frame.f_code.co_name
                is_member = name == "__call__" and id(port[1]) in self._member_ids
                self._note(self.seen.calls, port[0] if is_member else f"{port[0]}.{name}", frame, _location(back))
        elif to_own and not from_own:
            self._enter(frame)
        if time.monotonic() - self._flushed_s > FLUSH_S:
            self.flush()

    def _enter(self, frame: FrameType) -> None:
        code, owner = frame.f_code, _self_of(frame)
        if code.co_name.startswith("<"):
            return  # a module or a comprehension
        module = str(frame.f_globals.get("__name__", ""))
        if code.co_name == "__init__" and owner is not None:
            key = f"{module}:{type(owner).__qualname__}"
            if len(self._made) < MAX_OBJECTS:
                self._made[id(owner)] = (key, owner)
            self._note(self.seen.made, key, frame, "")
            self._follow(type(owner).__name__, frame)
            return
        if code.co_name.startswith("__"):
            return
        name = getattr(code, "co_qualname", code.co_name).replace("<locals>.", "")
        back = frame.f_back
        is_library = back is None or back.f_code.co_filename.startswith(("<", *_LIBRARIES))
        self._note(self.seen.methods, f"{module}:{name}", frame, LIBRARY if is_library else _location(frame))
        self._follow(code.co_name if owner is None else f"{type(owner).__name__}.{code.co_name}", frame)

    def _follow(self, owner: str, frame: FrameType) -> None:
        """Count calls of a passed object as calls at a port from now on."""
        for name, value in _arguments(frame).items():
            is_object = not isinstance(value, (*_PLAIN, list, tuple, dict, set, Enum, type))
            if is_object and len(self._ports) < MAX_OBJECTS:
                self._ports.setdefault(id(value), (f"{owner}.{name}", value))

    def _note(self, table: dict[str, Site], key: str, frame: FrameType, location: str) -> None:
        site = self.seen.site(table, key)
        if site is None:
            return
        arguments = _arguments(frame) if site.count < MAX_SAMPLES else {}
        site.add(arguments, location)
        if site.count <= MAX_SAMPLES and len(self._open) < MAX_OBJECTS:
            self._open[id(frame)] = (site, frame)

    def _return(self, frame: FrameType, value: Any) -> None:
        member = self._members.pop(id(frame), None)
        if member is not None and member[1] is frame and not isinstance(value, _PLAIN):
            self._ports.setdefault(id(value), (member[0], value))  # as of a mock: it is called as a method
            self._member_ids.add(id(value))
        waiting = self._open.get(id(frame))
        if waiting is None or waiting[1] is not frame:
            return
        is_over = frame.f_code.co_code[frame.f_lasti] in _RETURN if frame.f_lasti >= 0 else False
        if not is_over and frame.f_code.co_flags & (inspect.CO_COROUTINE | inspect.CO_GENERATOR):
            return  # it waits, and continues later
        del self._open[id(frame)]
        if is_over:
            waiting[0].result.add(value, frame.f_code.co_name)
        if self._is_own(frame):
            self._sample(frame)

    def _sample(self, frame: FrameType) -> None:
        """Look which texts the attributes of the object have whose method runs."""
        made = self._made.get(id(_self_of(frame)))
        if made is None:
            return
        key, owner = made
        for name, value in texts_of(owner).items():
            before = self._states.get((id(owner), name))
            if value != before and not is_secret(name):
                self._states[id(owner), name] = value
                self.seen.add_state(f"{key}.{name}", before, value)


def state_text(value: Any) -> str | None:
    """The text of a state: of a text, a member of an enumeration, an object for each state, or a behaviour tree."""
    if isinstance(value, Enum):
        return value.value if isinstance(value.value, str) else value.name
    if value is None or isinstance(value, str):
        return value
    if _is_tree(value):  # of py_trees
        value = value.tip()
    names = (getattr(value, "id", None), getattr(value, "name", None), type(value).__name__)
    return next((name for name in names if isinstance(name, str)), None) if value is not None else None


def _is_tree(value: Any) -> bool:
    """Whether it is of py_trees; a class of a module that is not installed has whatever it is asked for."""
    return any("tip" in vars(base) for base in type(value).__mro__)


def texts_of(owner: Any) -> Mapping[str, str]:
    """The attributes of an object, and of those in it, that are strings, members of enumerations, or own objects."""
    found: dict[str, str] = {}
    for name, value in list(getattr(owner, "__dict__", {}).items())[:100]:
        inner = getattr(value, "__dict__", None)
        is_own = type(value).__module__.partition(".")[0] == type(owner).__module__.partition(".")[0]
        parts = {f"{name}.{key}": part for key, part in list(inner.items())[:50]} if inner and is_own else {}
        for path, part in {name: value, **parts}.items():
            is_object = path == name and inner is not None and is_own
            if is_object or isinstance(part, Enum | str) or _is_tree(part):
                text = state_text(part)
                if text is not None and len(text) <= MAX_LENGTH:
                    found[path] = text
    return found


def _self_of(frame: FrameType) -> Any:
    code = frame.f_code
    return frame.f_locals.get("self") if code.co_argcount and code.co_varnames[:1] == ("self",) else None


def _arguments(frame: FrameType) -> dict[str, Any]:
    """The arguments of a call, by parameter, without `self`."""
    code, local = frame.f_code, frame.f_locals
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    arguments = {name: local[name] for name in names if name != "self" and name in local}
    if code.co_flags & inspect.CO_VARARGS:
        more = local.get(code.co_varnames[code.co_argcount + code.co_kwonlyargcount], ())
        arguments |= {str(number): value for number, value in enumerate(more)}
    if code.co_flags & inspect.CO_VARKEYWORDS:
        arguments |= local.get(code.co_varnames[len(names) + bool(code.co_flags & inspect.CO_VARARGS)], {})
    return arguments


def _location(frame: FrameType) -> str:
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


def start_by_environment() -> None:
    """Start as the environment variable says; called in each process of the recorded program."""
    asked = json.loads(os.environ[VARIABLE])
    BorderTracer(asked["folders"], asked["outside"], Path(asked["file"])).start()
