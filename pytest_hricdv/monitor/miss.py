"""Why a requirement was not checked: when its antecedent came nearest to holding, what was missing, and by how much.

This looks at a run again after it, and only for what was never triggered: monitors that run along pay nothing for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace
from typing import Any

from pytest_hricdv.monitor.analysis import conjuncts, names_of, topics_of
from pytest_hricdv.monitor.errors import UnknownValueError
from pytest_hricdv.monitor.expression import ExpressionWriter, HysteresisScope, function_of
from pytest_hricdv.monitor.formula import And, Arithmetic, ArithmeticOperator, Comparison, Not, Number, Or, Past
from pytest_hricdv.monitor.log import Log, Update
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import NearestMiss, Verdict
from pytest_hricdv.monitor.view import (
    NO_MESSAGE,
    Condition,
    Nanoseconds,
    Outputs,
    Robustness,
    Values,
    View,
    seconds,
)

# A conjunct is looked at by itself here, so without what guards it in the antecedent.
_UNDEFINED = (UnknownValueError, ArithmeticError)


def explained(verdicts: Iterable[Verdict], requirements: Iterable[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts, each one of a requirement that was never triggered with its nearest miss.

    Args:
        verdicts: on the run that was logged.
        requirements: those that the verdicts are about, in the same order.
        log: the run.
    """
    return tuple(
        replace(verdict, nearest_miss=nearest_miss(requirement.formula.antecedent, log)) if verdict.vacuous else verdict
        for verdict, requirement in zip(verdicts, requirements, strict=True)
    )


def nearest_miss(antecedent: Past, log: Log) -> NearestMiss:
    """How near an antecedent that never held in a run came to holding.

    Of all times in the run it takes those at which the fewest conjuncts failed, of these the ones at which a single
    comparison failed by the least distance, and of these the first.
    """
    search = _Search(antecedent)
    wake_ns = math.inf
    for now_ns, updates in log.instants(search.signals, search.topics):
        while wake_ns < now_ns:
            wake_ns = search.look(wake_ns, last=False)
        search.update(updates)
        wake_ns = search.look(now_ns, last=now_ns == log.end_ns)
    return search.found()


@dataclass(frozen=True)
class _Conjunct:
    text: str
    holds: Condition
    robustness: Robustness | None  # to the bound at which it would come to hold

    def is_true(self, values: Values, arrived: Set[str], outputs: Outputs) -> bool:
        try:
            return self.holds(values, arrived, outputs)
        except _UNDEFINED:
            return False

    def distance(self, values: Values, arrived: Set[str], outputs: Outputs) -> float:
        if self.robustness is None:
            return math.inf
        try:
            return -self.robustness(values, arrived, outputs)
        except _UNDEFINED:
            return math.inf


class _Search:
    """The best that was seen so far, as time goes on."""

    def __init__(self, antecedent: Past) -> None:
        self._kinds = names_of([antecedent])
        self.signals = [name for name in self._kinds if "." not in name]
        self.topics = topics_of([antecedent])
        writer = ExpressionWriter()
        self._conjuncts = [_compiled(part, writer) for part in conjuncts(antecedent)]
        self._operators = [make() for make in writer.operators]
        self._arrived: set[str] = set()
        self._view = View(Values(), self._arrived)
        self._rank: tuple[float, float] = (math.inf, math.inf)
        self._missing: list[_Conjunct] = []
        self._time_ns: Nanoseconds = 0

    def update(self, updates: Iterable[Update]) -> None:
        """Take in what was updated at an instant."""
        for name, value in updates:
            if isinstance(value, Mapping):
                self._arrived.add(name)
                for field in self._kinds:
                    if field.startswith(f"{name}."):
                        self._set(field, value[field.partition(".")[2]])
            else:
                self._set(name, value)

    def _set(self, name: str, value: Any) -> None:
        self._view.values[name] = self._kinds[name](value)

    def look(self, now_ns: Nanoseconds, *, last: bool) -> Nanoseconds:
        """Weigh an instant and, unless it is the last, the time right after it; returns when to look again."""
        for operator in self._operators:
            operator.step(now_ns, self._view)
        self._weigh(now_ns, self._view.arrived, self._view.at)
        if not last:
            self._weigh(now_ns, NO_MESSAGE, self._view.after)
        self._arrived.clear()
        return min((operator.wake_ns for operator in self._operators), default=math.inf)

    def _weigh(self, now_ns: Nanoseconds, arrived: Set[str], outputs: Outputs) -> None:
        values = self._view.values
        missing = [each for each in self._conjuncts if not each.is_true(values, arrived, outputs)]
        if len(missing) > self._rank[0]:
            return
        alone = missing[0].distance(values, arrived, outputs) if len(missing) == 1 else math.inf
        rank = (len(missing), alone)
        if rank < self._rank:
            self._rank, self._missing, self._time_ns = rank, missing, now_ns

    def found(self) -> NearestMiss:
        """The nearest miss of all that was seen."""
        distance = self._rank[1]
        return NearestMiss(
            time_s=seconds(self._time_ns),
            missing=tuple(each.text for each in self._missing),
            # Adding 0.0 makes -0.0, as which a distance may come out at the bound, a plain zero.
            distance=distance + 0.0 if math.isfinite(distance) else None,
        )


def _compiled(conjunct: Past, writer: ExpressionWriter) -> _Conjunct:
    holds = function_of(writer.condition(conjunct, HysteresisScope.RUN))
    robustness = writer.robustness(_at_return_bound(conjunct, wanted=True))
    return _Conjunct(str(conjunct), holds, None if robustness is None else function_of(robustness))


def _at_return_bound(formula: Past, *, wanted: bool) -> Past:
    """`formula` with the bounds at which it would turn: a comparison that is false has to pass its hysteresis, too."""
    match formula:
        case Comparison(for_s=0):
            width = Number(formula.hysteresis if wanted else 0.0)
            sign: ArithmeticOperator = "-" if formula.relation in ("<", "<=") else "+"
            bound = Arithmetic(sign, formula.right, width) if width.value else formula.right
            return Comparison(formula.relation, formula.left, bound)
        case Not():
            return Not(_at_return_bound(formula.operand, wanted=not wanted))
        case And() | Or():
            sides = (_at_return_bound(side, wanted=wanted) for side in (formula.left, formula.right))
            return type(formula)(*sides)
        case _:
            return formula
