"""A look at progress from outside, for code that never gives control back."""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@contextmanager
def watching(progress: Callable[[], object], stuck: Callable[[], Exception], period_s: float) -> Iterator[None]:
    """Raise `stuck()`, wherever the code is, when `progress()` has not changed within a period of processor time.

    Only processor time counts, so a busy machine changes nothing. Without effect where the system has no such timer, or
    outside of the main thread.

    Args:
        progress: called once a period; any value that changes when something goes on.
        stuck: makes the error.
        period_s: seconds of this process's processor time; infinity for no look at all.
    """
    can = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if math.isinf(period_s) or not can:
        yield
        return
    seen = progress()

    def look(number: int, frame: FrameType | None) -> None:
        nonlocal seen
        now = progress()
        if now == seen:
            raise stuck()
        seen = now

    before = signal.signal(signal.SIGVTALRM, look)
    signal.setitimer(signal.ITIMER_VIRTUAL, period_s, period_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
