"""Traces the statements of the code under test that a run executed up to a violation, in order.

`runs` and `executed_lines` give a `Tracer` to a run as its measurement; its `until` returns the `ViolationTrace`.
Ordinary runs are measured by coverage, which costs little, but says only what was executed, not when. So only the few
failing tests that are rerun for a diagnosis are traced statement by statement.
"""

from __future__ import annotations

import sys
import traceback
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

import greenlet

from pytest_hricdv._base.record import Count, Number, PlainRecord
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.greenlet_settrace import forget_left_greenlets, keep_to_this_greenlet
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.runtime.record import Value

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

MAX_STEPS = 2_000_000
"""Number of steps after which tracing of a run ends. Chosen: 32 MB; a run of the table has some 10,000."""

_RETURNED = -1  # in place of a statement's number: the function returned


@dataclass(frozen=True, slots=True)
class TraceStep:
    """A line that was executed: the time (s), the number (from 0) of the node, and the statement's file and line."""

    time_s: float
    node: int
    file: str
    line: int


class ExecutedStatement(PlainRecord, frozen=True, kw_only=True):
    """A statement that a run has executed.

    Args:
        line: first line.
        node: the number (from 0) of the node that executed it last.
        step: the number of lines executed up to its last execution.
        time_s: the time of its last execution (s, simulated).
        times: how often it was executed.
    """

    file: str
    line: Count
    node: Count
    step: Count
    time_s: Number
    times: Count


class ViolationTrace(PlainRecord, frozen=True, kw_only=True):
    """The statements that a run executed up to a time.

    Args:
        until_s: this time (s of simulated time).
        executed: each statement once, the last one first.
        branches: the branches that it took: file, and from which line to which one; 0 for the end of the function.
        stood: where each node stood then: file and first line of statements, the innermost first.
        raised: the innermost statement of the code under test that an error came through, which ended the run.
        is_said: whether it ends with a message, which only says what was decided before.
    """

    until_s: Number
    is_said: bool = False
    executed: tuple[ExecutedStatement, ...] = ()
    branches: tuple[tuple[str, Count, Count], ...] = ()
    stood: tuple[tuple[tuple[str, Count], ...], ...] = ()
    raised: tuple[str, Count] | None = None


@dataclass
class Tracer:
    """Traces one run; a `Measurement` (see `coverage.measurement`) that measures no coverage, and a `Watcher`."""

    code: CodeMap
    reason: str = "the run is traced instead"
    _now_s: Callable[[], float] = field(default=lambda: 0.0, init=False)
    _raised: Callable[[], BaseException | None] = field(default=lambda: None, init=False)
    _times_s: array[float] = field(default_factory=lambda: array("d"), init=False)
    _places: array[int] = field(default_factory=lambda: array("l"), init=False)
    """Number of the statement that is executed; `_RETURNED` where a function ends."""
    _depths: array[int] = field(default_factory=lambda: array("l"), init=False)
    """The number of enclosing functions of the code under test in its node."""
    _nodes: array[int] = field(default_factory=lambda: array("l"), init=False)
    _numbers: dict[int, int] = field(default_factory=dict, init=False)
    """The numbers of nodes."""
    _event_times_s: array[float] = field(default_factory=lambda: array("d"), init=False)
    _events: list[tuple[str, bool, int]] = field(default_factory=list, init=False)
    """Topic or signal, whether it is a topic, and how many lines had been executed by then."""

    def __post_init__(self) -> None:
        self._all = [(file.name, line) for file in self.code.files for line in file.statements]
        self._files: dict[str, tuple[int, tuple[int, ...]]] = {}
        first = 0
        for file in self.code.files:
            self._files[str(file.path)] = first, file.statements
            first += len(file.statements)

    def begin(self, code: CodeUnderTest) -> None:
        """Set the clock; passed to `execute`, which calls it."""
        self._now_s = lambda: code.now_s
        self._raised = lambda: code.raised

    def watch_imports(self, context: str) -> AbstractContextManager[None]:
        """Notes nothing."""
        return nullcontext()

    def measure(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, traced when it is run in a greenlet of its own."""

        def trace_node() -> None:
            with keep_to_this_greenlet():
                sys.settrace(self._trace)
                return body()

        return trace_node

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """See `Watcher`."""
        self._event(time_s, topic, is_message=True)

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """See `Watcher`."""
        self._event(time_s, name, is_message=False)

    def _event(self, time_s: float, name: str, *, is_message: bool) -> None:
        self._event_times_s.append(time_s)
        self._events.append((name, is_message, len(self._places)))

    def _end(self, time_s: float, names: Collection[str] | None) -> tuple[int, bool]:
        """The number of lines executed before the event at a time (s), and whether this is a message.

        All lines until then if there is no event.
        """
        first, after = (bisect(self._event_times_s, time_s) for bisect in (bisect_left, bisect_right))
        for name, is_message, lines in reversed(self._events[first:after]):
            if is_message if names is None else name in names:
                return lines, is_message
        return bisect_right(self._times_s, time_s), False

    def steps(self) -> Iterator[TraceStep]:
        """The executed steps, in order."""
        for time_s, node, place in zip(self._times_s, self._nodes, self._places, strict=True):
            if place != _RETURNED:
                yield TraceStep(time_s, node, *self._all[place])

    def until(self, time_s: float, names: Collection[str] | None = None, *, to_end: bool = False) -> ViolationTrace:
        """The trace up to a violation.

        Virtual time stands still while code runs, so the code may continue at the same time after its mistake.

        Args:
            time_s: when (s of simulated time).
            names: topics and signals of which one violates the requirement; None: any message may.
            to_end: up to the end of the run, whose time may be rounded, as for a fault of the whole run.
        """
        end, is_said = (len(self._places), False) if to_end else self._end(time_s, names)
        last: dict[int, int] = {}
        times: dict[int, int] = {}
        for step, place in enumerate(self._places[:end]):
            last[place] = step
            times[place] = times.get(place, 0) + 1
        last.pop(_RETURNED, None)
        executed = (
            ExecutedStatement(
                file=self._all[place][0],
                line=self._all[place][1],
                node=self._nodes[step],
                step=step + 1,
                time_s=round(self._times_s[step], 6),
                times=times[place],
            )
            for place, step in sorted(last.items(), key=lambda item: -item[1])
        )
        stacks, taken = self._follow(end)
        return ViolationTrace(
            until_s=time_s,
            is_said=is_said,
            executed=tuple(executed),
            branches=tuple(
                (*self._all[place], 0 if to == _RETURNED else self._all[to][1]) for place, to in sorted(taken)
            ),
            stood=tuple(tuple(self._all[place] for place in reversed(stack)) for _, stack in sorted(stacks.items())),
            raised=self._source_of_error() if to_end else None,
        )

    def _source_of_error(self) -> tuple[str, int] | None:
        error = self._raised()
        steps = [] if error is None else [*traceback.walk_tb(error.__traceback__)]
        for frame, line in reversed(steps):
            if (where := self._files.get(frame.f_code.co_filename)) is not None:
                return self._all[_statement(where, line)]
        return None

    def _follow(self, end: int) -> tuple[dict[int, list[int]], set[tuple[int, int]]]:
        """The statements that each node is in, the outermost first; and which statement followed which."""
        stacks: dict[int, list[int]] = {}
        taken = set()
        for step in range(end):
            place, depth = self._places[step], self._depths[step]
            stack = stacks.setdefault(self._nodes[step], [])
            if len(stack) > depth:
                taken.add((stack[depth], place))
            del stack[depth:]
            if place != _RETURNED:
                stack += [place] * (depth + 1 - len(stack))
        return stacks, taken

    def _trace(self, frame: FrameType, event: str, argument: Any) -> Any:
        """See `sys.settrace`: called where a function begins, then for each of its lines, and where it ends."""
        where = self._files.get(frame.f_code.co_filename)
        if where is None or len(self._places) >= MAX_STEPS:
            return None
        if event in ("line", "return"):
            here = _statement(where, frame.f_lineno)
            self._times_s.append(self._now_s())
            self._places.append(here if event == "line" else _RETURNED)
            self._depths.append(self._depth(frame))
            self._nodes.append(self._numbers.setdefault(id(greenlet.getcurrent()), len(self._numbers)))
        return self._trace

    def _depth(self, frame: FrameType) -> int:
        depth, around = 0, frame.f_back
        while around is not None:
            depth += around.f_code.co_filename in self._files
            around = around.f_back
        return depth


def _statement(where: tuple[int, tuple[int, ...]], line: int) -> int:
    """Number of the statement that a line is in; `where`: the first one of the file, and all lines."""
    first, statements = where
    return first + max(0, bisect_right(statements, line) - 1)
