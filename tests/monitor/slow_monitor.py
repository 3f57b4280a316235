"""Monitors that keep one object for each open trigger and go through all of them at every event: the slow oracle.

They have the same interface as the monitors of the plugin, so that a whole verdict can be compared, and what is said
while the run goes on: wake-ups, deadlines, calls of a watched condition.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from pytest_hricdv.monitor import MonitorSet, Requirement, Verdict
from pytest_hricdv.monitor.evaluation_state import (
    NS_PER_S,
    Condition,
    EvaluationState,
    Nanoseconds,
    Outputs,
    nanoseconds,
)
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil
from pytest_hricdv.monitor.operators import OnceOperator, Operator, PastOperator
from pytest_hricdv.monitor.program import RequirementProgram, compile_formula
from pytest_hricdv.monitor.requirement_monitor import EpisodeMonitor, RequirementMonitor


class SlowMonitorSet(MonitorSet):
    """A `MonitorSet` whose monitors of requirements are slow."""

    def __init__(self, requirements: Iterable[Requirement]) -> None:
        super().__init__()
        for requirement in requirements:
            monitor = _monitor_of(requirement, EvaluationState(self._values, self._arrived))
            self._requirements[monitor] = requirement.id
            self._add(monitor, requirement.id)


def _monitor_of(requirement: Requirement, state: EvaluationState) -> RequirementMonitor:
    program = _slow(requirement.formula)
    if isinstance(requirement.formula.response, Holds):
        return EpisodeMonitor(program, state, requirement.shows)
    return SlowMonitor(program, state, requirement.shows, requirement.formula)


def _slow(formula: Formula) -> RequirementProgram:
    """The program of a formula, with the slow operator for `once` and `historically`."""
    program = compile_formula(formula)
    return replace(program, run_operators=tuple(map(_slow_operator, program.run_operators)))


def _slow_operator(make: Callable[[], Operator]) -> Callable[[], Operator]:
    assert isinstance(make, partial)
    return partial(SlowOnce, *make.args, **make.keywords) if make.func is OnceOperator else make


@dataclass(slots=True)
class _Obligation:
    """An open trigger: the response is due from `start_ns` to `end_ns`, both included."""

    trigger_ns: Nanoseconds
    start_ns: Nanoseconds
    end_ns: Nanoseconds


class SlowMonitor(RequirementMonitor):
    """`eventually[a:b]`, `always[a:b]` and `until`, each trigger for itself."""

    def __init__(
        self, program: RequirementProgram, state: EvaluationState, shows: Sequence[str], formula: Formula
    ) -> None:
        super().__init__(program, state, shows)
        response = formula.response
        self._is_eventually = isinstance(response, Eventually)
        window = (0.0, math.inf) if isinstance(response, HoldsUntil) else (response.start_s, response.end_s)  # type: ignore[union-attr]
        assert isinstance(response, Eventually | AlwaysWithin | HoldsUntil)
        self._start_ns, self._end_ns = map(nanoseconds, window)
        self._triggered = False
        self._open: list[_Obligation] = []
        self._missed: list[tuple[int, Nanoseconds]] = []

    def _judge(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs, *, right_after: bool) -> None:
        holds = self._antecedent(self._state.values, arrived, outputs)
        if holds and not self._triggered:
            self._verdict.triggers += 1
            self._open.append(_Obligation(now_ns, now_ns + self._start_ns, now_ns + self._end_ns))
        self._triggered = holds
        due = [obligation for obligation in self._open if obligation.start_ns <= now_ns]
        if right_after:
            due = [obligation for obligation in due if now_ns < obligation.end_ns]
        if due:
            judge = self._judge_eventually if self._is_eventually else self._judge_safety
            judge(due, now_ns, arrived, outputs)
        if self._missed and self._condition(self._state.values, arrived, outputs):
            self._settle(now_ns)
        self.active = bool(self._open or self._missed)

    def _judge_eventually(
        self, due: list[_Obligation], now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs
    ) -> None:
        holds = self._condition(self._state.values, arrived, outputs)
        if holds and self._verdict.unused:
            self._note_alternative(arrived, outputs)
        for obligation in due:
            if holds:
                self._verdict.add_margin((obligation.end_ns - now_ns) / NS_PER_S, now_ns)
                self._close(obligation, now_ns, passed=True)
            elif now_ns >= obligation.end_ns:
                self._missed.append((self._verdict.violations, obligation.end_ns))
                self._verdict.add_violation(obligation.trigger_ns, now_ns, self._current_values(outputs), 0.0)
                self._close(obligation, now_ns, passed=False)

    def _judge_safety(
        self, due: list[_Obligation], now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs
    ) -> None:
        release = self.program.release
        if release is not None and release(self._state.values, arrived, outputs):
            for obligation in due:
                self._close(obligation, now_ns, passed=True)
            return
        holds = self._condition(self._state.values, arrived, outputs)
        if holds and self._verdict.unused:
            self._note_alternative(arrived, outputs)
        for obligation in due:
            margin = self._margin(arrived, outputs)
            self._verdict.add_margin(margin, now_ns)
            if not holds:
                self._verdict.add_violation(obligation.trigger_ns, now_ns, self._current_values(outputs), margin)
                self._close(obligation, now_ns, passed=False)
            elif now_ns >= obligation.end_ns:
                self._close(obligation, now_ns, passed=True)

    def _close(self, obligation: _Obligation, now_ns: Nanoseconds, *, passed: bool) -> None:
        self._open.remove(obligation)
        self._verdict.decide(obligation.trigger_ns, now_ns, passed=passed)

    def _settle(self, now_ns: Nanoseconds) -> None:
        for number, deadline_ns in self._missed:
            self._verdict.came_late(number, now_ns - deadline_ns, now_ns)
        self._missed.clear()

    def _response_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        times = (time for trigger in self._open for time in (trigger.start_ns, trigger.end_ns) if time > now_ns)
        return min(times, default=math.inf)

    def deadline_ns(self) -> Nanoseconds | None:
        return max((trigger.end_ns for trigger in self._open), default=None) if self._is_eventually else None

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        self._settle(now_ns)
        if not self._is_eventually:
            for obligation in [obligation for obligation in self._open if obligation.start_ns <= now_ns]:
                self._close(obligation, now_ns, passed=True)
        for obligation in self._open:
            self._verdict.add_pending(obligation.trigger_ns, now_ns)
        return self._verdict.verdict(requirement, pending=len(self._open))


@dataclass(slots=True)
class _Span:
    """A time in which the operand was true; an end is open or belongs to it."""

    start_ns: Nanoseconds
    start_open: bool
    end_ns: Nanoseconds = math.inf
    end_open: bool = True


class SlowOnce(PastOperator):
    """`once[a:b]` by its definition: keeps all spans in which the operand was true, and looks at all of them."""

    def __init__(self, index: int, operand: Condition, start_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        super().__init__(index, operand)
        self._start_ns, self._end_ns = start_ns, end_ns
        self._spans: list[_Span] = []
        self._holds = False

    def _start(self, now_ns: Nanoseconds, before: list[bool]) -> bool:
        return False

    def _advance(self, now_ns: Nanoseconds, at: list[bool], after: list[bool]) -> tuple[bool, bool]:
        for holds, right_after in ((at[0], False), (after[0], True)):
            if holds and not self._holds:
                self._spans.append(_Span(now_ns, right_after))
            elif self._holds and not holds:
                self._spans[-1].end_ns, self._spans[-1].end_open = now_ns, not right_after
            self._holds = holds
        shifted = [
            _Span(span.start_ns + self._start_ns, span.start_open, span.end_ns + self._end_ns, span.end_open)
            for span in self._spans
        ]
        ends = (time for span in shifted for time in (span.start_ns, span.end_ns) if time > now_ns)
        self.wake_ns = min(ends, default=math.inf)
        holds_at = any(_is_in(span, now_ns) for span in shifted)
        return holds_at, any(span.start_ns <= now_ns < span.end_ns for span in shifted)


def _is_in(span: _Span, now_ns: Nanoseconds) -> bool:
    starts = span.start_ns < now_ns if span.start_open else span.start_ns <= now_ns
    return starts and (now_ns < span.end_ns if span.end_open else now_ns <= span.end_ns)
