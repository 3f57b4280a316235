"""The stateful operators of a compiled formula: past operators, and comparisons with hysteresis.

Monitors step each operator at every instant at which its operand can change, and at its own `wake_ns`. Times are whole
nanoseconds, so that a bound of a window and an update at the same time are one instant.

The output of an operator is unknown until its operands are known. Just before the first known instant, an operand
counts as having the value that it has at that instant without messages (`EvaluationState.values_before`): the first
value of a signal is not an edge, but a first message is.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass

from pytest_hricdv.monitor.evaluation_state import (
    NO_MESSAGE,
    Condition,
    EvaluationState,
    Nanoseconds,
    UnknownValueError,
)


class Operator(ABC):
    """One stateful operator in one run; `index` is its number in the program.

    `wake_ns` is the next time at which the output may change without an update; infinity if there is none.
    """

    wake_ns: Nanoseconds = math.inf

    def __init__(self, index: int) -> None:
        self._index = index
        self._started = False

    @abstractmethod
    def step(self, now_ns: Nanoseconds, state: EvaluationState) -> None:
        """Compute the outputs at `now_ns`, `state.at`, and right after it, `state.after`."""

    def _mark_unknown(self, state: EvaluationState, name: str) -> None:
        for outputs in (state.before, state.at, state.after):
            outputs.unknown[self._index] = name


class PastOperator(Operator):
    """An operator over past formulas, its `operands`."""

    def __init__(self, index: int, *operands: Condition) -> None:
        super().__init__(index)
        self._operands = operands

    def step(self, now_ns: Nanoseconds, state: EvaluationState) -> None:
        index = self._index
        try:
            # Both, because an operand that is true only at the instant, or only right after it, is a separate edge.
            at = [operand(state.values, state.arrived, state.at) for operand in self._operands]
            after = [operand(state.values, NO_MESSAGE, state.after) for operand in self._operands]
            if not self._started:
                values = state.values_before()
                before = [operand(values, NO_MESSAGE, state.before) for operand in self._operands]
        except UnknownValueError as unknown:
            if self._started:
                raise
            self._mark_unknown(state, unknown.name)
            return
        if not self._started:
            self._started = True
            state.after[index] = self._start(now_ns, before)
        state.before[index] = state.after[index]
        state.at[index], state.after[index] = self._advance(now_ns, at, after)

    @abstractmethod
    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        """Start with the operands just before `now_ns`; returns the output of the operator at that time."""

    @abstractmethod
    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        """The outputs at `now_ns` and right after it, from the operands at both."""


class RiseOperator(PastOperator):
    """The operand becomes true at the instant or right after it."""

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._before = before[0]
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        rises = at[0] > self._before or after[0] > at[0]
        self._before = after[0]
        return rises, False


class PreviouslyOperator(PastOperator):
    """The operand just before the instant."""

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._before = before[0]
        return before[0]

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        before, self._before = self._before, after[0]
        return before, after[0]


class SinceOperator(PastOperator):
    """The second operand was true, and the first has been true since then."""

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._holds = False
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        holds = at[1] or (at[0] and self._holds)
        self._holds = after[1] or (after[0] and holds)
        return holds, self._holds


@dataclass(slots=True)
class _Interval:
    """A time interval in which `once` is true: one of the operand, shifted by the window. Ends are open or closed."""

    start_ns: Nanoseconds
    start_open: bool
    end_ns: Nanoseconds = math.inf
    end_open: bool = False


class OnceOperator(PastOperator):
    """The operand was true at some time in [now - end, now - start]."""

    def __init__(self, index: int, operand: Condition, start_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        super().__init__(index, operand)
        self._start_ns = start_ns
        self._end_ns = end_ns
        self._intervals: deque[_Interval] = deque()
        self._holds = False

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        for holds, right_after in ((at[0], False), (after[0], True)):
            if holds != self._holds:
                self._holds = holds
                (self._open_interval if holds else self._close_interval)(now_ns, right_after)
        intervals = self._intervals
        # They do not overlap and are in the order of time, so only the first ones can be over, and only the first of
        # the others can hold: each is looked at in front, and left behind once.
        holds_at = False
        while intervals and intervals[0].end_ns <= now_ns:
            holds_at |= _contains(intervals.popleft(), now_ns)
        if not intervals:
            self.wake_ns = math.inf
            return holds_at, False
        first = intervals[0]
        holds_at = holds_at or _contains(first, now_ns)
        holds_after = first.start_ns <= now_ns
        self.wake_ns = first.end_ns if holds_after else first.start_ns
        return holds_at, holds_after

    def _open_interval(self, now_ns: Nanoseconds, right_after: bool) -> None:
        start_ns = now_ns + self._start_ns
        last = self._intervals[-1] if self._intervals else None
        if last is not None and start_ns < last.end_ns:
            last.end_ns = math.inf  # overlapping intervals are merged, so that a chattering operand needs no memory
        else:
            self._intervals.append(_Interval(start_ns, right_after))

    def _close_interval(self, now_ns: Nanoseconds, right_after: bool) -> None:
        # False at the instant itself, the interval ends before it; false only right after, the instant belongs to it.
        last = self._intervals[-1]
        last.end_ns, last.end_open = now_ns + self._end_ns, not right_after


def _contains(interval: _Interval, now_ns: Nanoseconds) -> bool:
    starts = interval.start_ns < now_ns if interval.start_open else interval.start_ns <= now_ns
    ends = now_ns < interval.end_ns if interval.end_open else now_ns <= interval.end_ns
    return starts and ends


class ForOperator(PastOperator):
    """The operand, a comparison, has been true for a duration, all of it within the run."""

    def __init__(self, index: int, operand: Condition, length_ns: Nanoseconds) -> None:
        super().__init__(index, operand)
        self._length_ns = length_ns
        self._since_ns = math.inf  # as long as it does not hold: no time is late enough
        self._since_open = False

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        self._continue(now_ns, holds=at[0], right_after=False)
        due_ns = self._since_ns + self._length_ns
        holds_at = due_ns < now_ns or (due_ns == now_ns and not self._since_open)
        self._continue(now_ns, holds=after[0], right_after=True)
        due_ns = self._since_ns + self._length_ns
        self.wake_ns = due_ns if due_ns > now_ns else math.inf
        return holds_at, due_ns <= now_ns

    def _continue(self, now_ns: Nanoseconds, *, holds: bool, right_after: bool) -> None:
        if not holds:
            self._since_ns = math.inf
        elif self._since_ns == math.inf:
            self._since_ns, self._since_open = now_ns, right_after


class TimeSinceOperator(PastOperator):
    """The operand was last true less than a time ago; with `closed`, exactly that time ago as well."""

    def __init__(self, index: int, operand: Condition, bound_ns: Nanoseconds, *, closed: bool) -> None:
        super().__init__(index, operand)
        self._bound_ns = bound_ns
        self._closed = closed
        self._holds = False
        self._last_ns = -math.inf  # of the times at which it was true, the latest; before any, infinitely long ago

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        if self._holds or at[0]:
            self._last_ns = now_ns
        elapsed_ns = now_ns - self._last_ns
        holds_at = elapsed_ns < self._bound_ns or (self._closed and elapsed_ns == self._bound_ns)
        self._holds = after[0]
        if self._holds:  # from now on the elapsed time stays 0
            self._last_ns = now_ns
            self.wake_ns = math.inf
            return holds_at, self._closed or self._bound_ns > 0
        due_ns = self._last_ns + self._bound_ns
        self.wake_ns = due_ns if due_ns > now_ns else math.inf
        return holds_at, elapsed_ns < self._bound_ns


class HysteresisOperator(Operator):
    """A comparison that, once false, is true again only when it passes its bound by the hysteresis.

    Args:
        bound: the comparison with its own bound.
        return_bound: the comparison with the bound shifted by the hysteresis.
    """

    def __init__(self, index: int, bound: Condition, return_bound: Condition) -> None:
        super().__init__(index)
        self._bound = bound
        self._return_bound = return_bound
        self._violated = False

    def reset(self) -> None:
        """Forget past violations: a new trigger is judged by the bound itself."""
        self._violated = False

    def step(self, now_ns: Nanoseconds, state: EvaluationState) -> None:
        # Signals are right-continuous, so the outputs at the instant and right after it are equal. This runs at every
        # physics substep.
        index = self._index
        comparison = self._return_bound if self._violated else self._bound
        try:
            holds = comparison(state.values, NO_MESSAGE, state.at)
        except UnknownValueError as unknown:
            self._mark_unknown(state, unknown.name)
            return
        state.before[index] = not self._violated if self._started else holds
        state.at[index] = state.after[index] = holds
        self._violated = not holds
        self._started = True
