"""`FormulaMonitor`, the base class of all monitors, and `ConditionMonitor`, which says when a condition was true.

A `MonitorSet` calls `evaluate` at each instant at which the formula may change.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from array import array
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence

from pytest_hricdv.monitor.evaluation_state import (
    NO_MESSAGE,
    EvaluationState,
    Nanoseconds,
    Outputs,
    UnknownValueError,
    nanoseconds,
    seconds,
)
from pytest_hricdv.monitor.program import MonitorProgram


class FormulaMonitor(ABC):
    """Monitors one formula during one run.

    Attributes:
        shows: signals that only violations report.
        kinds: signals and fields whose values are needed -> type.
        active: a trigger is open, so updates of `trigger_sources` require an evaluation.
        wake_ns: the next time at which an evaluation is needed without an update.
    """

    program: MonitorProgram

    def __init__(self, program: MonitorProgram, state: EvaluationState, shows: Sequence[str] = ()) -> None:
        self.program = program
        self.shows = frozenset(shows) - program.kinds.keys()
        self.kinds = {**dict.fromkeys(shows, float), **program.kinds}
        self.active = False
        self.wake_ns: Nanoseconds = math.inf
        self._state = state
        self._run_operators = [make() for make in program.run_operators]
        self._condition = program.condition

    def evaluate(self, now_ns: Nanoseconds, *, last: bool, first: bool = False) -> None:
        """Judge the instant `now_ns`, after all its updates, and the time right after it unless it is the `last`.

        `first`: the run starts at this instant, and nothing that this formula reads was updated at it. Past operators
        start here all the same, and so does a trigger if the antecedent is known and true.
        """
        state = self._state
        # In the order of compilation: an operator reads the outputs of those inside it.
        for operator in self._run_operators:
            operator.step(now_ns, state)
        if not first or self._can_start():
            self._judge(now_ns, state.arrived, state.at, right_after=False)
            if not last and not self.program.right_continuous:
                self._judge(now_ns, NO_MESSAGE, state.after, right_after=True)
        self.wake_ns = self._response_wake_ns(now_ns)
        # A loop instead of min(): this runs at every evaluation, and most monitors have no operator.
        for operator in self._run_operators:
            if operator.wake_ns < self.wake_ns:
                self.wake_ns = operator.wake_ns

    @abstractmethod
    def _can_start(self) -> bool:
        """Whether what is needed at the start of the run is known by now."""

    @abstractmethod
    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        """Judge one instant, or the time right after it."""

    def _response_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        """The next time at which an open trigger has to be judged without an update."""
        return math.inf


class ConditionMonitor(FormulaMonitor):
    """The truth of a condition over a run; made by `MonitorSet.watch`.

    Before the values that it reads are known, a condition is false.
    """

    def __init__(
        self, program: MonitorProgram, state: EvaluationState, changed: Callable[[float, bool], None] | None = None
    ) -> None:
        super().__init__(program, state)
        self._changed = changed
        # The times at which its truth changed: twice the time (ns), plus 1 for right after it. It is false at first.
        self._changes = array("q")

    @property
    def holds(self) -> bool:
        """Whether it is true now, as far as time has been judged."""
        return len(self._changes) % 2 == 1

    def holds_at(self, time_s: float) -> bool:
        """Whether it was true at a time (s), as far as time has been judged."""
        # Changes right after the time are behind those at it, and do not count yet.
        return bisect_right(self._changes, 2 * nanoseconds(time_s)) % 2 == 1

    @property
    def began_s(self) -> tuple[float, ...]:
        """When it became true (s), in order: at that time, or right after it."""
        return tuple(seconds(change // 2) for change in self._changes[::2])

    def _can_start(self) -> bool:
        return True

    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        try:
            holds = self._condition(self._state.values, arrived, outputs)
        except UnknownValueError:
            holds = False
        if holds != self.holds:
            self._changes.append(2 * now_ns + right_after)  # type: ignore[arg-type]
            if self._changed is not None:
                self._changed(seconds(now_ns), holds)
