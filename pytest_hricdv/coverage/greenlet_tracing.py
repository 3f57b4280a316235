"""Limits a trace function to one greenlet, so that other greenlets are neither slowed down nor measured.

Depending on the versions of Python and greenlet, `sys.settrace` holds for the greenlet that called it or for the whole
thread. In the second case the trace function has to be removed and restored whenever control leaves the measured
greenlet and returns. This is done in greenlet's switch callback: greenlet suspends tracing around it, so the tracer's
call stack stays consistent. (Stopping and starting the measurement instead would lose it.)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import greenlet


@contextmanager
def kept_to_this_greenlet() -> Iterator[None]:
    """While the body runs, what it sets with `sys.settrace` holds in the current greenlet only."""
    outer = sys.gettrace()
    if not held_by_thread():
        try:
            yield
        finally:
            sys.settrace(outer)
        return
    here = greenlet.getcurrent()
    inner: Any = None

    def switched(event: str, greenlets: Any) -> None:
        nonlocal inner, outer
        origin, target = greenlets
        if origin is here:
            inner = sys.gettrace()
            sys.settrace(outer)
        elif target is here:
            outer = sys.gettrace()
            sys.settrace(inner)

    previous = greenlet.settrace(switched)
    try:
        yield
    finally:
        greenlet.settrace(previous)
        sys.settrace(outer)


@cache
def held_by_thread() -> bool:
    """True when `sys.settrace` in one greenlet holds in the others, too. Found by a trial."""
    outer = sys.gettrace()
    home = greenlet.getcurrent()

    def mark(*_: object) -> None:
        return None

    def probe() -> None:
        sys.settrace(mark)
        home.switch()
        sys.settrace(None)

    other = greenlet.greenlet(probe)
    other.switch()
    shared = sys.gettrace() is mark
    other.switch()
    sys.settrace(outer)
    return shared
