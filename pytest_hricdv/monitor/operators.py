"""The stateful parts of a formula: past operators, and comparisons with hysteresis.

Each is stepped at every instant at which its operand can change, and at its own `wake_ns`. Times are whole
nanoseconds, so that a bound of a window falls together with an update that comes exactly there.

Before an operator's operand is first known the operator is itself unknown. Just before that, the operand counts as
what it is then without a message, so that the first value of a signal is no edge, but a first message is one.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass

from pytest_hricdv.monitor.errors import UnknownValueError
from pytest_hricdv.monitor.view import NO_MESSAGE, Condition, Nanoseconds, View


class Operator(ABC):
    """One stateful operator in one run; `index` is its number in the program.

    `wake_ns` is the next time at which it may change by itself; infinity if there is none.
    """

    wake_ns: Nanoseconds = math.inf

    def __init__(self, index: int) -> None:
        self._index = index
        self._begun = False

    @abstractmethod
    def step(self, now_ns: Nanoseconds, view: View) -> None:
        """Bring the outputs `view.at` and `view.after` to `now_ns`."""

    def _stay_unknown(self, view: View, name: str) -> None:
        for outputs in (view.before, view.at, view.after):
            outputs.unknown[self._index] = name


class PastOperator(Operator):
    """An operator of the formulas `operands`."""

    def __init__(self, index: int, *operands: Condition) -> None:
        super().__init__(index)
        self._operands = operands

    def step(self, now_ns: Nanoseconds, view: View) -> None:
        index = self._index
        try:
            at = [operand(view.values, view.arrived, view.at) for operand in self._operands]
            after = [operand(view.values, NO_MESSAGE, view.after) for operand in self._operands]
            if not self._begun:
                before = [operand(view.values, NO_MESSAGE, view.before) for operand in self._operands]
        except UnknownValueError as unknown:
            if self._begun:
                raise
            self._stay_unknown(view, unknown.name)
            return
        if not self._begun:
            self._begun = True
            view.after[index] = self._begin(now_ns, before)
        view.before[index] = view.after[index]
        view.at[index], view.after[index] = self._advance(now_ns, at, after)

    @abstractmethod
    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        """Start; `before` are the operands just before `now_ns`. Returns what the operator said then."""

    @abstractmethod
    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        """What the operator says at `now_ns` and right after, from its operands at both."""


class RiseOperator(PastOperator):
    """The operand turns true at the instant or right after it."""

    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._before = before[0]
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        rises = at[0] > self._before or after[0] > at[0]
        self._before = after[0]
        return rises, False


class PreviouslyOperator(PastOperator):
    """The operand as it was just before."""

    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._before = before[0]
        return before[0]

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        before, self._before = self._before, after[0]
        return before, after[0]


class SinceOperator(PastOperator):
    """The second operand was true, and the first has been ever since."""

    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        self._holds = False
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        holds = at[1] or (at[0] and self._holds)
        self._holds = after[1] or (after[0] and holds)
        return holds, self._holds


@dataclass(slots=True)
class _Stretch:
    """A stretch of time over which `once` is true: the operand's, moved by the window. Ends may be open or closed."""

    start_ns: Nanoseconds
    start_open: bool
    end_ns: Nanoseconds = math.inf
    end_open: bool = False


class OnceOperator(PastOperator):
    """The operand was true somewhere in [now - end, now - start]."""

    def __init__(self, index: int, operand: Condition, start_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        super().__init__(index, operand)
        self._start_ns = start_ns
        self._end_ns = end_ns
        self._stretches: deque[_Stretch] = deque()
        self._holds = False

    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        for holds, right_after in ((at[0], False), (after[0], True)):
            if holds != self._holds:
                self._holds = holds
                (self._open if holds else self._close)(now_ns, right_after)
        stretches = self._stretches
        now = any(_contains(stretch, now_ns) for stretch in stretches)
        soon = any(stretch.start_ns <= now_ns < stretch.end_ns for stretch in stretches)
        while stretches and stretches[0].end_ns <= now_ns:
            stretches.popleft()
        ends = (end for stretch in stretches for end in (stretch.start_ns, stretch.end_ns) if end > now_ns)
        self.wake_ns = min(ends, default=math.inf)
        return now, soon

    def _open(self, now_ns: Nanoseconds, right_after: bool) -> None:
        start_ns = now_ns + self._start_ns
        last = self._stretches[-1] if self._stretches else None
        if last is not None and start_ns < last.end_ns:
            last.end_ns = math.inf  # they overlap: one stretch, so that a chattering operand costs no memory
        else:
            self._stretches.append(_Stretch(start_ns, right_after))

    def _close(self, now_ns: Nanoseconds, right_after: bool) -> None:
        last = self._stretches[-1]
        last.end_ns, last.end_open = now_ns + self._end_ns, not right_after


def _contains(stretch: _Stretch, now_ns: Nanoseconds) -> bool:
    starts = stretch.start_ns < now_ns if stretch.start_open else stretch.start_ns <= now_ns
    ends = now_ns < stretch.end_ns if stretch.end_open else now_ns <= stretch.end_ns
    return starts and ends


class ForOperator(PastOperator):
    """The operand, a comparison, has been true for a length of time, all of it within the run."""

    def __init__(self, index: int, operand: Condition, length_ns: Nanoseconds) -> None:
        super().__init__(index, operand)
        self._length_ns = length_ns
        self._since_ns = math.inf

    def _begin(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        if not at[0]:
            self._since_ns = math.inf
        elif self._since_ns == math.inf:
            self._since_ns = now_ns
        due_ns = self._since_ns + self._length_ns
        self.wake_ns = due_ns if due_ns > now_ns else math.inf
        return due_ns <= now_ns, due_ns <= now_ns


class HysteresisOperator(Operator):
    """A comparison that, once false, is true again only past its bound by the hysteresis.

    Args:
        bound: the comparison with its own bound.
        return_bound: the same with the bound to come back over.
    """

    def __init__(self, index: int, bound: Condition, return_bound: Condition) -> None:
        super().__init__(index)
        self._bound = bound
        self._return_bound = return_bound
        self._violated = False

    def reset(self) -> None:
        """Forget past violations: a new attempt is judged by the bound itself."""
        self._violated = False

    def step(self, now_ns: Nanoseconds, view: View) -> None:
        # Signals last, so the instant and the time after it are one here; and this runs at every physics substep.
        index = self._index
        comparison = self._return_bound if self._violated else self._bound
        try:
            holds = comparison(view.values, NO_MESSAGE, view.at)
        except UnknownValueError as unknown:
            self._stay_unknown(view, unknown.name)
            return
        view.before[index] = not self._violated if self._begun else holds
        view.at[index] = view.after[index] = holds
        self._violated = not holds
        self._begun = True
