"""One requirement watched during one run: when attempts begin, and how each kind of response decides them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence, Set
from dataclasses import dataclass

from pytest_hricdv.monitor.errors import UnknownValueError
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Holds
from pytest_hricdv.monitor.program import Program, compile_formula
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Outcome, Tally, Verdict
from pytest_hricdv.monitor.view import NO_MESSAGE, NS_PER_S, Nanoseconds, Outputs, Values, View, nanoseconds


class AttemptMonitor(ABC):
    """Watches one requirement.

    Attributes:
        kinds: signals and fields whose values are wanted -> type.
        active: an attempt is open, so that updates which only its response reads have to be looked at.
        wake_ns: the next time at which it has to be evaluated even if nothing is updated.
    """

    def __init__(self, program: Program, view: View, shows: Sequence[str]) -> None:
        self.program = program
        self.shows = frozenset(shows) - program.kinds.keys()
        self.kinds = {**dict.fromkeys(shows, float), **program.kinds}
        self.active = False
        self.wake_ns: Nanoseconds = math.inf
        self._view = view
        self._operators = [make() for make in program.operators]
        self._latches = [make() for make in program.latches]
        self._antecedent = program.antecedent
        self._condition = program.condition
        self._robustness = program.robustness
        self._tally = Tally()

    def evaluate(self, now_ns: Nanoseconds, *, last: bool, first: bool = False) -> None:
        """Judge the instant `now_ns`, after all its updates; unless it is the `last`, also the time right after it.

        `first` says that the run starts at this instant and nothing that is read here was updated at it. History begins
        all the same, and so does an attempt if the antecedent is known and holds.
        """
        view = self._view
        for operator in self._operators:
            operator.step(now_ns, view)
        if not first or self._is_antecedent_known():
            self._judge(now_ns, view.arrived, view.at, right_after=False)
            if not last and not self.program.lasting:
                self._judge(now_ns, NO_MESSAGE, view.after, right_after=True)
        self.wake_ns = self._obligation_wake_ns(now_ns)
        for operator in self._operators:
            if operator.wake_ns < self.wake_ns:
                self.wake_ns = operator.wake_ns

    def _is_antecedent_known(self) -> bool:
        try:
            self._antecedent(self._view.values, self._view.arrived, self._view.at)
        except UnknownValueError:
            return False
        return True

    @abstractmethod
    def _judge(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs, *, right_after: bool) -> None:
        """Judge one instant, or the time right after it."""

    def _obligation_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        """The next time at which an open attempt has to be judged, whatever is updated."""
        return math.inf

    def deadline_ns(self) -> Nanoseconds | None:
        """The latest deadline of an open liveness attempt."""
        return None

    def so_far(self) -> Outcome:
        """What the verdict would be if every open attempt stayed undecided."""
        return self._tally.verdict("", pending=0).verdict

    @abstractmethod
    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        """The verdict at the end of the run, after its last instant was judged."""

    def _margin(self, arrived: Set[str], outputs: Outputs) -> float:
        """The distance to the bound; infinite if there is none, or if it is unknown or undefined.

        That is no error: it takes all parts of the condition, also those that were not needed to decide it.
        """
        if self._robustness is None:
            return math.inf
        try:
            return self._robustness(self._view.values, arrived, outputs)
        except (UnknownValueError, ArithmeticError):
            return math.inf

    def _snapshot(self) -> dict[str, float | bool]:
        values = self._view.values
        return {name: values[name] for name in self.kinds if name in values}


class EpisodeMonitor(AttemptMonitor):
    """A state response: an attempt is a time over which the antecedent holds without a break."""

    def __init__(self, program: Program, view: View, shows: Sequence[str]) -> None:
        super().__init__(program, view, shows)
        self._trigger_ns: Nanoseconds = 0
        self._failed = False
        self._breach: _Breach | None = None

    def _judge(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs, *, right_after: bool) -> None:
        view = self._view
        if not self._antecedent(view.values, arrived, outputs):
            if self.active:
                self._end(now_ns)
            return
        if not self.active:
            self._begin(now_ns)
        for latch in self._latches:
            latch.step(now_ns, view)
        holds = self._condition(view.values, arrived, outputs)
        margin = self._margin(arrived, outputs)
        if margin < self._tally.margin:
            self._tally.observe(margin, now_ns)
        if not holds:
            if self._breach is None:
                self._breach = _Breach(now_ns, self._snapshot(), margin)
            self._breach.margin = min(self._breach.margin, margin)
            for name in self._breach.values.keys() & self.shows:
                self._breach.values[name] = max(self._breach.values[name], view.values[name], key=abs)
        elif self._breach is not None:
            self._end_breach()

    def _begin(self, now_ns: Nanoseconds) -> None:
        self.active = True
        self._trigger_ns = now_ns
        self._failed = False
        self._tally.attempts += 1
        for latch in self._latches:
            latch.reset()

    def _end_breach(self) -> None:
        breach = self._breach
        if breach is not None:
            self._failed = True
            self._tally.violate(self._trigger_ns, breach.time_ns, breach.values, breach.margin)
            self._breach = None

    def _end(self, now_ns: Nanoseconds) -> None:
        self.active = False
        self._end_breach()
        self._tally.decide(self._trigger_ns, now_ns, passed=not self._failed)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        if self.active:
            self._end(now_ns)
        return self._tally.verdict(requirement, pending=0)


@dataclass(slots=True)
class _Breach:
    """A violation that lasts."""

    time_ns: Nanoseconds
    values: dict[str, float | bool]
    margin: float


@dataclass(slots=True)
class _Obligation:
    """An open attempt: what is owed from `opens_ns` to `closes_ns`, both included."""

    trigger_ns: Nanoseconds
    opens_ns: Nanoseconds
    closes_ns: Nanoseconds


class ObligationMonitor(AttemptMonitor):
    """A response over a time after the trigger: an attempt begins whenever the antecedent turns true."""

    def __init__(self, program: Program, view: View, shows: Sequence[str], start_s: float, end_s: float) -> None:
        super().__init__(program, view, shows)
        self._start_ns = nanoseconds(start_s)
        self._end_ns = nanoseconds(end_s)
        self._triggered = False
        self._open: list[_Obligation] = []

    def _judge(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs, *, right_after: bool) -> None:
        holds = self._antecedent(self._view.values, arrived, outputs)
        if holds and not self._triggered:
            self._tally.attempts += 1
            self._open.append(_Obligation(now_ns, now_ns + self._start_ns, now_ns + self._end_ns))
        self._triggered = holds
        if self._open:
            self._discharge(now_ns, arrived, outputs, right_after)
        self.active = bool(self._open)

    def _discharge(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs, right_after: bool) -> None:
        """Decide the open attempts as far as they can be."""
        due = [owed for owed in self._open if owed.opens_ns <= now_ns]
        # Right after the last instant of a window the window is over, and nothing that comes then counts.
        if right_after:
            due = [owed for owed in due if now_ns < owed.closes_ns]
        if due:
            self._judge_due(due, now_ns, arrived, outputs)

    @abstractmethod
    def _judge_due(self, due: list[_Obligation], now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs) -> None:
        """Decide attempts, and close those that are decided, now that their windows are open."""

    def _close(self, owed: _Obligation, now_ns: Nanoseconds, *, passed: bool) -> None:
        self._open.remove(owed)
        self._tally.decide(owed.trigger_ns, now_ns, passed=passed)

    def _obligation_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        times = (time for owed in self._open for time in (owed.opens_ns, owed.closes_ns) if time > now_ns)
        return min(times, default=math.inf)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        for owed in self._open:
            self._tally.leave(owed.trigger_ns, now_ns)
        return self._tally.verdict(requirement, pending=len(self._open))


class EventuallyMonitor(ObligationMonitor):
    """Liveness: discharged when the condition first holds in the window, failed at the deadline."""

    def _judge_due(self, due: list[_Obligation], now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs) -> None:
        if self._condition(self._view.values, arrived, outputs):
            for owed in due:
                self._tally.observe((owed.closes_ns - now_ns) / NS_PER_S, now_ns)
                self._close(owed, now_ns, passed=True)
            return
        for owed in due:
            if now_ns >= owed.closes_ns:
                self._tally.observe(0.0, now_ns)
                self._tally.violate(owed.trigger_ns, now_ns, self._snapshot(), 0.0)
                self._close(owed, now_ns, passed=False)

    def deadline_ns(self) -> Nanoseconds | None:
        return max((owed.closes_ns for owed in self._open), default=None)


class SafetyMonitor(ObligationMonitor):
    """`always[a:b]`, and `until` with a window without end: failed at the first instant without the condition."""

    def _judge_due(self, due: list[_Obligation], now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs) -> None:
        release = self.program.release
        if release is not None and release(self._view.values, arrived, outputs):
            for owed in due:
                self._close(owed, now_ns, passed=True)
            return
        holds = self._condition(self._view.values, arrived, outputs)
        margin = self._margin(arrived, outputs)
        self._tally.observe(margin, now_ns)
        for owed in due:
            if not holds:
                self._tally.violate(owed.trigger_ns, now_ns, self._snapshot(), margin)
                self._close(owed, now_ns, passed=False)
            elif now_ns >= owed.closes_ns:
                self._close(owed, now_ns, passed=True)

    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        for owed in [owed for owed in self._open if owed.opens_ns <= now_ns]:
            self._close(owed, now_ns, passed=True)
        return super().finish(requirement, now_ns)


def monitor_of(requirement: Requirement, values: Values, arrived: Set[str]) -> AttemptMonitor:
    """A fresh monitor of a requirement; `values` and `arrived` are shared by the monitors of a run."""
    program, shows = compile_formula(requirement.formula), requirement.shows
    view = View(values, arrived)
    match requirement.formula.response:
        case Holds():
            return EpisodeMonitor(program, view, shows)
        case Eventually() as window:
            return EventuallyMonitor(program, view, shows, window.start_s, window.end_s)
        case AlwaysWithin() as window:
            return SafetyMonitor(program, view, shows, window.start_s, window.end_s)
        case _:
            return SafetyMonitor(program, view, shows, 0.0, math.inf)
