"""The monitor of one requirement: when its triggers begin, and how each kind of response decides them.

A `MonitorSet` has one of each requirement, made by `monitor_of`.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.monitor.evaluation_state import (
    NS_PER_S,
    EvaluationState,
    Nanoseconds,
    Outputs,
    UnknownValueError,
    Value,
    Values,
    nanoseconds,
)
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Holds, HoldsUntil
from pytest_hricdv.monitor.formula_monitor import FormulaMonitor
from pytest_hricdv.monitor.program import RequirementProgram, compile_formula
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Outcome, Verdict, VerdictBuilder


def monitor_of(requirement: Requirement, values: Values, arrived: Mapping[str, int]) -> RequirementMonitor:
    """A new monitor of a requirement; `values` and `arrived` are shared by the monitors of a run."""
    program, shows = compile_formula(requirement.formula, requirement.names), requirement.shows
    state = EvaluationState(values, arrived)
    match requirement.formula.response:
        case Holds():
            return EpisodeMonitor(program, state, shows)
        case Eventually() as window:
            return EventuallyMonitor(program, state, shows, window.start_s, window.end_s)
        case AlwaysWithin() as window:
            return SafetyMonitor(program, state, shows, window.start_s, window.end_s)
        case HoldsUntil():
            return SafetyMonitor(program, state, shows, 0.0, math.inf)


class RequirementMonitor(FormulaMonitor):
    """Monitors one requirement during one run; each kind of response has a subclass."""

    program: RequirementProgram

    def __init__(self, program: RequirementProgram, state: EvaluationState, shows: Sequence[str]) -> None:
        super().__init__(program, state, shows)
        self._trigger_operators = [make() for make in program.trigger_operators]
        self._antecedent = program.antecedent
        self._robustness = program.robustness
        self._verdict = VerdictBuilder(program.alternatives)

    def keep_at_most(self, most: float) -> None:
        """Keep this many violations and triggers; the others are only counted."""
        self._verdict.most = most

    def _can_start(self) -> bool:
        try:
            self._antecedent(self._state.values, self._state.arrived, self._state.at)
        except UnknownValueError:
            return False
        return True

    def deadline_ns(self) -> Nanoseconds | None:
        """The latest deadline of an open `eventually` trigger."""
        return None

    def outcome_so_far(self) -> Outcome:
        """The verdict if all open triggers remained undecided."""
        return self._verdict.outcome

    @abstractmethod
    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        """The verdict at the end of the run, after its last instant was judged."""

    def _note_alternative(self, arrived: Mapping[str, int], outputs: Outputs) -> None:
        """The response holds: strike off the first of its alternatives that does, which is the one that decides."""
        values = self._state.values
        holding = (text for text, holds in self.program.alternatives.items() if holds(values, arrived, outputs))
        self._verdict.unused.pop(next(holding), None)

    def _margin(self, arrived: Mapping[str, int], outputs: Outputs) -> float:
        """The signed distance to the bound; infinite if there is none, or if it is unknown or undefined.

        An unknown distance is not an error: unlike the truth, it reads all parts of the condition, also those that
        are not needed to decide it.
        """
        if self._robustness is None:
            return math.inf
        try:
            return self._robustness(self._state.values, arrived, outputs)
        except (UnknownValueError, ArithmeticError):
            return math.inf

    def _current_values(self, outputs: Outputs) -> dict[str, Value]:
        """The last values of what the requirement reads and shows, and its numbers over the past."""
        values = self._state.values
        last_values: dict[str, Value] = {name: values[name] for name in self.kinds if name in values}
        if not self.program.past_numbers:
            return last_values
        numbers = {text: outputs.get(index) for text, index in self.program.past_numbers.items()}
        return last_values | {text: number for text, number in numbers.items() if number is not None}


@dataclass(slots=True)
class _OpenViolation:
    """A violation that has not ended yet."""

    time_ns: Nanoseconds
    values: dict[str, Value]
    margin: float
    margin_ns: Nanoseconds
    values_ns: dict[str, Nanoseconds] = field(default_factory=dict)


class EpisodeMonitor(RequirementMonitor):
    """State response: a trigger is an episode, in which the antecedent is true without a break."""

    def __init__(self, program: RequirementProgram, state: EvaluationState, shows: Sequence[str]) -> None:
        super().__init__(program, state, shows)
        self._trigger_ns: Nanoseconds = 0
        self._failed = False
        self._violation: _OpenViolation | None = None

    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        state = self._state
        if not self._antecedent(state.values, arrived, outputs):
            if self.active:
                self._end_episode(now_ns)
            return
        if not self.active:
            self._begin_episode(now_ns)
        for operator in self._trigger_operators:
            operator.step(now_ns, state)
        holds = self._condition(state.values, arrived, outputs)
        margin = self._margin(arrived, outputs)
        if margin < self._verdict.margin:
            self._verdict.add_margin(margin, now_ns)
        if not holds:
            self._violate(now_ns, margin, outputs)
            return
        if self._verdict.unused:
            self._note_alternative(arrived, outputs)
        if self._violation is not None:
            self._end_violation()

    def _begin_episode(self, now_ns: Nanoseconds) -> None:
        self.active = True
        self._trigger_ns = now_ns
        self._failed = False
        self._verdict.triggers += 1
        for operator in self._trigger_operators:
            operator.reset()

    def _violate(self, now_ns: Nanoseconds, margin: float, outputs: Outputs) -> None:
        """Begin or continue a violation."""
        # The values are those of its first instant; only what `shows` names is followed to its worst.
        if self._violation is None:
            self._violation = _OpenViolation(now_ns, self._current_values(outputs), margin, now_ns)
        violation, values = self._violation, self._state.values
        if margin < violation.margin:
            violation.margin, violation.margin_ns = margin, now_ns
        for name in violation.values.keys() & self.shows:
            if abs(float(values[name])) > abs(float(violation.values[name])):
                violation.values[name], violation.values_ns[name] = values[name], now_ns

    def _end_violation(self) -> None:
        violation = self._violation
        if violation is not None:
            self._failed = True
            self._verdict.add_violation(
                self._trigger_ns,
                violation.time_ns,
                violation.values,
                violation.margin,
                margin_ns=violation.margin_ns,
                values_ns=violation.values_ns,
            )
            self._violation = None

    def _end_episode(self, now_ns: Nanoseconds) -> None:
        self.active = False
        self._end_violation()
        self._verdict.decide(self._trigger_ns, now_ns, passed=not self._failed)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        if self.active:
            self._end_episode(now_ns)
        return self._verdict.verdict(requirement, pending=0)


class ObligationMonitor(RequirementMonitor):
    """A response in a window that counts from the trigger, which begins whenever the antecedent becomes true.

    All windows of a requirement are equally long, so they begin and end in the order of their triggers. Open triggers
    are therefore two queues: the next window to begin or to end is in front, and what decides one window that has begun
    decides all of them. A trigger enters and leaves each queue once, so an event costs the same however many are open.
    """

    def __init__(
        self, program: RequirementProgram, state: EvaluationState, shows: Sequence[str], start_s: float, end_s: float
    ) -> None:
        super().__init__(program, state, shows)
        self._start_ns = nanoseconds(start_s)
        self._end_ns = nanoseconds(end_s)
        self._triggered = False
        self._waiting: deque[Nanoseconds] = deque()
        """Begins of the open triggers whose windows have not begun."""
        self._due: deque[Nanoseconds] = deque()
        """Begins of the open triggers whose windows have begun: the response is due."""

    def _is_due(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs) -> bool:
        """Whether any response is due now, after the antecedent was judged and windows have begun."""
        waiting, due = self._waiting, self._due
        holds = self._antecedent(self._state.values, arrived, outputs)
        if holds and not self._triggered:
            self._verdict.triggers += 1
            waiting.append(now_ns)
        self._triggered = holds
        # A response may be due at the very instant of its trigger: `eventually[0:b]` can be met by it.
        while waiting and waiting[0] + self._start_ns <= now_ns:
            due.append(waiting.popleft())
        # Both ends belong to a window, and every window ends after its trigger: what is over right after an instant was
        # closed at it.
        return bool(due)

    def _close(self, now_ns: Nanoseconds, *, passed: bool) -> Nanoseconds:
        """Close the first trigger whose window has begun; returns when it began."""
        trigger_ns = self._due.popleft()
        self._verdict.decide(trigger_ns, now_ns, passed=passed)
        return trigger_ns

    def _response_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        begins_ns = self._waiting[0] + self._start_ns if self._waiting else math.inf
        ends_ns = self._due[0] + self._end_ns if self._due else math.inf
        return min(begins_ns, ends_ns)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        pending = [*self._due, *self._waiting]
        for trigger_ns in pending:
            self._verdict.add_pending(trigger_ns, now_ns)
        return self._verdict.verdict(requirement, pending=len(pending))


class EventuallyMonitor(ObligationMonitor):
    """`eventually[a:b]`: discharged when the condition is first true in the window, failed at the deadline.

    The margin of a missed deadline is in time, as in the temporal robustness of Donzé and Maler (Robust satisfaction of
    temporal logic over real-valued signals, FORMATS 2010): how much later the deadline would have had to be.
    """

    def __init__(
        self, program: RequirementProgram, state: EvaluationState, shows: Sequence[str], start_s: float, end_s: float
    ) -> None:
        super().__init__(program, state, shows, start_s, end_s)
        self._missed: list[Nanoseconds] = []
        """The deadlines of the last violations whose response has not come yet, as far as they are kept."""
        self._first_missed = 0
        """The number of the first of them."""

    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        is_due = self._is_due(now_ns, arrived, outputs)
        if is_due or self._missed:
            holds = self._condition(self._state.values, arrived, outputs)
            if is_due and holds:
                self._discharge(now_ns, arrived, outputs)
            elif is_due:
                self._miss(now_ns, outputs)
            if holds and self._missed:
                self._settle(now_ns)
        self.active = bool(self._due or self._waiting or self._missed)

    def _settle(self, now_ns: Nanoseconds) -> None:
        for number, deadline_ns in enumerate(self._missed, self._first_missed):
            self._verdict.came_late(number, now_ns - deadline_ns, now_ns)
        self._missed.clear()

    def _discharge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs) -> None:
        """The condition holds: all whose windows have begun are met."""
        if self._verdict.unused:
            self._note_alternative(arrived, outputs)
        left_ns = self._due[0] + self._end_ns - now_ns  # the others have more time left
        self._verdict.add_margin(left_ns / NS_PER_S, now_ns)
        while self._due:
            self._close(now_ns, passed=True)

    def _miss(self, now_ns: Nanoseconds, outputs: Outputs) -> None:
        """The condition does not hold: triggers whose windows are over have failed."""
        while self._due and (deadline_ns := self._due[0] + self._end_ns) <= now_ns:
            if not self._missed:
                self._first_missed = self._verdict.violations
            if len(self._missed) < self._verdict.most:
                self._missed.append(deadline_ns)
            trigger_ns = self._close(now_ns, passed=False)
            self._verdict.add_violation(trigger_ns, now_ns, self._current_values(outputs), 0.0)

    def deadline_ns(self) -> Nanoseconds | None:
        latest = self._waiting or self._due
        return latest[-1] + self._end_ns if latest else None

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        self._settle(now_ns)  # what has not come by now is late by the rest of the run
        return super().finish(requirement, now_ns)


class SafetyMonitor(ObligationMonitor):
    """`always[a:b]`, and `until` with an infinite window: failed when the condition is first false."""

    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        if self._is_due(now_ns, arrived, outputs):
            self._judge_due(now_ns, arrived, outputs)
        self.active = bool(self._due or self._waiting)

    def _judge_due(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs) -> None:
        release = self.program.release
        if release is not None and release(self._state.values, arrived, outputs):
            self._pass_all(now_ns)
            return
        holds = self._condition(self._state.values, arrived, outputs)
        margin = self._margin(arrived, outputs)
        # The least margin of all windows: each instant at which any is open is judged once for all of them.
        self._verdict.add_margin(margin, now_ns)
        if not holds:
            self._fail_all(now_ns, margin, outputs)
            return
        if self._verdict.unused:
            self._note_alternative(arrived, outputs)
        while self._due and self._due[0] + self._end_ns <= now_ns:
            self._close(now_ns, passed=True)

    def _pass_all(self, now_ns: Nanoseconds) -> None:
        while self._due:
            self._close(now_ns, passed=True)

    def _fail_all(self, now_ns: Nanoseconds, margin: float, outputs: Outputs) -> None:
        values = self._current_values(outputs)
        while self._due:
            self._verdict.add_violation(self._close(now_ns, passed=False), now_ns, values, margin)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        # The response held so far and cannot be broken any more. A trigger whose window has not begun was not tested.
        self._pass_all(now_ns)
        return super().finish(requirement, now_ns)
