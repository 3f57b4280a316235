"""Forbids what code in a run must not do to its process, because it could not be undone for the session.

Nodes may not use libraries that read a keyboard without standard input, or draw on the terminal (`refuse_in_nodes`):
`curses` sets the terminal that pytest was started in; `pynput` and `keyboard` listen to the machine's keyboard.

Most of `builtins` may not be replaced (`keep_builtins`): `builtins.zip = None` would hold for the kernel, for the
monitors and for pytest as well, and what fails then has nothing to do with it. The line that does so is refused.

Other functions here say which calls `outside` refuses, such as closing descriptors of the session.
"""

from __future__ import annotations

import builtins
import math
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import wraps
from types import BuiltinFunctionType, FrameType, FunctionType, ModuleType
from typing import Any

from pytest_hricdv._base.descriptors import OWN, STANDARD
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.reach import is_library_of_python
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError, RealTimeError

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

ROOTS = frozenset({"curses", "_curses", "pynput", "keyboard"})
"""Packages that read a keyboard, or draw on the terminal."""

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
    """A module whose functions and classes no node may call; what is not code, as `curses.KEY_UP`, is as it is."""

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


try:
    import resource
except ImportError:  # of Windows
    resource = None  # type: ignore[assignment]

WATCHDOGS = getattr(signal, "SIGVTALRM", None)
"""The signal of the watchdog, which has to come through; Windows has none."""

_SWITCHES_S = 0.1
"""The watchdog is a thread: who keeps it from running for longer (s) could keep it from looking (chosen)."""

MAX_DEPTH = 1_000_000
"""No run gets a higher limit of recursion: what is deeper takes all memory before it ends (500 bytes a call)."""

RIGHTS = (
    "chroot",
    "setuid",
    "seteuid",
    "setreuid",
    "setresuid",
    "setgid",
    "setegid",
    "setregid",
    "setresgid",
    "setgroups",
)
"""Functions of `os` that take rights from the process, which may then not write its report."""

_PEEK = os.WEXITED | os.WNOHANG | os.WNOWAIT if hasattr(os, "waitid") else 0
"""Options of `os.waitid` that look whether a process has ended, and leave it as it is; 0 without `os.waitid`."""

_LIMITS = ("RLIMIT_NOFILE", "RLIMIT_FSIZE", "RLIMIT_AS", "RLIMIT_DATA", "RLIMIT_NPROC", "RLIMIT_STACK")
_LIMITED = frozenset(getattr(resource, name) for name in _LIMITS if hasattr(resource, name))


def takes_away(name: str, args: tuple[Any, ...], depth: int) -> bool:
    """Whether a call leaves the session with less than it had.

    Args:
        name: the function's name, with its module.
        args: the arguments of the call.
        depth: the limit of recursion when the run began.
    """
    match name, args:
        case "sys.addaudithook" | "sys.stdout.close" | "sys.stderr.close", _:
            return True
        case _ if name.removeprefix("os.") in RIGHTS:
            return True
        case "os.close", (int(number),):
            return number in OWN
        case "os.closerange", (int(first), int(end)):
            return any(first <= number < end for number in OWN)
        case "os.dup2", (_, int(number), *_):
            return number in OWN.difference(STANDARD)
        case "abc.ABCMeta.register", (kind, subclass):
            return subclass.__module__ == "builtins" and is_library_of_python(kind.__module__)
        case "signal.signal", (number, _):
            return bool(number == WATCHDOGS)
        case "sys.setswitchinterval", (interval_s,):
            return float(interval_s) > _SWITCHES_S
        case "sys.setrecursionlimit", (int(limit),):
            return limit < depth
        case "resource.setrlimit" | "resource.prlimit", (*_, what, (int(soft), int(hard))) if what in _LIMITED:
            now_soft, now_hard = map(_amount, resource.getrlimit(what))
            return _amount(soft) < now_soft or _amount(hard) < now_hard
    return False


def is_of_session(name: str, args: tuple[Any, ...], caller: FrameType) -> bool:
    """Whether this plugin makes a call, or a library of Python that registers a class when it is imported."""
    if caller.f_globals.get("__name__") in ("abc", "signal") and caller.f_back is not None:
        caller = caller.f_back  # a function in Python, around one in C
    module = str(caller.f_globals.get("__name__"))
    if not module.startswith("pytest_hricdv."):
        return name == "abc.ABCMeta.register" and is_library_of_python(module)
    if name == "os.close":
        OWN.difference_update(args)  # the number is free: the next one to get it may be anybody
    # Threads, pools and loops there call what the code has given to them.
    return name in ("os.close", "os.closerange", "os.dup2") or not module.startswith("pytest_hricdv.runtime.virtual.")


def ends_session(name: str, args: tuple[Any, ...]) -> bool:
    """Whether a call ends this process, or sends it a signal that the session handles and ends by.

    Not SIGINT: the code may catch the exception, and else it has the line.
    """
    match name, args:
        case (("os._exit" | "os.execv" | "os.execve"), _):
            return True
        case "signal.raise_signal", (int(number),):
            pass
        case "os.kill", (pid, int(number)) if pid in (os.getpid(), 0):
            pass
        case "os.killpg", (group, int(number)) if group in (os.getpgrp(), 0):
            pass
        case "signal.pthread_kill", (_, int(number)):
            pass
        case _:
            return False
    handler = signal.getsignal(number) if number in [*signal.Signals] and number != signal.SIGINT else None
    return str(getattr(handler, "__module__", None)).startswith("pytest_hricdv.session.")


def is_harmless(name: str, args: tuple[Any, ...]) -> bool:
    """Whether it does not wait, as a poll, or a timer that is switched off."""
    match name.rpartition(".")[2]:
        case "sigtimedwait" | "setitimer":
            return args[1:2] == (0,)
        case "wait" | "wait3" | "wait4" | "waitpid" | "waitid" as wait:
            return _finds_child_ended(wait, args)
        case "alarm":
            return args[:1] == (0,)
        case "setrlimit":
            return args[:1] != (getattr(resource, "RLIMIT_CPU", None),)
        case "addaudithook" | "setrecursionlimit" | "setswitchinterval" | "prlimit" | "signal" | "pthread_sigmask":
            return True
        case "close" | "closerange" | "dup2" | "register" | "_exit" | "execv" | "execve":
            return True
        case "kill" | "killpg" | "raise_signal" | "pthread_kill":
            return True
    return False


def _finds_child_ended(name: str, args: tuple[Any, ...]) -> bool:
    """Whether a wait for processes returns at once, as one has ended, or there is none."""
    options = args[-1] if args else 0
    if options & getattr(os, "WNOHANG", 0):
        return True
    if not _PEEK:
        return False  # nobody can look, as on macOS before Python 3.13 and on Windows
    match name, args:
        case "waitid", (kind, number, _):
            pass
        case "waitpid" | "wait4", (int(number), _) if number > 0:
            kind = os.P_PID
        case _:
            kind, number = os.P_ALL, 0
    try:
        return os.waitid(kind, number, _PEEK) is not None
    except ChildProcessError:
        return True


def _amount(limit: int) -> float:
    return math.inf if limit == resource.RLIM_INFINITY else limit


# Names that libraries replace, as `rich` does with `print`: the session uses none of these, and restores them
# afterwards.
_REPLACEABLE = {"__import__", "breakpoint", "copyright", "credits", "exit", "help", "input", "license", "open", "print"}
_NAMES = frozenset(vars(builtins)) - _REPLACEABLE - {"_", "quit", "__doc__", "__loader__", "__spec__"}


class _Builtins(ModuleType):
    """The module `builtins`, of which names can be added and no other be changed."""

    def __setattr__(self, name: str, value: Any) -> None:
        if vars(builtins).get(name) is not value:
            _refuse_name(name)
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        _refuse_name(name)
        super().__delattr__(name)


@contextmanager
def keep_builtins() -> Iterator[None]:
    """Refuse to replace what everybody uses. Raises ProhibitedError if somebody does."""
    before = builtins.__class__
    builtins.__class__ = _Builtins
    try:
        yield
    finally:
        builtins.__class__ = before


def _refuse_name(name: str) -> None:
    if name in _NAMES:
        raise ProhibitedError(
            f"{place_of(sys._getframe(2))}: builtins.{name} is changed for the whole process, pytest included: change "
            "it in the code's own modules only"
        )
