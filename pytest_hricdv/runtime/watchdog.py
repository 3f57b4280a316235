"""Watchdogs: code that keeps simulated time from passing is ended, whether it works without end or waits for ever."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_PROMPTS = ("pdb", "bdb", "cmd", "code", "IPython", "ipdb", "pudb", "pydevd", "_pydevd_bundle", "debugpy")
"""Modules in which somebody sits at a debugger, for as long as they like."""

_IDLE = 0.5
"""A process that used less than this share of a period waits (chosen). Working code gets less only where more than two
processes share each processor, and is stopped only if it then works for two periods without progress."""


@contextmanager
def busy_watchdog(progress: Callable[[], object], error: Callable[[], Exception], period_s: float) -> Iterator[None]:
    """Raise `error()` in the running code if the value of `progress()` is the same for a period of processor time.

    Only processor time counts, so the load of the machine has no effect. Without effect on systems without such a
    timer, and outside of the main thread.

    Args:
        progress: called once a period; any value that changes while the code makes progress.
        error: creates the exception.
        period_s: seconds of this process's processor time; infinity disables the watchdog.
    """
    if math.isinf(period_s) or not _is_supported():
        yield
        return
    last = progress()

    def check(number: int, frame: FrameType | None) -> None:
        nonlocal last
        now = progress()
        if now == last:
            raise error()
        last = now

    # The timer counts the processor time of this process only, and repeats: code may catch the first exception.
    previous = signal.signal(signal.SIGVTALRM, check)
    signal.setitimer(signal.ITIMER_VIRTUAL, period_s, period_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, previous)


@contextmanager
def idle_watchdog(progress: Callable[[], object], error: Callable[[str], Exception], period_s: float) -> Iterator[None]:
    """Raise `error(place)` in the running code if it has waited for two periods of real time without progress.

    Two, because a machine that slept wakes up to one that is over. Without effect where somebody else has a use for the
    alarm signal, as pytest-timeout, at the prompt of a debugger, and where `busy_watchdog` has none.

    Args:
        progress: as for `busy_watchdog`.
        error: creates the exception; it is given where the code waits, `file:line`.
        period_s: seconds of real time; infinity disables the watchdog.
    """
    if math.isinf(period_s) or not _is_supported() or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL:
        yield
        return
    last, last_used_s, silent = progress(), time.process_time(), 0

    def check(number: int, frame: FrameType | None) -> None:
        nonlocal last, last_used_s, silent
        now, used_s = progress(), time.process_time()
        waits = now == last and used_s - last_used_s < _IDLE * period_s and not _at_prompt(frame)
        silent = silent + 1 if waits else 0
        last, last_used_s = now, used_s
        if silent == 2:
            raise error(f"{frame.f_code.co_filename}:{frame.f_lineno}" if frame is not None else "an unknown place")

    signal.signal(signal.SIGALRM, check)
    signal.setitimer(signal.ITIMER_REAL, period_s, period_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


def _is_supported() -> bool:
    """Whether there are such timers, and signals arrive here."""
    return hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()


def _at_prompt(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).partition(".")[0] in _PROMPTS:
            return True
        frame = frame.f_back
    return False
