"""Tracing: which statements of the code under test a run executed up to a violation, in which order, and where the code
stood then.

Ordinary runs are measured by coverage, which says what was executed and not when: this costs nothing to speak of. Only
the few failing tests that are run again for a diagnosis are traced statement by statement.
"""

from __future__ import annotations

import sys
from bisect import bisect_right
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

import greenlet

from pytest_hricdv._base.record import Count, Number, PlainRecord
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.greenlet_settrace import forget_left_greenlets, kept_to_this_greenlet
from pytest_hricdv.execution.faults import CodeUnderTest

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

Place = tuple[str, int]
"""Name of a file, and first line of a statement."""


class Executed(PlainRecord, frozen=True, kw_only=True):
    """A statement of which a run has executed something.

    Args:
        file: name.
        line: first line.
        step: when last, counted in lines that were executed, from 1.
        time_s: when last, in simulated time.
        times: how often.
    """

    file: str
    line: Count
    step: Count
    time_s: Number
    times: Count


class Trace(PlainRecord, frozen=True, kw_only=True):
    """What a run executed up to a time.

    Args:
        until_s: this time (s of simulated time).
        executed: each statement once, the last one last.
        stood: of each node, where it stood then: file and first line of statements, the innermost first.
    """

    until_s: Number
    executed: tuple[Executed, ...] = ()
    stood: tuple[tuple[tuple[str, Count], ...], ...] = ()


@dataclass
class Tracing:
    """Traces one run; a `Measurement` (see `coverage.measurement`) that measures no coverage.

    Args:
        code: that is traced.
        until_s: up to this time (s of simulated time).
    """

    code: CodeMap
    until_s: float
    reason: str = "the run is traced instead"
    _now_s: Callable[[], float] = field(default=lambda: 0.0, init=False)
    _steps: int = field(default=0, init=False)
    _count: dict[Place, int] = field(default_factory=dict, init=False)
    _last: dict[Place, tuple[int, float]] = field(default_factory=dict, init=False)
    _stood: dict[int, tuple[Place, ...]] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self._files = {str(file.path): (file.name, file.statements) for file in self.code.files}

    def begun(self, code: CodeUnderTest) -> None:
        """To be given to `execute`, which calls it: whose clock it is."""
        self._now_s = lambda: code.now_s

    def importing(self, context: str) -> AbstractContextManager[None]:
        """Notes nothing."""
        return nullcontext()

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, traced when it is run in a greenlet of its own."""

        def traced() -> None:
            with kept_to_this_greenlet():
                sys.settrace(self._trace)
                body()

        return traced

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()

    def trace(self) -> Trace:
        """Of the run, when it is over."""
        executed = (
            Executed(file=place[0], line=place[1], step=step, time_s=time_s, times=self._count[place])
            for place, (step, time_s) in self._last.items()
        )
        ordered = tuple(sorted(executed, key=lambda statement: statement.step))
        return Trace(until_s=self.until_s, executed=ordered, stood=tuple(self._stood.values()))

    def _trace(self, frame: FrameType, event: str, argument: Any) -> Any:
        """See `sys.settrace`: called where a function begins, then for each of its lines, and where it ends."""
        if frame.f_code.co_filename not in self._files:
            return None
        time_s = self._now_s()
        if time_s > self.until_s:
            return None
        here = frame if event != "return" else frame.f_back
        if event == "line":
            self._note(self._place(frame), time_s)
        self._stood[id(greenlet.getcurrent())] = self._stack(here)
        return self._trace

    def _note(self, place: Place, time_s: float) -> None:
        self._steps += 1
        self._last[place] = self._steps, time_s
        self._count[place] = self._count.get(place, 0) + 1

    def _place(self, frame: FrameType) -> Place:
        name, statements = self._files[frame.f_code.co_filename]
        return name, statements[max(0, bisect_right(statements, frame.f_lineno) - 1)]

    def _stack(self, frame: FrameType | None) -> tuple[Place, ...]:
        stack = []
        while frame is not None:
            if frame.f_code.co_filename in self._files:
                stack.append(self._place(frame))
            frame = frame.f_back
        return tuple(stack)
