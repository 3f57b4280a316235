"""`guard_run`: redirects clocks and blocking calls during a run, in place, so in all modules of the process.

Clocks show virtual time in nodes. What waits in real time is refused at once, with its line, where Python is the
one that waits: event loops and other selectors, processes, signals, and `time.sleep` where time is not virtual.
Event loops of nodes wait in virtual time, wherever they are made. The kernel's watchdog interrupts other waiting,
as for a lock or a socket.
"""

from __future__ import annotations

import abc
import faulthandler
import importlib
import os
import selectors
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial, wraps
from types import ModuleType
from typing import Any, NoReturn

from pytest_hricdv._base.descriptors import keep_open, leave_open
from pytest_hricdv.runtime.blocking_calls import HAS_TERMINALS, TIME, real_wait
from pytest_hricdv.runtime.kernel import Kernel, current_node
from pytest_hricdv.runtime.redirection import Redirection, original, replace_in_class
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual import clocks
from pytest_hricdv.runtime.virtual.prohibition import (
    MAX_DEPTH,
    RIGHTS,
    WATCHDOGS,
    ends_session,
    is_harmless,
    is_of_session,
    takes_away,
)
from pytest_hricdv.runtime.virtual.reach import is_tool
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError, RealTimeError

try:
    import resource
except ImportError:  # of Windows
    resource = None  # type: ignore[assignment]

if HAS_TERMINALS:
    from pytest_hricdv.runtime.virtual import terminal_calls
    from pytest_hricdv.runtime.virtual.terminal import terminal_of, terminals_of

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

# As they are now: the code under test may replace them.
_PID = os.getpid
_START = threading.Thread.start
_WAIT = subprocess.Popen.wait
_SELECTORS = tuple(
    kind
    for kind in vars(selectors).values()
    if isinstance(kind, type) and issubclass(kind, selectors.BaseSelector) and "select" in vars(kind)
)

_signal: Any = importlib.import_module("_signal")  # what those of `signal` call
_TIMERS = ("setitimer", "alarm")
_CLOCKED = frozenset((*_TIMERS, "setrlimit", "dump_traceback_later"))
_SOCKET_CALLS = ("_accept", "connect", "recv", "recv_into", "recvfrom", "recvfrom_into", "recvmsg")
_SIGNALS = ("sigwait", "sigwaitinfo", "sigtimedwait", "pause")


def _import_or_none(name: str) -> ModuleType | None:
    with suppress(ImportError):
        return importlib.import_module(name)
    return None


_REFUSED: dict[str, Callable[..., Any]] = {
    "os.system": os.system,
    **{
        f"os.{name}": getattr(os, name) for name in ("wait", "wait3", "wait4", "waitpid", "waitid") if hasattr(os, name)
    },
    **{f"signal.{name}": getattr(_signal, name) for name in (*_SIGNALS, *_TIMERS) if hasattr(_signal, name)},
    **{f"resource.{name}": getattr(resource, name) for name in ("setrlimit", "prlimit") if hasattr(resource, name)},
    "faulthandler.dump_traceback_later": faulthandler.dump_traceback_later,
    **{f"signal.{name}": getattr(_signal, name) for name in ("signal", "pthread_sigmask") if hasattr(_signal, name)},
    "abc.ABCMeta.register": abc.ABCMeta.register,
    "sys.setswitchinterval": sys.setswitchinterval,
    "sys.addaudithook": sys.addaudithook,
    "sys.setrecursionlimit": sys.setrecursionlimit,
    **{
        f"{interpreters.__name__}.{name}": getattr(interpreters, name)
        for interpreters in filter(None, map(_import_or_none, ("_xxsubinterpreters", "_interpreters")))
        for name in ("create", "run_string", "exec", "run_func", "call")
        if hasattr(interpreters, name)
    },
    **{
        f"os.{name}": getattr(os, name)
        for name in ("close", "closerange", "dup2", "kill", "killpg", "_exit", "execv", "execve", *RIGHTS)
        if hasattr(os, name)
    },
    **{f"signal.{name}": getattr(_signal, name) for name in ("raise_signal", "pthread_kill") if hasattr(_signal, name)},
}
"""What waits without end or for what no run has, by name: nothing interrupts `sigwait`, and a process not `system`;
timers of the machine strike by its own clock, or never, as a run is over soon; another interpreter of the process has
clocks and locks of its own. And what takes from the process what nobody can give back, or ends it or makes another
program of it: the other `os.exec...` call these. They are as they are now: the code under test may replace them."""

_REAP_S = 1.0
"""Time limit (s) for the end of a process whose wait was refused (chosen: it takes milliseconds)."""


class _Guard:
    """Refuses waiting for one run, and lets go of it afterwards."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._thread = threading.current_thread()
        self._pid = _PID()
        self._depth = sys.getrecursionlimit()
        self._threads: weakref.WeakKeyDictionary[threading.Thread, str] = weakref.WeakKeyDictionary()
        self._refused: weakref.WeakSet[subprocess.Popen[Any]] = weakref.WeakSet()
        self._reaps = False
        self.is_over = False

    def sleep(self, duration_s: float) -> None:
        """Like `time.sleep`: in nodes virtual, or refused."""
        node, caller = current_node(), sys._getframe(2)
        if node is not None and self._is_node() and not (self._reaps or is_tool(caller)):
            if TIME not in node.kernel.virtual and not clocks.is_of_code(caller, node.kernel.code):
                self._refuse("time.sleep")
            clocks.sleep(duration_s)
            return
        started = self._threads.get(threading.current_thread())
        if started is not None:
            self._kernel.trespass(
                f"{started} waits in real time, in time.sleep at {place_of(sys._getframe(1))}: let it be a thread of "
                'the code under test, with time=VirtualTime(apis=("threading",)), or start none'
            )
        clocks.real_time.sleep(duration_s)

    def call_or_refuse(self, name: str, real: Callable[..., Any], *args: Any, **keywords: Any) -> Any:
        """Call one of `_REFUSED` outside of nodes, or if it does not wait; refuse it otherwise."""
        node = current_node()
        if _PID() == self._pid and takes_away(name, args, self._depth):
            raise ProhibitedError(
                f"{place_of(sys._getframe(1))}: {name} takes from the whole process, pytest included, what the session "
                "needs: let the code do so where it is started, which a test does not do, or in a process of its own"
            )
        if self._is_ended_by(name, args):
            call = f"{name}({', '.join(map(repr, args[:1]))}{', ...' * (len(args) > 1)})"
            raise ProhibitedError(f"{call} at {place_of(sys._getframe(2))}: it would end all tests at once")
        if node is not None and self._is_node() and not is_harmless(name, args):
            if name.rpartition(".")[2] not in _CLOCKED:
                self._refuse(name)
            raise RealTimeError(
                f"{place_of(sys._getframe(1))}: node {node.name} uses {name}, which uses the machine's clock: "
                'a run has its own; use threading.Timer, with time=VirtualTime(apis=("time", "threading"))'
            )
        if name == "sys.setrecursionlimit":
            args = (min(args[0], MAX_DEPTH),)
        if name == "signal.pthread_sigmask":
            args = (args[0], {*args[1]} - {WATCHDOGS})
        return real(*args, **keywords)

    def start(self, thread: threading.Thread) -> None:
        """Like `Thread.start`; threads that nodes start are remembered."""
        node = current_node()
        if node is not None:
            place = place_of(sys._getframe(1))
            self._threads[thread] = f"thread {thread.name}, which node {node.name} started at {place},"
        _START(thread)

    def wait(self, process: subprocess.Popen[Any], timeout: float | None = None) -> int:
        """Like `Popen.wait`, outside of nodes, and for processes that have ended."""
        is_waiting = self._is_node() and process.poll() is None
        if is_waiting and process not in self._refused:
            self._refused.add(process)
            self._refuse("subprocess.Popen.wait")
        if not is_waiting:
            return _WAIT(process, timeout)
        self._reaps = True
        try:
            return _WAIT(process, _REAP_S)
        finally:
            self._reaps = False

    def select(self, real: Callable[..., list[Any]], selector: Any, timeout: float | None = None) -> list[Any]:
        """Like `select` of a selector, if something is ready, or outside of nodes."""
        if (timeout is not None and timeout <= 0) or threading.current_thread() is not self._thread:
            return real(selector, timeout)
        loops = sys._getframe(2).f_globals.get("__name__") == "asyncio.base_events"
        is_node = self._is_node()
        # An event loop of the testbench's `run` may wait for a simulator, but not for time to pass.
        is_timer = loops and not self._kernel.is_running and timeout is not None and len(selector.get_map()) <= 1
        if not (is_node or is_timer):
            return real(selector, timeout)
        ready = real(selector, 0)
        if not ready and is_node and self._wait_for_terminal(selector, timeout):
            return real(selector, 0)
        if not ready:
            self._refuse("the event loop of asyncio" if loops else f"selectors.{type(selector).__name__}.select")
        return ready

    @staticmethod
    def _wait_for_terminal(selector: Any, timeout: float | None) -> bool:
        """Wait for the terminal of the running node, in virtual time, if the selector has nothing else."""
        node = current_node()
        terminal = terminal_of(node) if node is not None and HAS_TERMINALS else None
        if terminal is None or [*selector.get_map()] != [terminal.fd]:
            return False
        terminal.wait_readable(timeout)
        return True

    def _is_ended_by(self, name: str, args: tuple[Any, ...]) -> bool:
        """Whether a call ends the session: not in a process that the run has forked, nor in threads of time limits."""
        is_beside = threading.current_thread() is not self._thread and not self._is_node()
        return ends_session(name, args) and not (is_beside or _PID() != self._pid)

    def _is_node(self) -> bool:
        """Whether the caller is a node: a process that one forks is a copy of it, and none; who waits for it is."""
        return current_node() is not None and _PID() == self._pid

    def refuse_limit(self, what: str) -> None:
        """Refuse in nodes what has just waited until its limit."""
        if self._is_node() and not self.is_over:
            self._refuse(what)

    def _refuse(self, what: str) -> NoReturn:
        node, frame = current_node(), sys._getframe(2)
        who = "run" if node is None else f"node {node.name}"
        raise RealTimeError(real_wait(frame, who, self._kernel.code, self._kernel.virtual, what))


@contextmanager
def guard_run(kernel: Kernel) -> Iterator[None]:
    """During a run, waiting in real time is refused in its nodes, whatever module they are in."""
    guard, undo = _Guard(kernel), list[Callable[[], object]]()
    keep_open()  # what the session has closed since the last run may have been opened anew under the same number

    def put(owner: Any, name: str, value: object) -> None:
        undo.append(partial(setattr, owner, name, getattr(owner, name)))
        setattr(owner, name, value)

    @wraps(_START)
    def start(thread: threading.Thread) -> None:
        guard.start(thread)

    @wraps(_WAIT)
    def wait(process: subprocess.Popen[Any], timeout: float | None = None) -> int:
        return guard.wait(process, timeout)

    if HAS_TERMINALS and terminal_calls.is_of_session(sys.stdin):
        terminal_calls.STDIN.outside = sys.stdin
        put(sys, "stdin", terminal_calls.STDIN)
    try:
        _GUARDS.append(guard)
        _REDIRECTION.install()
        undo.append(_REDIRECTION.remove)
        put(threading.Thread, "start", start)
        put(subprocess.Popen, "wait", wait)
        for name in ("stdout", "stderr"):
            undo += _keep_open(f"sys.{name}.close", getattr(sys, name))
        for kind in _SELECTORS:
            put(kind, "select", _make_select(guard, kind.select))
        for kind in filter(None, [getattr(sys.modules.get("socket"), "socket", None)]):
            for name in filter(partial(hasattr, kind), _SOCKET_CALLS):
                put(kind, name, _make_socket_call(guard, name, getattr(kind, name)))
        for module in filter(None, map(sys.modules.get, ("asyncio", "asyncio.events"))):
            _let_loops_be_virtual(module, put)
        yield
    finally:
        guard.is_over = True
        _GUARDS.remove(guard)
        for restore in reversed(undo):
            restore()
        leave_open()
        if HAS_TERMINALS:
            for terminal in terminals_of(kernel).values():
                terminal.hang_up()


def _keep_open(name: str, stream: Any) -> Iterator[Callable[[], object]]:
    """Refuse to close a stream and what it writes to; yields what allows it again."""
    parts: tuple[Any, Any] = stream, getattr(stream, "buffer", None)
    for part in parts:
        with suppress(AttributeError, TypeError):  # one of another kind, as somebody has put it there
            part.close = _make_refusal(name, part.close)
            yield partial(delattr, part, "close")


def _make_select(guard: _Guard, real: Callable[..., list[Any]]) -> Callable[..., list[Any]]:
    @wraps(real)
    def select(selector: Any, timeout: float | None = None) -> list[Any]:
        return guard.select(real, selector, timeout)

    return select


def _make_socket_call(guard: _Guard, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
    """What a socket waited for until its own limit, it waited for in real time, even if the watchdog saw nothing."""

    @wraps(real)
    def call(*args: Any, **keywords: Any) -> Any:
        try:
            return real(*args, **keywords)
        except TimeoutError:
            guard.refuse_limit(f"socket.socket.{name.lstrip('_')}")
            raise

    return call


def _make_refusal(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(real)
    def call_or_refuse(*args: Any, **keywords: Any) -> Any:
        if not _GUARDS or is_of_session(name, args, sys._getframe(1)):
            return real(*args, **keywords)
        return _GUARDS[-1].call_or_refuse(name, real, *args, **keywords)

    return call_or_refuse


_GUARDS: list[_Guard] = []
"""The guards of the present runs, the innermost last."""


def _sleep(seconds: float, /) -> None:
    if _GUARDS:
        _GUARDS[-1].sleep(seconds)
    else:
        clocks.real_time.sleep(seconds)


def _acquire(lock: Any, block: bool = True, timeout: float | None = None) -> bool:
    taken: bool = _ACQUIRE.__get__(lock)(block, timeout)
    if not taken and block and _GUARDS:
        _GUARDS[-1].refuse_limit("multiprocessing.synchronize.SemLock.acquire")
    return taken


_acquire.__module__ = "_multiprocessing"  # what a message says that it waits in
_SEMAPHORE = getattr(_import_or_none("_multiprocessing"), "SemLock", None)
_ACQUIRE: Any = replace_in_class(_SEMAPHORE, "acquire", _acquire) if _SEMAPHORE is not None else None
"""The method of locks and events of `multiprocessing` as it was: what waited until its limit, waited in real time."""


def _let_loops_be_virtual(module: ModuleType, put: Callable[[Any, str, object], None]) -> None:
    """Nodes that make an event loop get one in virtual time."""
    from pytest_hricdv.runtime.virtual import asyncio_functions

    for name in ("run", "new_event_loop"):
        real = vars(module).get(name)
        if real is not None:
            put(module, name, _virtual_in_nodes(getattr(asyncio_functions, name), real))


def _virtual_in_nodes(virtual: Callable[..., Any], real: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(real)
    def call(*args: Any, **keywords: Any) -> Any:
        return (real if current_node() is None else virtual)(*args, **keywords)

    return call


_REDIRECTION = Redirection(
    (
        (time.sleep, _sleep),
        *clocks.TIME_FUNCTIONS,
        *((real, _make_refusal(name, original(real))) for name, real in _REFUSED.items()),
        *(terminal_calls.REPLACED if HAS_TERMINALS else ()),
    )
)
"""What a run redirects in place."""
