"""`threading` and `queue` in virtual time: a thread is one more node of the kernel.

A node is to its threads what a process is: it is their main thread, it numbers them, and threads of other nodes are not
among them. A thread that raises fails the run, as its node would: nobody has to look for its traceback.
"""

from __future__ import annotations

import _thread
import gc
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from types import CellType, FunctionType, ModuleType
from typing import Any, NoReturn

from pytest_hricdv.runtime.blocking_calls import THREADING
from pytest_hricdv.runtime.kernel import Node, current_node
from pytest_hricdv.runtime.redirection import original
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual import locks
from pytest_hricdv.runtime.virtual.clocks import monotonic
from pytest_hricdv.runtime.virtual.real_time import node_to_wait
from pytest_hricdv.runtime.virtual.references import copy, stand_in

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_THREADS = "threads"


class _Threads:
    """The threads of one node, itself the first."""

    def __init__(self, main: Node) -> None:
        self.main = main
        self.made = self.begun = 0
        first = Thread(name="MainThread", daemon=False)
        self.running: dict[Node, Thread] = {main: first}
        first.began(main, 1)

    def add(self, thread: Thread, node: Node) -> int:
        """A thread begins; returns its number."""
        self.begun += 1
        self.running[node] = thread
        return self.begun + 1

    def number(self) -> int:
        """The number of a new thread without a name."""
        self.made += 1
        return self.made


def _threads() -> _Threads | None:
    """The threads of the running node; None outside of a node."""
    node = current_node()
    if node is None:
        return None
    threads = node.own.get(_THREADS)
    if not isinstance(threads, _Threads):
        threads = node.own[_THREADS] = _Threads(node)
    return threads


def _do_nothing() -> None:
    """The body of a node whose thread is over."""


class Thread:
    """Like `threading.Thread`."""

    def __init__(
        self,
        group: None = None,
        target: Callable[..., object] | None = None,
        name: str | None = None,
        args: Iterable[Any] = (),
        kwargs: Mapping[str, Any] | None = None,
        *,
        daemon: bool | None = None,
        context: object = None,
    ) -> None:
        assert group is None, "group argument must be None for now"
        self._target = target
        self._args = tuple(args)
        self._kwargs = dict(kwargs or {})
        self.name = str(name) if name is not None else self._make_name()
        self._daemon = bool(current_thread().daemon if daemon is None else daemon)
        self.ident: int | None = None
        self.begun_at = ""
        """The line that started it, or gave it what it does now."""
        self._node: Node | None = None
        self._over = locks.Event()

    def _make_name(self) -> str:
        threads = _threads()
        number = threads.number() if threads is not None else 0
        target = getattr(self._target, "__name__", "")
        return f"Thread-{number} ({target})" if target else f"Thread-{number}"

    def began(self, node: Node, ident: int) -> None:
        """It is what `node` runs from now on."""
        self._node, self.ident = node, ident

    @property
    def native_id(self) -> int | None:
        """The same as `ident`: the system does not know this thread."""
        return self.ident

    @property
    def daemon(self) -> bool:
        """Whether it ends with its node. Raises RuntimeError where it is set after the beginning."""
        return self._daemon

    @daemon.setter
    def daemon(self, daemon: bool) -> None:
        if self.ident is not None:
            raise RuntimeError("cannot set daemon status of active thread")
        self._daemon = daemon

    def start(self) -> None:
        """Begin to run at this instant, after the nodes that are due already."""
        if self.ident is not None:
            raise RuntimeError("threads can only be started once")
        parent = node_to_wait(THREADING, "Thread.start")
        self.begun_at = place_of(sys._getframe(1))
        threads = _threads()
        assert threads is not None
        body = parent.wrap_thread(self._run, self.daemon)
        node = parent.kernel.spawn(f"{threads.main.name}: {self.name}", body)
        node.wrap_thread, node.own[_THREADS] = parent.wrap_thread, threads
        self.began(node, threads.add(self, node))

    def _run(self) -> None:
        try:
            self.run()
        except SystemExit:
            pass  # ends a thread silently
        finally:
            self._over.set()
            threads = _threads()
            if threads is not None and self._node is not None:
                threads.running.pop(self._node)
                self._node.body = _do_nothing  # nothing else keeps it

    def run(self) -> None:
        """The thread's work; to be overridden, or given as `target`."""
        if self._target is not None:
            self._target(*self._args, **self._kwargs)

    def join(self, timeout: float | None = None) -> None:
        """Wait until it is over, at most `timeout` (s)."""
        if self.ident is None:
            raise RuntimeError("cannot join thread before it is started")
        if self is current_thread():
            raise RuntimeError("cannot join current thread")
        if self.is_alive():
            self._over.wait(timeout)

    def is_alive(self) -> bool:
        """Whether it has begun and is not over."""
        return self._node is not None and not self._node.ended and not self._over.is_set()

    def __repr__(self) -> str:
        state = "initial" if self.ident is None else "started" if self.is_alive() else "stopped"
        return f"<{type(self).__name__}({self.name}, {state}{' daemon' if self.daemon else ''})>"


class Timer(Thread):
    """Like `threading.Timer`."""

    def __init__(
        self,
        interval: float,
        function: Callable[..., object],
        args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__()
        self.interval = interval
        self.function = function
        self.args = list(args or ())
        self.kwargs = dict(kwargs or {})
        self.finished = locks.Event()

    def cancel(self) -> None:
        """Do not call the function, if it was not called yet."""
        self.finished.set()

    def run(self) -> None:
        """Call the function after `interval` (s)."""
        if not self.finished.wait(self.interval):
            self.function(*self.args, **self.kwargs)
        self.finished.set()


def current_thread() -> Any:
    """The thread that runs."""
    threads, node = _threads(), current_node()
    return threading.current_thread() if threads is None or node is None else threads.running[node]


def main_thread() -> Any:
    """The thread that is the node itself, which started the others."""
    threads = _threads()
    return threading.main_thread() if threads is None else threads.running[threads.main]


def enumerate_threads() -> list[Any]:
    """The node itself and its threads that are not over, as `threading.enumerate`."""
    threads = _threads()
    if threads is None:
        return threading.enumerate()
    main, *others = threads.running.values()
    return [main, *(thread for thread in others if thread.is_alive())]


def active_count() -> int:
    """How many they are."""
    return len(enumerate_threads())


def get_ident() -> int:
    """A number of the running thread, unique among those of its node."""
    return int(current_thread().ident)


def start_new_thread(
    function: Callable[..., object], args: tuple[Any, ...], kwargs: Mapping[str, Any] | None = None
) -> int:
    """Like that of `_thread`."""
    if current_node() is None:
        return _thread.start_new_thread(function, args, dict(kwargs or {}))
    thread = Thread(target=function, args=args, kwargs=kwargs, daemon=True)
    thread.start()
    return int(thread.ident or 0)


_NAMES = {
    "Thread": Thread,
    "Timer": Timer,
    "Lock": locks.Lock,
    "RLock": locks.RLock,
    "Condition": locks.Condition,
    "Event": locks.Event,
    "Semaphore": locks.Semaphore,
    "BoundedSemaphore": locks.BoundedSemaphore,
    "Barrier": locks.Barrier,
    "current_thread": current_thread,
    "main_thread": main_thread,
    "enumerate": enumerate_threads,
    "active_count": active_count,
    "get_ident": get_ident,
    "get_native_id": get_ident,
}


def _make_threading() -> ModuleType:
    made = stand_in(threading, _NAMES)
    made.__dict__["local"] = copy("_threading_local", {"threading": made}).local
    made.__dict__["local"].__reduce__ = _make_refusal("_thread._local")
    return made


def _make_refusal(kind: str) -> Callable[[object], NoReturn]:
    def refuse(value: object) -> NoReturn:
        raise TypeError(f"cannot pickle '{kind}' object")  # nor copy it

    return refuse


def _queue(threads: ModuleType) -> ModuleType:
    # Without Python's queue in C, which waits by itself, its queue module has one that waits on locks.
    in_c = ModuleType("_queue")
    in_c.__dict__["Empty"] = queue.Empty
    made = copy("queue", {"threading": threads, "time": stand_in(time, {"monotonic": monotonic}), "_queue": in_c})
    made.__dict__["Full"] = queue.Full
    made.__dict__["SimpleQueue"].__reduce__ = _make_refusal("_queue.SimpleQueue")
    return made


_THREADING = _make_threading()
_QUEUE = _queue(_THREADING)

_LOW_LEVEL = stand_in(
    _thread,
    {"start_new_thread": start_new_thread, "start_new": start_new_thread, "get_ident": get_ident}
    | dict.fromkeys(("allocate_lock", "allocate"), locks.Lock)
    | {"RLock": locks.RLock},
)

MODULES = (_THREADING, _QUEUE, copy("sched", {"threading": _THREADING}), _LOW_LEVEL)
"""The modules that the code under test sees."""


def local_like(kind: type) -> type:
    """A class like a subclass of `threading.local`, whose objects have other attributes in each node and thread."""
    if kind is threading.local:
        return _THREADING.__dict__["local"]  # type: ignore[no-any-return]
    if not issubclass(kind, threading.local):
        return kind
    if kind not in _LIKE:
        own = {name: value for name, value in vars(kind).items() if name not in ("__dict__", "__weakref__")}
        here = CellType()
        own = {name: _within_class(value, here) for name, value in own.items()}
        here.cell_contents = _LIKE[kind] = type(kind.__name__, tuple(map(local_like, kind.__bases__)), own)
    return _LIKE[kind]


def local_again(value: object) -> object:
    """An object like one of a subclass of `threading.local`, made with the same arguments."""
    kept = gc.get_referents(value)  # nothing else tells them; there is a dictionary of its threads, too, by numbers
    arguments = next((item for item in kept if type(item) is tuple), ())
    keywords = next((item for item in kept if type(item) is dict and item and all(type(k) is str for k in item)), {})
    return local_like(type(value))(*arguments, **keywords)


def _within_class(value: object, here: CellType) -> object:
    """A method whose `super()` is that of another class; anything else as it is."""
    if not isinstance(value, FunctionType) or "__class__" not in value.__code__.co_freevars:
        return value
    cells = zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)
    return original(value, tuple(here if name == "__class__" else cell for name, cell in cells))


_LIKE: dict[type, type] = {}


def _renew(thread: Any) -> object:
    """A thread like one that a module has made; a started thread stays itself."""
    if thread.ident is not None:
        return thread
    made = Thread(None, getattr(thread, "_target", None), thread.name, thread._args, thread._kwargs)
    if type(thread) is threading.Timer:
        made = Timer(thread.interval, thread.function, thread.args, thread.kwargs)
    made.daemon = thread.daemon
    return made


RENEWED: dict[type, Callable[[Any], object]] = {
    **locks.RENEWED,
    **dict.fromkeys((threading.Thread, threading.Timer), _renew),
    queue.SimpleQueue: lambda waiting: _QUEUE.SimpleQueue(),
    **dict.fromkeys(
        (queue.Queue, queue.LifoQueue, queue.PriorityQueue),
        lambda waiting: getattr(_QUEUE, type(waiting).__name__)(waiting.maxsize),
    ),
}
"""Class of an object that a module has -> makes a new one like it."""
