"""The stateful operators of a compiled formula whose outputs are numbers: counts, and times between occurrences.

The terms `Count` and `TimeBetween` compile to them. An occurrence is a message, or a condition that becomes true.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from collections.abc import Sequence

from pytest_hricdv.monitor.evaluation_state import EvaluationState, Measure, Nanoseconds, UnknownValueError, seconds
from pytest_hricdv.monitor.operators import Operator

Number = float | None
"""The value of an operator; None before it has one."""


class NumberOperator(Operator):
    """A number that changes with occurrences.

    Args:
        occurrences: the number of occurrences at the instant, one function for each operand.
    """

    initial: Number = None
    """Just before the first instant."""

    def __init__(self, index: int, *occurrences: Measure) -> None:
        super().__init__(index)
        self._occurrences = occurrences

    def step(self, now_ns: Nanoseconds, state: EvaluationState) -> None:
        index = self._index
        try:
            new = [int(occurrences(state.values, state.arrived, state.at)) for occurrences in self._occurrences]
        except UnknownValueError as unknown:
            if self._started:
                raise
            self._mark_unknown(state, unknown.name)
            return
        state.before[index] = state.after[index] if self._started else self.initial
        self._started = True
        state.at[index], state.after[index] = self._advance(now_ns, new)

    @abstractmethod
    def _advance(self, now_ns: Nanoseconds, new: Sequence[int]) -> tuple[Number, Number]:
        """The outputs at `now_ns` and right after it, from the occurrences at that instant."""


class CountOperator(NumberOperator):
    """How many occurrences there were in [now - end, now - start]."""

    initial = 0

    def __init__(self, index: int, occurrences: Measure, start_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        super().__init__(index, occurrences)
        self._start_ns = start_ns
        self._end_ns = end_ns
        self._count = 0
        self._entering_ns: deque[Nanoseconds] = deque()  # when occurrences come into the window
        self._leaving_ns: deque[Nanoseconds] = deque()  # right after which they are out of it

    def _advance(self, now_ns: Nanoseconds, new: Sequence[int]) -> tuple[Number, Number]:
        self._entering_ns.extend([now_ns + self._start_ns] * new[0])
        while self._entering_ns and self._entering_ns[0] <= now_ns:
            entered_ns = self._entering_ns.popleft()
            self._count += 1
            if self._end_ns < math.inf:  # without an end, occurrences are counted for ever and need not be kept
                self._leaving_ns.append(entered_ns - self._start_ns + self._end_ns)
        count_at = self._count
        while self._leaving_ns and self._leaving_ns[0] <= now_ns:
            self._leaving_ns.popleft()
            self._count -= 1
        self.wake_ns = min(next(iter(self._entering_ns), math.inf), next(iter(self._leaving_ns), math.inf))
        return count_at, self._count


class TimeBetweenOperator(NumberOperator):
    """The time (s) from the latest occurrence of the first operand to the latest one of the second after it."""

    def __init__(self, index: int, begins: Measure, ends: Measure) -> None:
        super().__init__(index, begins, ends)
        self._began_ns: Nanoseconds | None = None
        self._elapsed_s: Number = None

    def _advance(self, now_ns: Nanoseconds, new: Sequence[int]) -> tuple[Number, Number]:
        begins, ends = new
        if begins:
            self._began_ns = now_ns
        if ends and self._began_ns is not None:  # at one instant, the beginning counts first: the time is 0
            self._elapsed_s = seconds(now_ns - self._began_ns)
        return self._elapsed_s, self._elapsed_s
