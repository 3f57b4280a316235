"""`keep_to_this_greenlet`: limits a trace function to one greenlet, so that only the code under test is traced.

`OwnCoverage` and the measurements use it while the code under test runs. Depending on the versions of Python and
greenlet, `sys.settrace` holds for the greenlet that called it or for the whole thread. In the second case the trace
function has to be removed and restored whenever control leaves the measured greenlet and returns. This is done in
greenlet's switch callback: greenlet suspends tracing around it, so the tracer's call stack stays consistent. (Stopping
and starting the measurement instead would lose it.)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any
from weakref import WeakKeyDictionary

import greenlet

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class _Tracers:
    """The trace functions of the greenlets that have one of their own, where Python has one for the whole thread."""

    def __init__(self) -> None:
        # Weak: code that makes many greenlets does not keep those that have ended.
        self._own = WeakKeyDictionary[greenlet.greenlet, Any]()
        self._inner = WeakKeyDictionary[greenlet.greenlet, greenlet.greenlet]()
        """A greenlet that was made within a measured one -> this: gevent and SQLAlchemy make some unasked."""
        self._outer: Any = None
        self._previous: Any = None

    @contextmanager
    def keep(self) -> Iterator[None]:
        """While the body runs, the current greenlet has a trace function of its own."""
        here = greenlet.getcurrent()
        if not self._own:
            self._outer = sys.gettrace()
            self._previous = greenlet.settrace(self._on_switch)
        self._own[here] = None
        try:
            yield
        finally:
            for inner in [inner for inner, outside in self._inner.items() if outside is here]:
                self._own.pop(inner, None)
                self._inner.pop(inner, None)
            self._own.pop(here, None)  # gone where it was left as it was, see `reset`
            if not self._own:
                greenlet.settrace(self._previous)
            sys.settrace(self._outer)

    def reset(self) -> None:
        """Forget greenlets that were left where they are, and will not continue."""
        if self._own:
            self._own.clear()
            self._inner.clear()
            greenlet.settrace(self._previous)

    def _on_switch(self, event: str, greenlets: Any) -> None:
        origin, target = greenlets
        if origin in self._own:
            self._own[origin] = sys.gettrace()
        else:
            self._outer = sys.gettrace()
        if target not in self._own:
            self._measure_within(target)
        tracer = self._own.get(target, self._outer)
        sys.settrace(tracer)
        if self._inner and target in self._own and type(tracer).__name__ == "CTracer":
            # It keeps a stack for each greenlet, and looks for the present one only where a function begins or ends.
            # Between nodes one does; where code switches itself, the lines up to the next call would be lost.
            frame = sys._getframe()
            tracer(frame, "call", None)
            tracer(frame, "return", None)

    def _measure_within(self, target: greenlet.greenlet) -> None:
        """A greenlet made by what is measured is measured as well."""
        parent = target.parent
        if parent is not None and parent in self._own:
            self._own[target] = self._own[parent]
            self._inner[target] = self._inner.get(parent, parent)


_TRACERS = _Tracers()
"""One for the process, like the trace function."""


@contextmanager
def keep_to_this_greenlet() -> Iterator[None]:
    """While the body runs, what it sets with `sys.settrace` holds in the current greenlet only."""
    if is_held_by_thread():
        with _TRACERS.keep():
            yield
        return
    outer = sys.gettrace()
    try:
        yield
    finally:
        sys.settrace(outer)


def forget_left_greenlets() -> None:
    """Between runs no greenlet is measured: measured ones were left behind."""
    _TRACERS.reset()


@cache
def is_held_by_thread() -> bool:
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
