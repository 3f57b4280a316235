"""The reference evaluator of logged runs: slow, but a direct transcription of the definitions.

Time is in whole ticks. A run is a sequence of positions: 0 is before the run, then instant, open interval, instant, ...
up to the last instant. Updates and windows are whole ticks, so nothing changes inside an open interval. A formula is a
list with one truth value per position, and every operator is written as its definition.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from pytest_hricdv.monitor import Violation
from pytest_hricdv.monitor.analysis import conditions, leaves, names_compared, names_of, names_read, walk
from pytest_hricdv.monitor.formula import (
    AlwaysWithin,
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Count,
    Eventually,
    Fall,
    FloatName,
    Formula,
    Historically,
    Holds,
    HoldsUntil,
    Negative,
    Not,
    Number,
    On,
    Once,
    Or,
    PastFormula,
    Previously,
    Rise,
    Since,
    Term,
    Text,
    TextComparison,
    TextTerm,
    TimeBetween,
    TimeSince,
)
from pytest_hricdv.monitor.vocabulary import is_optional

TICK_S = 0.25
Value = float | bool | str


@dataclass(frozen=True)
class Instant:
    """The updates of one tick: signals first."""

    signals: Mapping[str, Value] = field(default_factory=dict)
    messages: tuple[tuple[str, Mapping[str, Value]], ...] = ()


@dataclass(frozen=True)
class Trace:
    """A logged run: tick -> its updates; tick 0 updates every signal."""

    instants: Mapping[int, Instant]
    last: int


@dataclass(frozen=True)
class Summary:
    """The part of a verdict that is compared."""

    verdict: str
    attempts: int
    passes: int
    failures: int
    pending: int
    violations: list[Violation]
    margin: float | None
    margin_time_s: float | None


@dataclass(frozen=True)
class Judged:
    """One attempt: its violations, whether it is undecided, and its margins as (margin, tick)."""

    violations: list[Violation]
    undecided: bool
    margins: list[tuple[float, int]]


def tick_of(position: int) -> int:
    return (position - 1) // 2


def first_position(tick: float) -> int:
    return 1 + 2 * round(tick)


def flattened(formula: PastFormula) -> list[PastFormula]:
    return [*flattened(formula.left), *flattened(formula.right)] if isinstance(formula, And) else [formula]


def compares(formula: PastFormula) -> bool:
    match formula:
        case Comparison(left=TimeSince()):
            return False
        case Comparison(for_s=0):
            return True
        case Not():
            return compares(formula.operand)
        case And() | Or():
            return compares(formula.left) or compares(formula.right)
        case _:
            return False


class ReferenceEvaluator:
    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.end = first_position(trace.last)
        # One more position: an edge right after the last instant is true at that instant. It is not judged itself.
        self.positions = range(self.end + 2)
        self.values: list[dict[str, Value]] = []
        self.arrived: list[list[str]] = []
        last: dict[str, Value] = dict(trace.instants[0].signals)
        for position in self.positions:
            instant = trace.instants.get(tick_of(position), Instant()) if position % 2 else Instant()
            last.update(instant.signals)
            for topic, fields in instant.messages:
                for name, value in ((f"{topic}.{member}", value) for member, value in fields.items()):
                    if name in last:
                        last[f"last({name})"] = last[name]
                    last[name] = value
            # Before the run, signals have their first values, and there is no message.
            self.values.append(dict(trace.instants[0].signals) if position == 0 else dict(last))
            self.arrived.append([topic for topic, _ in instant.messages])

    # --- one value per position

    def number(self, term: Term, p: int) -> float:
        """The value of a term that has one."""
        match term:
            case Number():
                return term.value
            case FloatName():
                return float(self.values[p].get(term.name, 0.0))
            case Count():
                return self.counted(term)[p]
            case TimeBetween():
                elapsed = self.between(term)[p]
                assert elapsed is not None
                return elapsed
            case Negative():
                return -self.number(term.operand, p)
            case Arithmetic():
                left, right = self.number(term.left, p), self.number(term.right, p)
                return {"+": left + right, "-": left - right, "*": left * right}[term.operator]

    def text(self, term: TextTerm, p: int) -> Value | None:
        return term.value if isinstance(term, Text) else self.values[p].get(term.name)

    @cache  # noqa: B019 - an evaluator lives as long as its test
    def counted(self, f: Count) -> list[int]:
        """The number of edges in the window of the past, a message being one, at every position."""
        edges = self.occurrences(f.operand)
        start, end = self.ticks(f.start_s), self.ticks(f.end_s)
        return [sum(edges[max(1, p - 2 * end) : max(1, p - 2 * start + 1)]) for p in self.positions]

    def occurrences(self, f: PastFormula) -> list[int]:
        return [a.count(f.topic) for a in self.arrived] if isinstance(f, On) else list(map(int, self.truth(Rise(f))))

    @cache  # noqa: B019 - an evaluator lives as long as its test
    def between(self, f: TimeBetween) -> list[float | None]:
        """The time from the last begin at or before the last end to that end, at every position."""
        begins, ends = self.occurrences(f.begin), self.occurrences(f.end)
        found: list[float | None] = []
        for p in self.positions:
            pairs = [
                (q, max((b for b in range(1, q + 1) if begins[b]), default=None)) for q in range(1, p + 1) if ends[q]
            ]
            known = [(end, begin) for end, begin in pairs if begin is not None]
            found.append((tick_of(known[-1][0]) - tick_of(known[-1][1])) * TICK_S if known else None)
        return found

    def elapsed(self, f: Comparison) -> list[bool]:
        """Whether a time since is less than a bound (at most, with `<=`); the open intervals have no end.

        The distance of two positions in ticks: to an open interval, it is that to its end.
        """
        a, bound = self.truth(f.left.operand), self.ticks(f.right.value)

        def is_within(p: int, q: int) -> bool:
            if p == q:
                return bound > 0 or f.relation in ("<=", ">")
            to_end = tick_of(p) - tick_of(q + 1)  # from the later end of q to the start of p, in ticks
            if p % 2 == 0:  # the distance grows by a tick over p, without reaching it
                return to_end + 1 <= bound
            return to_end < bound or (to_end == bound and f.relation in ("<=", ">"))

        within = [any(a[q] and is_within(p, q) for q in range(1, p + 1)) for p in self.positions]
        return within if f.relation in ("<", "<=") else [not each for each in within]

    def compare_texts(self, f: TextComparison, p: int) -> bool:
        sides = {self.text(f.left, p), self.text(f.right, p)}
        return None not in sides and (len(sides) == 1) == (f.relation == "==")

    def has_values(self, f: Comparison, p: int) -> bool:
        last = all(name in self.values[p] for name in names_compared(f) if name.startswith("last("))
        times = [leaf for leaf in (*leaves(f.left), *leaves(f.right)) if isinstance(leaf, TimeBetween)]
        return last and all(self.between(time)[p] is not None for time in times)

    def compare(self, f: Comparison, p: int, shift: float = 0.0) -> bool:
        if not self.has_values(f, p):
            return False
        left, right = self.number(f.left, p), self.number(f.right, p)
        return {
            "<": left < right - shift,
            "<=": left <= right - shift,
            ">": left > right + shift,
            ">=": left >= right + shift,
            "==": left == right,
            "!=": left != right,
        }[f.relation]

    def with_hysteresis(self, f: Comparison, since: int | None) -> list[bool]:
        """`since`: the position from which on violations are remembered; None: never."""
        result: list[bool] = []
        for p in self.positions:
            remembered = since is not None and p > since and not result[-1]
            result.append(self.compare(f, p, f.hysteresis if remembered else 0.0))
        return result

    def truth(self, f: PastFormula, since: int | None = 0) -> list[bool]:
        """The truth of `f` at every position; `since` as above, for comparisons outside of past operators."""
        ps = self.positions
        match f:
            case BooleanName():
                return [bool(self.values[p].get(f.name, False)) for p in ps]
            case On():
                return [f.topic in self.arrived[p] for p in ps]
            case Comparison(left=TimeSince()):
                return self.elapsed(f)
            case Comparison(for_s=0):
                return self.with_hysteresis(f, since)
            case TextComparison(for_s=0):
                return [self.compare_texts(f, p) for p in ps]
            case Comparison() | TextComparison():
                ticks = self.ticks(f.for_s)
                held = self.with_hysteresis(f, 0) if isinstance(f, Comparison) else self.truth(replace(f, for_s=0.0))
                return [p - 2 * ticks >= 1 and all(held[p - 2 * ticks : p + 1]) for p in ps]
            case Not():
                return [not a for a in self.truth(f.operand, since)]
            case And():
                return [a and b for a, b in zip(self.truth(f.left, since), self.truth(f.right, since), strict=True)]
            case Or():
                return [a or b for a, b in zip(self.truth(f.left, since), self.truth(f.right, since), strict=True)]
            case Rise():
                return self.rise(self.truth(f.operand))
            case Fall():
                return self.rise([not a for a in self.truth(f.operand)])
            case Previously():
                a = self.truth(f.operand)
                # Inside an open interval "just before" lies in the same interval.
                return [a[p - 1] if p % 2 else a[p] for p in ps]
            case Once():
                return self.windowed(f, any)
            case Historically():
                return self.windowed(f, all)
            case Since():
                a, b = self.truth(f.left), self.truth(f.right)
                return [any(b[q] and all(a[q + 1 : p + 1]) for q in range(1, p + 1)) for p in ps]

    def rise(self, a: list[bool]) -> list[bool]:
        after = [*a[1:], a[-1]]
        return [p % 2 == 1 and ((a[p] and not a[p - 1]) or (after[p] and not a[p])) for p in self.positions]

    def windowed(self, f: Once | Historically, quantifier: object) -> list[bool]:
        assert quantifier in (any, all)
        a, start, end = self.truth(f.operand), self.ticks(f.start_s), self.ticks(f.end_s)
        chosen = any if quantifier is any else all
        return [chosen(a[q] for q in range(max(1, p - 2 * end), p - 2 * start + 1)) for p in self.positions]

    def ticks(self, time_s: float) -> int:
        return 10_000 if math.isinf(time_s) else round(time_s / TICK_S)

    def distance(self, f: PastFormula, p: int) -> float:
        match f:
            case Comparison(for_s=0) if not isinstance(f.left, TimeSince) and not self.has_values(f, p):
                return -math.inf
            case Comparison(for_s=0) if not isinstance(f.left, TimeSince):
                gap = self.number(f.right, p) - self.number(f.left, p)
                return {"<": gap, "<=": gap, ">": -gap, ">=": -gap, "==": -abs(gap), "!=": abs(gap)}[f.relation]
            case Not():
                return -self.distance(f.operand, p)
            case And():
                return min(self.distance(f.left, p), self.distance(f.right, p))
            case Or():
                return max(self.distance(f.left, p), self.distance(f.right, p))
            case _:
                return math.inf if self.truth(f)[p] else -math.inf

    # --- nearest miss

    def nearest_miss(self, antecedent: PastFormula) -> tuple[float, list[str], float | None]:
        """Tick, missing conjuncts, and the distance of the one that is missing alone."""
        parts = flattened(antecedent)
        truths = [self.truth(part) for part in parts]
        found = []
        for p in range(1, self.end + 1):
            held = [truth[p] and self.is_known(part, p) for part, truth in zip(parts, truths, strict=True)]
            missing = [part for part, holds in zip(parts, held, strict=True) if not holds]
            alone = -self.distance_to_return(missing[0], p) if len(missing) == 1 else math.inf
            alone = alone if len(missing) == 1 and compares(missing[0]) else math.inf
            found.append((len(missing), alone, p, missing))
        _, alone, p, missing = min(found, key=lambda each: each[:3])
        return tick_of(p), [str(part) for part in missing], alone if math.isfinite(alone) else None

    def is_known(self, f: PastFormula, p: int) -> bool:
        """A field is unknown before its first message, except where the formula asks for the message as well.

        A comparison with an unknown text is just false.
        """
        guarded = any(isinstance(node, On) for node in walk(f))
        needed = [name for name, kind in names_of([f]).items() if "." in name and not is_optional(name, kind)]
        return guarded or all(name in self.values[p] for name in needed)

    def distance_to_return(self, f: PastFormula, p: int, wanted: bool = True) -> float:
        match f:
            case Comparison(for_s=0) if not isinstance(f.left, TimeSince):
                return self.distance(f, p) - (f.hysteresis if wanted else 0.0)
            case Not():
                return -self.distance_to_return(f.operand, p, not wanted)
            case And():
                return min(self.distance_to_return(part, p, wanted) for part in (f.left, f.right))
            case Or():
                return max(self.distance_to_return(part, p, wanted) for part in (f.left, f.right))
            case _:
                return self.distance(f, p)

    # --- attempts

    def judge(self, formula: Formula, shows: tuple[str, ...] = ()) -> Summary:
        antecedent = [False, *self.truth(formula.antecedent)[1:]]  # nothing triggers before the run
        rising = [p for p in range(1, self.end + 1) if antecedent[p] and not antecedent[p - 1]]
        attempts = [self.attempt(formula, shows, antecedent, p) for p in rising]
        failures = sum(bool(attempt.violations) for attempt in attempts)
        pending = sum(attempt.undecided for attempt in attempts)
        passes = len(attempts) - failures - pending
        margin, tick = min((each for attempt in attempts for each in attempt.margins), default=(math.inf, 0))
        return Summary(
            verdict="Failed" if failures else "Passed" if passes else "NC",
            attempts=len(attempts),
            passes=passes,
            failures=failures,
            pending=pending,
            violations=sorted((each for attempt in attempts for each in attempt.violations), key=in_order),
            margin=finite(margin),
            margin_time_s=tick * TICK_S if math.isfinite(margin) else None,
        )

    def attempt(self, formula: Formula, shows: tuple[str, ...], antecedent: list[bool], start: int) -> Judged:
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
                    margin = min(distances[p] for p in lasting)
                    violations.append(self.violation(formula, shows, start, lasting, margin))
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
                violation = self.violation(formula, shows, start, range(closes, closes + 1), 0.0)
                return Judged([violation], False, [(0.0, tick_of(closes))])

    def safety(self, formula: Formula, shows: tuple[str, ...], start: int, window: range, *, undecided: bool) -> Judged:
        good = self.truth(formula.response.condition, since=None)
        breach = next((p for p in window if not good[p]), None)
        checked = window if breach is None else range(window.start, breach + 1)
        margins = [(self.distance(formula.response.condition, p), tick_of(p)) for p in checked]
        if breach is None:
            return Judged([], undecided, margins)
        margin, _ = margins[-1]
        return Judged([self.violation(formula, shows, start, range(breach, breach + 1), margin)], undecided, margins)

    def violation(
        self, formula: Formula, shows: tuple[str, ...], start: int, lasting: range, margin: float
    ) -> Violation:
        """The violation at the positions `lasting`: values at its first one; the largest ones of shown signals."""
        known = self.values[lasting[0]]
        values = {name: known[name] for name in shows if name in known}
        values = {name: max((self.values[p][name] for p in lasting), key=abs) for name in values}
        values.update({name: known[name] for name in names_read(formula) if name in known})
        values.update({str(count): self.counted(count)[lasting[0]] for count in numbers(formula, Count)})
        times = {str(time): self.between(time)[lasting[0]] for time in numbers(formula, TimeBetween)}
        values.update({text: time for text, time in times.items() if time is not None})
        return Violation(tick_of(start) * TICK_S, tick_of(lasting[0]) * TICK_S, values, finite(margin))


def finite(margin: float) -> float | None:
    return margin if math.isfinite(margin) else None


def numbers(formula: Formula, kind: type[Any]) -> list[Any]:
    parts = [node for part in (formula.antecedent, *conditions(formula.response)) for node in walk(part)]
    terms = [term for node in parts if isinstance(node, Comparison) for term in (node.left, node.right)]
    return [leaf for term in terms for leaf in leaves(term) if isinstance(leaf, kind)]


def in_order(violation: Violation) -> tuple[float, float]:
    return violation.time_s, violation.trigger_s
