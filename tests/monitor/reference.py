"""The reference evaluator of logged runs: slow, but a direct transcription of the definitions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.monitor import Violation
from pytest_hricdv.monitor.analysis import names_of, names_read, walk
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil
from pytest_hricdv.monitor.node import PastFormula, is_optional
from pytest_hricdv.monitor.past_formula import Conjunction, Disjunction, Negation, NumberComparison, On
from pytest_hricdv.monitor.terms import Count, TimeBetween, TimeSince, leaves
from tests.monitor.logged_run import TICK_S, first_position, tick_of
from tests.monitor.reference_past import PastEvaluator


@dataclass(frozen=True)
class Summary:
    """The part of a verdict that is compared."""

    verdict: str
    triggers: int
    passes: int
    failures: int
    pending: int
    violations: list[Violation]
    margin: float | None
    margin_time_s: float | None


@dataclass(frozen=True)
class Judged:
    """One trigger: its violations, whether it is undecided, and its margins as (margin, tick)."""

    violations: list[Violation]
    undecided: bool
    margins: list[tuple[float, int]]


def flattened(formula: PastFormula) -> list[PastFormula]:
    parts = formula.operands if isinstance(formula, Conjunction) else ()
    return [operand for part in parts for operand in flattened(part)] or [formula]


def compares(formula: PastFormula) -> bool:
    match formula:
        case NumberComparison(left=TimeSince()):
            return False
        case NumberComparison(for_s=0):
            return True
        case Negation():
            return compares(formula.operand)
        case Conjunction() | Disjunction():
            return any(map(compares, formula.operands))
        case _:
            return False


class ReferenceEvaluator(PastEvaluator):
    """Verdicts and nearest misses of one run."""

    # --- nearest miss

    def near_miss(self, antecedent: PastFormula) -> tuple[float, list[str], float | None]:
        """Tick, missing conjuncts, and the distance of the one that is missing alone."""
        parts = flattened(antecedent)
        truths = [self.truth(part) for part in parts]
        candidates = []
        for p in range(1, self.end + 1):
            held = [truth[p] and self.is_known(part, p) for part, truth in zip(parts, truths, strict=True)]
            missing = [part for part, holds in zip(parts, held, strict=True) if not holds]
            alone = -self.distance_to_return(missing[0], p) if len(missing) == 1 else math.inf
            alone = alone if len(missing) == 1 and compares(missing[0]) else math.inf
            candidates.append((len(missing), alone, p, missing))
        _, alone, p, missing = min(candidates, key=lambda candidate: candidate[:3])
        return tick_of(p), [str(part) for part in missing], alone if math.isfinite(alone) else None

    def outcomes(self, antecedent: PastFormula) -> dict[str, set[bool]]:
        """What each conjunct was, where it had a value."""
        outcomes: dict[str, set[bool]] = {}
        for part in flattened(antecedent):
            truth = self.truth(part)
            outcomes.setdefault(str(part), set()).update(
                bool(truth[p]) for p in range(1, self.end + 1) if self.is_known(part, p)
            )
        return outcomes

    def is_known(self, f: PastFormula, p: int) -> bool:
        """A field is unknown before its first message, except where the formula asks for the message as well.

        A comparison with an unknown text is just false.
        """
        guarded = any(isinstance(node, On) for node in walk(f))
        needed = [name for name, kind in names_of([f]).items() if "." in name and not is_optional(name, kind)]
        return guarded or all(name in self.values[p] for name in needed)

    def distance_to_return(self, f: PastFormula, p: int, wanted: bool = True) -> float:
        match f:
            case NumberComparison(for_s=0) if not isinstance(f.left, TimeSince):
                return self.distance(f, p) - (f.hysteresis if wanted else 0.0)
            case Negation():
                return -self.distance_to_return(f.operand, p, not wanted)
            case Conjunction():
                return min(self.distance_to_return(part, p, wanted) for part in f.operands)
            case Disjunction():
                return max(self.distance_to_return(part, p, wanted) for part in f.operands)
            case _:
                return self.distance(f, p)

    # --- triggers

    def judge(self, formula: Formula, shows: tuple[str, ...] = ()) -> Summary:
        antecedent = [False, *self.truth(formula.antecedent)[1:]]  # nothing triggers before the run
        rising = [p for p in range(1, self.end + 1) if antecedent[p] and not antecedent[p - 1]]
        triggers = [self.trigger(formula, shows, antecedent, p) for p in rising]
        failures = sum(bool(trigger.violations) for trigger in triggers)
        pending = sum(trigger.undecided for trigger in triggers)
        passes = len(triggers) - failures - pending
        margin, tick = min((margin for trigger in triggers for margin in trigger.margins), default=(math.inf, 0))
        return Summary(
            verdict="Failed" if failures else "Passed" if passes else "NC",
            triggers=len(triggers),
            passes=passes,
            failures=failures,
            pending=pending,
            violations=sorted((violation for trigger in triggers for violation in trigger.violations), key=in_order),
            margin=finite(margin),
            margin_time_s=tick * TICK_S if math.isfinite(margin) else None,
        )

    def trigger(self, formula: Formula, shows: tuple[str, ...], antecedent: list[bool], start: int) -> Judged:
        response, last = formula.response, self.end
        match response:
            case Holds():
                end = next((p for p in range(start, last + 1) if not antecedent[p]), last + 1)
                good = self.truth(response.condition, since=start)
                distances = {p: self.distance(response.condition, p) for p in range(start, end)}
                breaches = [p for p in range(start, end) if not good[p] and (p == start or good[p - 1])]
                violations = []
                for breach in breaches:
                    lasting = range(breach, next((p for p in range(breach, end) if good[p]), end))
                    margin, at = min((distances[p], p) for p in lasting)
                    violations.append(self.violation(formula, shows, start, lasting, margin, tick_of(at)))
                return Judged(violations, False, [(distance, tick_of(p)) for p, distance in distances.items()])
            case HoldsUntil():
                released = self.truth(response.release)
                end = next((p for p in range(start, last + 1) if released[p]), last + 1)
                return self.safety(formula, shows, start, range(start, end), undecided=False)
        opens, closes = (first_position(tick_of(start) + self.ticks(t)) for t in (response.start_s, response.end_s))
        window = range(max(start, opens), min(closes, last) + 1)
        match response:
            case AlwaysWithin():
                return self.safety(formula, shows, start, window, undecided=opens > last)
            case Eventually():
                good = self.truth(response.condition)
                first = next((p for p in window if good[p]), None)
                if first is not None:
                    return Judged([], False, [((tick_of(closes) - tick_of(first)) * TICK_S, tick_of(first))])
                if closes > last:
                    return Judged([], True, [])
                came = tick_of(next((p for p in range(closes + 1, last + 1) if good[p]), last))
                margin = (tick_of(closes) - came) * TICK_S
                violation = self.violation(formula, shows, start, range(closes, closes + 1), margin, came)
                return Judged([violation], False, [(margin, came)])

    def safety(self, formula: Formula, shows: tuple[str, ...], start: int, window: range, *, undecided: bool) -> Judged:
        good = self.truth(formula.response.condition, since=None)
        breach = next((p for p in window if not good[p]), None)
        checked = window if breach is None else range(window.start, breach + 1)
        margins = [(self.distance(formula.response.condition, p), tick_of(p)) for p in checked]
        if breach is None:
            return Judged([], undecided, margins)
        lasting = range(breach, breach + 1)
        violation = self.violation(formula, shows, start, lasting, *margins[-1])
        return Judged([violation], undecided, margins)

    def violation(
        self, formula: Formula, shows: tuple[str, ...], start: int, lasting: range, margin: float, margin_at: int
    ) -> Violation:
        """The violation at the positions `lasting`: values at its first one; the largest ones of shown signals.

        The margin is that at the tick `margin_at`.
        """
        values_at_first = self.values[lasting[0]]
        peaks = {
            name: max(lasting, key=lambda p: (abs(float(self.values[p][name])), -p))
            for name in shows
            if name in values_at_first and name not in names_read(formula)
        }
        values = {name: self.values[p][name] for name, p in peaks.items()}
        values.update({name: values_at_first[name] for name in names_read(formula) if name in values_at_first})
        values.update({str(count): self.counted(count)[lasting[0]] for count in numbers(formula, Count)})
        times = {str(time): self.between(time)[lasting[0]] for time in numbers(formula, TimeBetween)}
        values.update({text: time for text, time in times.items() if time is not None})
        first = tick_of(lasting[0])
        return Violation(
            tick_of(start) * TICK_S,
            first * TICK_S,
            values,
            finite(margin),
            margin_s=None if margin_at == first or not math.isfinite(margin) else margin_at * TICK_S,
            values_s={
                name: tick_of(p) * TICK_S
                for name, p in peaks.items()
                if abs(float(values[name])) > abs(float(values_at_first[name]))
            },
        )


def finite(margin: float) -> float | None:
    return margin if math.isfinite(margin) else None


def numbers(formula: Formula, kind: type[Any]) -> list[Any]:
    parts = [node for part in formula.conditions for node in walk(part)]
    terms = [term for node in parts if isinstance(node, NumberComparison) for term in (node.left, node.right)]
    return [leaf for term in terms for leaf in leaves(term) if isinstance(leaf, kind)]


def in_order(violation: Violation) -> tuple[float, float]:
    return violation.time_s, violation.trigger_s
