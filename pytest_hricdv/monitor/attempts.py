"""The base of all monitors of one requirement: evaluation at an instant, and the count of attempts."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence, Set

from pytest_hricdv.monitor.compiler import Program
from pytest_hricdv.monitor.evaluation_state import (
    NO_MESSAGE,
    EvaluationState,
    Nanoseconds,
    Outputs,
    UnknownValueError,
    seconds,
)
from pytest_hricdv.monitor.verdict import Attempt, Outcome, Verdict, Violation


class Tally:
    """Counts the attempts of one requirement during a run."""

    def __init__(self) -> None:
        self.attempts = 0
        self.passes = 0
        self.failures = 0
        self.margin = math.inf
        self._margin_ns: Nanoseconds = 0
        self._violations: list[Violation] = []
        self._history: list[Attempt] = []

    def add_margin(self, margin: float, now_ns: Nanoseconds) -> None:
        """Keep a margin if it is the least one so far."""
        if margin < self.margin:
            self.margin = margin
            self._margin_ns = now_ns

    def add_violation(
        self, trigger_ns: Nanoseconds, time_ns: Nanoseconds, values: Mapping[str, float | bool], margin: float
    ) -> None:
        """Record one violation. (`failures` counts attempts; one attempt may have several violations.)"""
        self._violations.append(Violation(seconds(trigger_ns), seconds(time_ns), values, _finite_or_none(margin)))

    def decide(self, begin_ns: Nanoseconds, end_ns: Nanoseconds, *, passed: bool) -> None:
        """Count an attempt that was discharged or failed."""
        if passed:
            self.passes += 1
        else:
            self.failures += 1
        self._history.append(Attempt(seconds(begin_ns), seconds(end_ns), "passed" if passed else "failed"))

    def add_pending(self, begin_ns: Nanoseconds, end_ns: Nanoseconds) -> None:
        """Record an attempt that is undecided at the end of the run."""
        self._history.append(Attempt(seconds(begin_ns), seconds(end_ns), "pending"))

    @property
    def outcome(self) -> Outcome:
        """The verdict by the attempts that are decided."""
        return "Failed" if self.failures else "Passed" if self.passes else "NC"

    def verdict(self, requirement: str, pending: int) -> Verdict:
        """The verdict, with `pending` attempts undecided."""
        margin = _finite_or_none(self.margin)
        return Verdict(
            requirement=requirement,
            verdict=self.outcome,
            attempts=self.attempts,
            passes=self.passes,
            failures=self.failures,
            vacuous=int(self.attempts == 0),
            pending=pending,
            violations=tuple(self._violations),
            margin=margin,
            margin_time_s=None if margin is None else seconds(self._margin_ns),
            history=tuple(sorted(self._history, key=lambda attempt: attempt.begin_s)),
        )


def _finite_or_none(margin: float) -> float | None:
    # A negated comparison may have the margin -0.0 at its bound; adding 0.0 makes it 0.0.
    return margin + 0.0 if math.isfinite(margin) else None


class RequirementMonitor(ABC):
    """Monitors one requirement during one run; each kind of response has a subclass.

    Attributes:
        program: the compiled formula.
        shows: signals that only violations report.
        kinds: signals and fields whose values are needed -> type.
        active: an attempt is open, so updates of `attempt_sources` require an evaluation.
        wake_ns: the next time at which an evaluation is needed without an update.
    """

    def __init__(self, program: Program, state: EvaluationState, shows: Sequence[str]) -> None:
        self.program = program
        self.shows = frozenset(shows) - program.kinds.keys()
        self.kinds = {**dict.fromkeys(shows, float), **program.kinds}
        self.active = False
        self.wake_ns: Nanoseconds = math.inf
        self._state = state
        self._run_operators = [make() for make in program.run_operators]
        self._attempt_operators = [make() for make in program.attempt_operators]
        self._antecedent = program.antecedent
        self._condition = program.condition
        self._robustness = program.robustness
        self._tally = Tally()

    def evaluate(self, now_ns: Nanoseconds, *, last: bool, first: bool = False) -> None:
        """Judge the instant `now_ns`, after all its updates, and the time right after it unless it is the `last`.

        `first`: the run starts at this instant, and nothing that this requirement reads was updated at it. Past
        operators start here all the same, and so does an attempt if the antecedent is known and true.
        """
        state = self._state
        for operator in self._run_operators:
            operator.step(now_ns, state)
        if not first or self._is_antecedent_known():
            self._judge(now_ns, state.arrived, state.at, right_after=False)
            if not last and not self.program.right_continuous:
                self._judge(now_ns, NO_MESSAGE, state.after, right_after=True)
        self.wake_ns = self._response_wake_ns(now_ns)
        for operator in self._run_operators:
            if operator.wake_ns < self.wake_ns:
                self.wake_ns = operator.wake_ns

    def _is_antecedent_known(self) -> bool:
        try:
            self._antecedent(self._state.values, self._state.arrived, self._state.at)
        except UnknownValueError:
            return False
        return True

    @abstractmethod
    def _judge(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs, *, right_after: bool) -> None:
        """Judge one instant, or the time right after it."""

    def _response_wake_ns(self, now_ns: Nanoseconds) -> Nanoseconds:
        """The next time at which an open attempt has to be judged without an update."""
        return math.inf

    def deadline_ns(self) -> Nanoseconds | None:
        """The latest deadline of an open `eventually` attempt."""
        return None

    def outcome_so_far(self) -> Outcome:
        """The verdict if all open attempts remained undecided."""
        return self._tally.outcome

    @abstractmethod
    def finish(self, requirement: str, now_ns: Nanoseconds) -> Verdict:
        """The verdict at the end of the run, after its last instant was judged."""

    def _margin(self, arrived: Set[str], outputs: Outputs) -> float:
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

    def _current_values(self) -> dict[str, float | bool]:
        values = self._state.values
        return {name: values[name] for name in self.kinds if name in values}
