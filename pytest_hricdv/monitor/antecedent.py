"""How near an antecedent came to a trigger in a logged run (`near_miss`), and which conjuncts were true and false.

`explain` calls `near_miss` for requirements that were never triggered; the closing loop calls `conjunct_outcomes`.
Both replay the log after the run, so that monitors stay fast.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, cast

from pytest_hricdv.monitor.analysis import conjuncts, fields_read, names_of, topics_of
from pytest_hricdv.monitor.compiler import ExpressionCompiler, function_of
from pytest_hricdv.monitor.evaluation_state import (
    NO_MESSAGE,
    Condition,
    EvaluationState,
    Measure,
    Nanoseconds,
    Outputs,
    UnknownValueError,
    Value,
    Values,
    seconds,
)
from pytest_hricdv.monitor.log import Log, Update
from pytest_hricdv.monitor.node import HysteresisScope, PastFormula, last_of
from pytest_hricdv.monitor.past_formula import Conjunction, Disjunction, Negation, NumberComparison
from pytest_hricdv.monitor.terms import ArithmeticOperator, ArithmeticTerm, NumberTerm
from pytest_hricdv.monitor.verdict import NearMiss

# A conjunct is evaluated alone, without the conjuncts that guard it in the antecedent: it may be undefined.
_UNDEFINED = (UnknownValueError, ArithmeticError)


def near_miss(antecedent: PastFormula, log: Log) -> NearMiss:
    """The instant at which an antecedent that was never true in a run was closest to being true.

    The search minimizes, in this order: the number of false conjuncts; if a single comparison is false, its distance
    to its bound; the time.
    """
    search = NearMissSearch(antecedent)
    for now_ns, updates in log.instants(search.signals, search.topics):
        search.add(now_ns, updates, last=now_ns == log.end_ns)
    return search.nearest()


class NearMissSearch:
    """The search of `near_miss`, instant by instant.

    Attributes:
        signals: the signals that have to be in the updates.
        topics: likewise.
    """

    def __init__(self, antecedent: PastFormula) -> None:
        self._replay = _Replay(antecedent)
        self.signals, self.topics = self._replay.signals, self._replay.topics
        self._best, self._missing = (math.inf, math.inf), list[_Conjunct]()
        self._time_ns: Nanoseconds = 0

    def add(self, now_ns: Nanoseconds, updates: Iterable[Update], *, last: bool) -> None:
        """Add the next instant; whether it is the last one of the run."""
        for moment in self._replay.step(now_ns, updates, last=last):
            false = [conjunct for conjunct in self._replay.conjuncts if not conjunct.holds(moment)]
            if len(false) <= self._best[0]:
                candidate = (len(false), false[0].distance(moment) if len(false) == 1 else math.inf)
                if candidate < self._best:
                    self._best, self._missing, self._time_ns = candidate, false, moment.now_ns

    @property
    def is_met(self) -> bool:
        """Whether the antecedent was true, so that there is no near miss."""
        return self._best[0] == 0

    def nearest(self) -> NearMiss:
        """The near miss among all instants up to now."""
        return NearMiss(
            time_s=seconds(self._time_ns),
            missing=tuple(conjunct.text for conjunct in self._missing),
            # At the bound a distance may be -0.0; adding 0.0 makes it 0.0.
            distance=self._best[1] + 0.0 if math.isfinite(self._best[1]) else None,
        )


def conjunct_outcomes(antecedent: PastFormula, log: Log) -> dict[str, frozenset[bool]]:
    """The text of each conjunct -> what it was in a run: true, false, both, or neither as long as it has no value."""
    replay = _Replay(antecedent)
    outcomes_of = {conjunct.text: set[bool]() for conjunct in replay.conjuncts}
    waiting = [*replay.conjuncts]
    for moment in replay.moments(log):
        for conjunct in waiting:
            outcome = conjunct.holds(moment)
            if outcome is not None:
                outcomes_of[conjunct.text].add(outcome)
        waiting = [conjunct for conjunct in waiting if len(outcomes_of[conjunct.text]) < 2]
        if not waiting:
            break
    return {text: frozenset(outcomes) for text, outcomes in outcomes_of.items()}


class _Moment(NamedTuple):
    """A moment of a replayed log: an instant, or right after it."""

    now_ns: Nanoseconds
    values: Values
    arrived: Mapping[str, int]
    outputs: Outputs


@dataclass(frozen=True)
class _Conjunct:
    text: str
    condition: Condition
    robustness: Measure | None  # with respect to the bound at which it would become true

    def holds(self, moment: _Moment) -> bool | None:
        """Whether it is true; None if it has no value."""
        try:
            return bool(self.condition(moment.values, moment.arrived, moment.outputs))
        except _UNDEFINED:
            return None

    def distance(self, moment: _Moment) -> float:
        """How far it is from being true; infinite if this is not known."""
        if self.robustness is None:
            return math.inf
        try:
            return -self.robustness(moment.values, moment.arrived, moment.outputs)
        except _UNDEFINED:
            return math.inf


class _Replay:
    """Replays logs for the conjuncts of an antecedent."""

    def __init__(self, antecedent: PastFormula) -> None:
        self._kinds = names_of([antecedent])
        self.topics = topics_of([antecedent])
        self.signals = [name for name in self._kinds if "." not in name]
        compiler = ExpressionCompiler()
        self.conjuncts = [_compile(part, compiler) for part in conjuncts(antecedent)]
        self._operators = [make() for make in compiler.run_operators]
        self._fields = {topic: fields_read(self._kinds, topic) for topic in self.topics}
        self._arrived: dict[str, int] = {}
        self._state = EvaluationState(Values(), self._arrived)
        self._due_ns = math.inf

    def moments(self, log: Log) -> Iterator[_Moment]:
        """Each instant at which something may change, and the time right after it. What is yielded is valid until the
        next one."""
        for now_ns, updates in log.instants(self.signals, self.topics):
            yield from self.step(now_ns, updates, last=now_ns == log.end_ns)

    def step(self, now_ns: Nanoseconds, updates: Iterable[Update], *, last: bool) -> Iterator[_Moment]:
        """Step to the next instant."""
        # Windows end and times pass between the updates, too.
        while self._due_ns < now_ns:
            yield from self._at(self._due_ns, last=False)
            self._due_ns = self._wake_ns()
        self._update(updates)
        yield from self._at(now_ns, last=last)
        self._due_ns = self._wake_ns()

    def _update(self, updates: Iterable[Update]) -> None:
        """Apply the updates of an instant."""
        for name, value in updates:
            if isinstance(value, Mapping):
                self._arrived[name] = self._arrived.get(name, 0) + 1
                for field, keep_last in self._fields[name].items():
                    kind = self._kinds.get(field) or self._kinds[last_of(field)]
                    new = cast("Value", value[field.partition(".")[2]])
                    self._state.values.set_field(field, kind(new), keep_last=keep_last)
            else:
                self._state.values[name] = self._kinds[name](value)

    def _at(self, now_ns: Nanoseconds, *, last: bool) -> Iterator[_Moment]:
        """An instant and, unless it is the last, the time right after it."""
        for operator in self._operators:
            operator.step(now_ns, self._state)
        yield _Moment(now_ns, self._state.values, self._state.arrived, self._state.at)
        if not last:
            yield _Moment(now_ns, self._state.values, NO_MESSAGE, self._state.after)
        self._arrived.clear()

    def _wake_ns(self) -> float:
        return min((operator.wake_ns for operator in self._operators), default=math.inf)


def _compile(conjunct: PastFormula, compiler: ExpressionCompiler) -> _Conjunct:
    condition = function_of(conjunct.expression(compiler, HysteresisScope.RUN))
    robustness = _with_shifted_bounds(conjunct, wanted=True).robustness(compiler)
    return _Conjunct(str(conjunct), condition, None if robustness is None else function_of(robustness))


def _with_shifted_bounds(formula: PastFormula, *, wanted: bool) -> PastFormula:
    """`formula` with the bounds at which it becomes `wanted`: a comparison becomes true only past its hysteresis."""
    match formula:
        case NumberComparison(for_s=0):
            width = NumberTerm(formula.hysteresis if wanted else 0.0)
            sign: ArithmeticOperator = "-" if formula.relation in ("<", "<=") else "+"
            bound = ArithmeticTerm(sign, formula.right, width) if width.value else formula.right
            return NumberComparison(formula.relation, formula.left, bound)
        case Negation():
            return Negation(_with_shifted_bounds(formula.operand, wanted=not wanted))
        case Conjunction() | Disjunction():
            return formula.with_operands(lambda operand: _with_shifted_bounds(operand, wanted=wanted))
        case _:
            return formula
