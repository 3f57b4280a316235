"""The watchdog: a thread that observes the code of a run, and interrupts what keeps simulated time from advancing.

Such code works without end, or waits in real time for what is not simulated. `Supervision` has one `Watch` per run,
which reports a `Hang`. It is a thread because a system timer would not do: the alarm signal may be in use, as by
pytest-timeout, and a timer of processor time does not notice waiting code. Such a timer only lets the thread look while
a function in C, such as a search of `re`, keeps Python's lock.
"""

from __future__ import annotations

import _thread
import contextlib
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType, ModuleType
from typing import Literal

from pytest_hricdv.runtime.redirection import original

resource: ModuleType | None = None
with contextlib.suppress(ImportError):  # Windows has none, and no signals that interrupt either
    import resource

# The original functions: the code under test may replace them in the whole process, for instance by a clock that stands
# still.
_monotonic, _process_time = time.monotonic, time.process_time
_HANDLE, _SET_DEPTH = signal.signal, sys.setrecursionlimit  # refused in runs
_SET_TIMER = getattr(signal, "setitimer", None)
_PID, _WRITE, _EXIT = os.getpid, os.write, original(os._exit)

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_ROOM = 100
"""Depth of calls added to the recursion limit to interrupt endless recursion (chosen: some ten are needed)."""
_clock_gettime: Callable[[int], float] = getattr(time, "clock_gettime", lambda clock: time.process_time())

_HAS_SIGNALS = hasattr(signal, "pthread_kill") and hasattr(signal, "SIGVTALRM")
"""Not on Windows."""

TICK_S = 0.1
"""How often the thread looks (s of real time). A look takes 40 us (`timeit` of `_Usage.tick`, 2 cores)."""

YIELD_S = 0.5
"""How often (s of processor time) the thread can look while other code keeps Python's lock."""

AGAIN_S = 1.0
"""Time to clean up (s of processor time; chosen) for code that was interrupted and continues."""

_IDLE = 0.5
"""A process that neither had nor wanted a processor for this share of a tick waits (chosen)."""

_FORGETS = 0.2
"""A tick in which nobody waits takes back this share of one that waits: to wait for more than a sixth of the time adds
up, and to wait now and then in a long run does not."""

_PROMPTS = ("pdb", "bdb", "cmd", "code", "IPython", "ipdb", "pudb", "pydevd", "_pydevd_bundle", "debugpy")
"""Modules in which somebody sits at a debugger, for as long as they like."""

_IMPORTS = ("importlib._bootstrap", "importlib._bootstrap_external")
"""Modules in which Python reads files: on a slow disk this takes long, and waits for nothing that is not simulated."""


@dataclass(frozen=True)
class WatchState:
    """The present activity, and its limits.

    Args:
        progress: any number that changes while time passes.
        may_wait_s: how long it may wait (s of real time). may_work_s: how long it may work without progress (s of
            processor time).
        adds_up: whether waiting adds up although there is progress.
        second: the second of simulated time.
        may_take_s: how long a second of simulated time may take (s of processor time).
    """

    progress: int
    may_wait_s: float
    may_work_s: float = math.inf
    adds_up: bool = False
    second: int = 0
    may_take_s: float = math.inf


@dataclass(frozen=True)
class Hang:
    """A hang that has to end.

    Args:
        kind: whether it waits, works without end, or crawls (a second of simulated time takes too long).
        taken_s: its duration (s of real time, or of processor time).
    """

    kind: Literal["waits", "works", "crawls"]
    taken_s: float


class Watch:
    """Watches the code of the main thread.

    Args:
        look: tells what runs now; called by the thread of the watchdog.
        end: called in the code that has to end, with its frame; it raises. Called again if this had no effect.
    """

    def __init__(self, look: Callable[[], WatchState], end: Callable[[Hang, FrameType | None], None]) -> None:
        self._look = look
        self._end = end
        self._watched = threading.main_thread()
        self._problem: Hang | None = None
        self._thread: tuple[_thread.LockType, _thread.LockType] | None = None
        self._pid = 0
        self._seen = WatchState(-1, math.inf)
        self._waited_s = {True: 0.0, False: 0.0}  # where it adds up, and where progress ends it
        self._worked_s = self._second_s = 0.0
        self._depth = sys.getrecursionlimit()
        self._is_deepened = False

    @contextmanager
    def watch(self) -> Iterator[None]:
        """Within, the code is watched. Without effect where signals do not arrive: in other threads, and on Windows."""
        if not _HAS_SIGNALS or threading.current_thread() is not self._watched:
            yield
            return
        previous = _HANDLE(signal.SIGVTALRM, self._interrupt)
        assert _SET_TIMER is not None, "a system with this signal has its timer"
        timer = _SET_TIMER(signal.ITIMER_VIRTUAL, YIELD_S, YIELD_S)
        self._start()
        try:
            yield
        finally:
            self._stop()
            _SET_TIMER(signal.ITIMER_VIRTUAL, *timer)
            _HANDLE(signal.SIGVTALRM, previous)

    def _start(self) -> None:
        self._pid = _PID()
        self._depth = sys.getrecursionlimit()
        self._thread = stopping, ended = _thread.allocate_lock(), _thread.allocate_lock()
        stopping.acquire()
        ended.acquire()
        # Not of `threading`: code under test and tracers have nothing to do with it.
        _thread.start_new_thread(self._run, (stopping, ended))

    def _stop(self) -> None:
        if self._thread is None:
            return
        if _PID() != self._pid:
            _WRITE(2, b"hricdv: a process that the code under test has forked did not end: it ends with its run\n")
            _EXIT(1)  # it would be a second session, in the same folder
        # First of all, so that what is on its way interrupts nothing any more.
        (stopping, ended), self._thread = self._thread, None
        stopping.release()
        ended.acquire()
        if self._is_deepened:  # not by so much less than now: what the run changed may have been put back since
            _SET_DEPTH(self._depth)
            self._is_deepened = False

    def _run(self, stopping: _thread.LockType, ended: _thread.LockType) -> None:
        try:
            usage = _Usage(self._watched)
            while not stopping.acquire(timeout=TICK_S):
                self._tick(*usage.tick())
        finally:
            ended.release()

    def _tick(self, waited_s: float, worked_s: float) -> None:
        """Count what the last tick was, and interrupt the code where it is too much."""
        now, before = self._look(), self._seen
        self._seen = now
        # A tick with progress counts for nothing: the work after the progress is unknown.
        self._worked_s = self._worked_s + worked_s if now.progress == before.progress else 0.0
        self._second_s = self._second_s + worked_s if now.second == before.second else 0.0
        if now.progress != before.progress:
            self._waited_s[False] = 0.0
        if waited_s and self._waits():
            self._waited_s[now.adds_up] += waited_s
        else:
            self._waited_s[True] = max(0.0, self._waited_s[True] - _FORGETS * TICK_S)
        if self._waited_s[now.adds_up] >= now.may_wait_s:
            self._problem, self._waited_s[now.adds_up] = Hang("waits", self._waited_s[now.adds_up]), 0.0
        elif self._worked_s >= now.may_work_s:
            # Code that caught the error has had its time: it is interrupted again soon.
            self._problem, self._worked_s = Hang("works", self._worked_s), max(0.0, now.may_work_s - AGAIN_S)
        elif self._second_s >= now.may_take_s:
            self._problem, self._second_s = Hang("crawls", self._second_s), max(0.0, now.may_take_s - AGAIN_S)
        else:
            return
        assert self._watched.ident is not None, "the main thread has begun"
        # Where the stack is as deep as it may be, the handler could not be called.
        _SET_DEPTH(sys.getrecursionlimit() + _ROOM)
        self._is_deepened = True
        signal.pthread_kill(self._watched.ident, signal.SIGVTALRM)

    def _waits(self) -> bool:
        """Whether the waiting code itself waits: no file is being imported, and no debugger is in use."""
        frame = sys._current_frames().get(self._watched.ident or 0)
        while frame is not None:
            name = str(frame.f_globals.get("__name__", ""))
            if name in _IMPORTS or name.partition(".")[0] in _PROMPTS:
                return False
            frame = frame.f_back
        return True

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        problem, self._problem = self._problem, None
        if problem is not None and self._thread is not None:
            self._end(problem, frame)


_OPEN = open  # as it is now: the code under test may replace it while it is watched


class _Usage:
    """The activity of the process since the last tick: the watched thread worked, or all waited.

    It waits if none of its threads, except the watchdog's own, had a processor, wanted one, or used the disk. That
    others use all processors has no effect where Linux tells for how long threads
    wanted one, and which want one now: that is added to the former only when they get it, which on a busy machine takes
    longer than a tick. Elsewhere, being interrupted is a sign of it.
    """

    def __init__(self, watched: threading.Thread) -> None:
        self._own = str(threading.get_native_id())  # on a busy machine it wants a processor for longer than it looks
        self._clock = time.CLOCK_PROCESS_CPUTIME_ID
        if hasattr(time, "pthread_getcpuclockid") and watched.ident is not None:
            self._clock = time.pthread_getcpuclockid(watched.ident)  # threads that compute for it are no loop of it
        self._times, self._counters = self._read()

    def tick(self) -> tuple[float, float]:
        """The time that all waited (s of real time), and that the watched thread worked (s of processor time)."""
        (began_s, worked_s, wanted_s), counters = self._times, self._counters
        self._times, self._counters = self._read()
        real_s = self._times[0] - began_s
        waits = self._counters == counters and self._times[2] - wanted_s < (1 - _IDLE) * real_s
        waits = waits and not _wants_now(self._own)
        # If the machine slept, or the process was stopped, a tick may have taken very long.
        return (min(real_s, 2 * TICK_S) if waits else 0.0), self._times[1] - worked_s

    def _read(self) -> tuple[tuple[float, float, float], tuple[int, ...]]:
        """Times (s): real, worked, wanted; and counters that stay the same while a process waits."""
        wanted_s = _demand_s(self._own)
        used = resource.getrusage(resource.RUSAGE_SELF) if resource is not None else None
        counters = () if used is None else (used.ru_majflt, used.ru_inblock, used.ru_oublock)
        if wanted_s is None:
            wanted_s = _process_time()
            counters = counters if used is None else (*counters, used.ru_nivcsw)
        return (_monotonic(), _clock_gettime(self._clock), wanted_s), counters


def _demand_s(but: str) -> float | None:
    """The time (s) that threads of this process had or wanted a processor; None if the system does not tell.

    Args:
        but: the number that the system has for a thread, which does not count.
    """
    total_ns = 0
    try:
        for task in os.listdir("/proc/self/task"):
            if task == but:
                continue
            with _OPEN(f"/proc/self/task/{task}/schedstat", "rb") as file:
                worked_ns, wanted_ns, _ = file.read().split()
            total_ns += int(worked_ns) + int(wanted_ns)
    except (OSError, ValueError):
        return None
    return total_ns / 1e9


def _wants_now(but: str) -> bool:
    """Whether a thread of this process has or wants a processor now; False if the system does not tell.

    Args:
        but: the number that the system has for a thread, which does not count.
    """
    try:
        tasks = [task for task in os.listdir("/proc/self/task") if task != but]
    except OSError:
        return False
    return any(_state(task) == b"R" for task in tasks)


def _state(task: str) -> bytes:
    """The state of a thread, a letter as in `ps`; empty if the system does not tell, or the thread has ended."""
    try:
        with _OPEN(f"/proc/self/task/{task}/stat", "rb") as file:
            return file.read().rpartition(b") ")[2][:1]  # its name comes before, in brackets, and may have some
    except OSError:
        return b""
