"""A watchdog for code that never returns control."""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


@contextmanager
def watchdog(progress: Callable[[], object], error: Callable[[], Exception], period_s: float) -> Iterator[None]:
    """Raise `error()` in the running code if the value of `progress()` is the same for a period of processor time.

    Only processor time counts, so the load of the machine has no effect. Without effect on systems without such a
    timer, and outside of the main thread.

    Args:
        progress: called once a period; any value that changes while the code makes progress.
        error: creates the exception.
        period_s: seconds of this process's processor time; infinity disables the watchdog.
    """
    supported = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if math.isinf(period_s) or not supported:
        yield
        return
    last = progress()

    def check(number: int, frame: FrameType | None) -> None:
        nonlocal last
        now = progress()
        if now == last:
            raise error()
        last = now

    previous = signal.signal(signal.SIGVTALRM, check)
    signal.setitimer(signal.ITIMER_VIRTUAL, period_s, period_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, previous)
