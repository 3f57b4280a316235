"""Logged runs: verdicts on them, and the nearest miss of a requirement that was not triggered.

The nearest miss is when its antecedent was nearest to being true. It is searched for in the log after the run, and only
for requirements that were never triggered, so that monitors stay fast.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from numbers import Real
from operator import itemgetter
from typing import Protocol, cast

from pytest_hricdv.monitor.analysis import conjuncts, fields_read, names_of, names_read, topics_of, topics_read
from pytest_hricdv.monitor.compiler import ExpressionCompiler, HysteresisScope, function_of
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
    nanoseconds,
    seconds,
)
from pytest_hricdv.monitor.formula import And, Arithmetic, ArithmeticOperator, Comparison, Not, Number, Or, PastFormula
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import NearestMiss, Verdict
from pytest_hricdv.monitor.vocabulary import Kind, last_of

Series = tuple[Sequence[float], Sequence[float] | Sequence[str]]
Update = tuple[str, "Value | Mapping[str, object]"]

# A conjunct is evaluated by itself, so without the conjuncts that guard it in the antecedent.
_UNDEFINED = (UnknownValueError, ArithmeticError)


class Message(Protocol):
    """One message of a log."""

    @property
    def time_s(self) -> float: ...

    @property
    def topic(self) -> str: ...

    @property
    def fields(self) -> Mapping[str, object]: ...


@dataclass(frozen=True)
class Log:
    """A logged run; of a recorded run: `Log({**record.signals, **record.texts}, record.messages, end_s)`.

    Attributes:
        signals: name -> times (s, not decreasing), and the value from each time on; a bool may be written 0.0 or 1.0.
        messages: in the order of time.
        end_s: when the run ended (s).
    """

    signals: Mapping[str, Series]
    messages: Sequence[Message]
    end_s: float

    @property
    def start_s(self) -> float:
        """When the run began: the time of its first update (s)."""
        firsts = [times[0] for times, _ in self.signals.values() if len(times)]
        firsts += [message.time_s for message in self.messages[:1]]
        return min(firsts, default=self.end_s)

    @property
    def end_ns(self) -> Nanoseconds:
        """When the run ended (ns)."""
        return nanoseconds(self.end_s)

    def instants(self, names: Iterable[str], topics: Iterable[str]) -> Iterator[tuple[Nanoseconds, list[Update]]]:
        """The instants in the order of time, with their updates: (signal, value) or (topic, fields of the message).

        The first and the last instant of the run are always included, with or without an update.
        """
        wanted = frozenset(topics)
        streams: list[Iterable[tuple[Nanoseconds, Update]]] = [
            [(nanoseconds(self.start_s), ("", {})), (self.end_ns, ("", {}))],
            ((nanoseconds(each.time_s), (each.topic, each.fields)) for each in self.messages if each.topic in wanted),
        ]
        for name in names:
            times, values = self.signals.get(name, ((), ()))
            streams.append(_updates(name, times, values))
        merged = heapq.merge(*streams, key=itemgetter(0))
        for now_ns, group in groupby(merged, key=itemgetter(0)):
            yield now_ns, [update for _, update in group if update[0]]


def _updates(name: str, times: Sequence[float], values: Sequence[Value]) -> Iterator[tuple[Nanoseconds, Update]]:
    for time_s, value in zip(times, values, strict=True):
        yield nanoseconds(time_s), (name, value)


def explained(verdicts: Iterable[Verdict], requirements: Iterable[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts; those of requirements that were never triggered have their nearest miss.

    Args:
        verdicts: on the logged run.
        requirements: of the verdicts, in the same order.
        log: the run.
    """
    return tuple(
        replace(verdict, nearest_miss=nearest_miss(requirement.formula.antecedent, log)) if verdict.vacuous else verdict
        for verdict, requirement in zip(verdicts, requirements, strict=True)
    )


def nearest_miss(antecedent: PastFormula, log: Log) -> NearestMiss:
    """When an antecedent that was never true in a run was nearest to it.

    The search minimizes, in this order: the number of false conjuncts; if a single comparison is false, its distance
    to its bound; the time.
    """
    search = _Search(antecedent)
    wake_ns = math.inf
    for now_ns, updates in log.instants(search.signals, search.topics):
        while wake_ns < now_ns:
            wake_ns = search.evaluate(wake_ns, last=False)
        search.update(updates)
        wake_ns = search.evaluate(now_ns, last=now_ns == log.end_ns)
    return search.result()


@dataclass(frozen=True)
class _Conjunct:
    text: str
    condition: Condition
    robustness: Measure | None  # with respect to the bound at which it would become true

    def is_true(self, values: Values, arrived: Mapping[str, int], outputs: Outputs) -> bool:
        try:
            return self.condition(values, arrived, outputs)
        except _UNDEFINED:
            return False

    def distance(self, values: Values, arrived: Mapping[str, int], outputs: Outputs) -> float:
        if self.robustness is None:
            return math.inf
        try:
            return -self.robustness(values, arrived, outputs)
        except _UNDEFINED:
            return math.inf


class _Search:
    """Replays a log and keeps the nearest miss so far."""

    def __init__(self, antecedent: PastFormula) -> None:
        self._kinds = names_of([antecedent])
        self.signals = [name for name in self._kinds if "." not in name]
        self.topics = topics_of([antecedent])
        compiler = ExpressionCompiler()
        self._conjuncts = [_compiled(part, compiler) for part in conjuncts(antecedent)]
        self._operators = [make() for make in compiler.run_operators]
        self._fields = {topic: fields_read(self._kinds, topic) for topic in self.topics}
        self._arrived: dict[str, int] = {}
        self._state = EvaluationState(Values(), self._arrived)
        self._best: tuple[float, float] = (math.inf, math.inf)  # number of false conjuncts, distance of a single one
        self._missing: list[_Conjunct] = []
        self._time_ns: Nanoseconds = 0

    def update(self, updates: Iterable[Update]) -> None:
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

    def evaluate(self, now_ns: Nanoseconds, *, last: bool) -> Nanoseconds:
        """Evaluate an instant and, unless it is the last, the time right after it; returns the next wake-up time."""
        for operator in self._operators:
            operator.step(now_ns, self._state)
        self._compare(now_ns, self._state.arrived, self._state.at)
        if not last:
            self._compare(now_ns, NO_MESSAGE, self._state.after)
        self._arrived.clear()
        return min((operator.wake_ns for operator in self._operators), default=math.inf)

    def _compare(self, now_ns: Nanoseconds, arrived: Mapping[str, int], outputs: Outputs) -> None:
        values = self._state.values
        missing = [each for each in self._conjuncts if not each.is_true(values, arrived, outputs)]
        if len(missing) > self._best[0]:
            return
        distance = missing[0].distance(values, arrived, outputs) if len(missing) == 1 else math.inf
        candidate = (len(missing), distance)
        if candidate < self._best:
            self._best, self._missing, self._time_ns = candidate, missing, now_ns

    def result(self) -> NearestMiss:
        """The nearest miss of the whole log."""
        distance = self._best[1]
        return NearestMiss(
            time_s=seconds(self._time_ns),
            missing=tuple(each.text for each in self._missing),
            # At the bound a distance may be -0.0; adding 0.0 makes it 0.0.
            distance=distance + 0.0 if math.isfinite(distance) else None,
        )


def _compiled(conjunct: PastFormula, compiler: ExpressionCompiler) -> _Conjunct:
    condition = function_of(compiler.condition(conjunct, HysteresisScope.RUN))
    robustness = compiler.robustness(_with_shifted_bounds(conjunct, wanted=True))
    return _Conjunct(str(conjunct), condition, None if robustness is None else function_of(robustness))


def _with_shifted_bounds(formula: PastFormula, *, wanted: bool) -> PastFormula:
    """`formula` with the bounds at which it becomes `wanted`: a comparison becomes true only past its hysteresis."""
    match formula:
        case Comparison(for_s=0):
            width = Number(formula.hysteresis if wanted else 0.0)
            sign: ArithmeticOperator = "-" if formula.relation in ("<", "<=") else "+"
            bound = Arithmetic(sign, formula.right, width) if width.value else formula.right
            return Comparison(formula.relation, formula.left, bound)
        case Not():
            return Not(_with_shifted_bounds(formula.operand, wanted=not wanted))
        case And() | Or():
            return formula.changed(lambda operand: _with_shifted_bounds(operand, wanted=wanted))
        case _:
            return formula


def evaluate(requirements: Sequence[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts on a logged run, in the order of the requirements; those that were not triggered are explained.

    Raises:
        MonitorError: as from a `MonitorSet`; or a signal of the log has not one value for each time, or a bool is
            neither 0 nor 1.
    """
    kinds: dict[str, Kind] = {}
    topics: set[str] = set()
    for requirement in requirements:
        kinds.update({**dict.fromkeys(requirement.shows, float), **names_read(requirement.formula)})
        topics |= topics_read(requirement.formula)
    monitors = MonitorSet(requirements)
    _feed(monitors, log, kinds, topics)
    return explained(monitors.finish(log.end_s), requirements, log)


def watched(condition: PastFormula, log: Log) -> ConditionMonitor:
    """The truth of a condition over a logged run, as from `MonitorSet.watch`.

    Raises:
        MonitorError: as from `evaluate`.
    """
    monitors = MonitorSet()
    monitor = monitors.watch(condition)
    _feed(monitors, log, names_of([condition]), topics_of([condition]))
    monitors.finish(log.end_s)
    return monitor


def _feed(monitors: MonitorSet, log: Log, kinds: Mapping[str, Kind], topics: Iterable[str]) -> None:
    """Feed the signals and messages of a log that are read."""
    signals = [name for name in kinds if "." not in name]
    for name in signals:
        _require_one_value_each(name, *log.signals.get(name, ((), ())))
    for now_ns, updates in log.instants(signals, topics):
        time_s = seconds(now_ns)
        monitors.advance(time_s)
        for name, value in updates:
            if isinstance(value, Mapping):
                monitors.message(time_s, name, value)
            else:
                monitors.signal(time_s, name, _typed(time_s, name, value, kinds[name]))


def _require_one_value_each(name: str, times: Sequence[float], values: Sequence[Value]) -> None:
    if len(times) != len(values):
        raise MonitorError(f"{name}: expected one value for each of {len(times)} times, got {len(values)} values")


def _typed(time_s: float, name: str, value: Value, kind: Kind) -> Value:
    """The value as the monitors want it: a log may have a bool as a number, and numbers of other libraries."""
    if kind is bool:
        if value not in (0, 1):
            raise MonitorError(f"{name} at {time_s} s is {value!r}: not a bool")
        return bool(value)
    return float(value) if isinstance(value, Real) else value
