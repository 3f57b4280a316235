"""The reference evaluator of what is about the present and the past: every operator as its definition.

A formula is a list with one truth value per position of a run (see `tests.monitor.logged_run`).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

from pytest_hricdv.monitor.node import PastFormula, Term, TextTerm
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Conjunction,
    Disjunction,
    Fall,
    Historically,
    Negation,
    NumberComparison,
    On,
    Once,
    Previously,
    Rise,
    Since,
    TextComparison,
)
from pytest_hricdv.monitor.terms import (
    ArithmeticTerm,
    Count,
    FloatName,
    Negative,
    NumberTerm,
    Text,
    TimeBetween,
    TimeSince,
    leaves,
)
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun, Value, first_position, tick_of


class PastEvaluator:
    """Truth and distance of formulas, at the positions of one run."""

    def __init__(self, trace: LoggedRun) -> None:
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
            case NumberTerm():
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
            case ArithmeticTerm():
                left, right = self.number(term.left, p), self.number(term.right, p)
                return {"+": left + right, "-": left - right, "*": left * right}[term.operator]
            case _:
                raise AssertionError(term)

    def text(self, term: TextTerm, p: int) -> Value | None:
        return term.value if isinstance(term, Text) else self.values[p].get(str(term))

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
        times_s: list[float | None] = []
        for p in self.positions:
            pairs = [
                (q, max((b for b in range(1, q + 1) if begins[b]), default=None)) for q in range(1, p + 1) if ends[q]
            ]
            complete = [(end, begin) for end, begin in pairs if begin is not None]
            times_s.append((tick_of(complete[-1][0]) - tick_of(complete[-1][1])) * TICK_S if complete else None)
        return times_s

    def elapsed(self, f: NumberComparison) -> list[bool]:
        """Whether a time since is less than a bound (at most, with `<=`); the open intervals have no end.

        The distance of two positions in ticks: to an open interval, it is that to its end.
        """
        assert isinstance(f.left, TimeSince)
        assert isinstance(f.right, NumberTerm)
        a, bound = self.truth(f.left.operand), self.ticks(f.right.value)

        def is_within(p: int, q: int) -> bool:
            if p == q:
                return bound > 0 or f.relation in ("<=", ">")
            to_end = tick_of(p) - tick_of(q + 1)  # from the later end of q to the start of p, in ticks
            if p % 2 == 0:  # the distance grows by a tick over p, without reaching it
                return to_end + 1 <= bound
            return to_end < bound or (to_end == bound and f.relation in ("<=", ">"))

        within = [any(a[q] and is_within(p, q) for q in range(1, p + 1)) for p in self.positions]
        return within if f.relation in ("<", "<=") else [not holds for holds in within]

    def compare_texts(self, f: TextComparison, p: int) -> bool:
        sides = {self.text(f.left, p), self.text(f.right, p)}
        return None not in sides and (len(sides) == 1) == (f.relation == "==")

    def has_values(self, f: NumberComparison, p: int) -> bool:
        last = all(name in self.values[p] for name in f.own_names if name.startswith("last("))
        times = [leaf for leaf in (*leaves(f.left), *leaves(f.right)) if isinstance(leaf, TimeBetween)]
        return last and all(self.between(time)[p] is not None for time in times)

    def compare(self, f: NumberComparison, p: int, shift: float = 0.0) -> bool:
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

    def with_hysteresis(self, f: NumberComparison, since: int | None) -> list[bool]:
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
            case NumberComparison(left=TimeSince()):
                return self.elapsed(f)
            case NumberComparison(for_s=0):
                return self.with_hysteresis(f, since)
            case TextComparison(for_s=0):
                return [self.compare_texts(f, p) for p in ps]
            case NumberComparison() | TextComparison():
                ticks = self.ticks(f.for_s)
                held = (
                    self.with_hysteresis(f, 0) if isinstance(f, NumberComparison) else self.truth(replace(f, for_s=0.0))
                )
                return [p - 2 * ticks >= 1 and all(held[p - 2 * ticks : p + 1]) for p in ps]
            case Negation():
                return [not a for a in self.truth(f.operand, since)]
            case Conjunction():
                return [all(values) for values in zip(*(self.truth(part, since) for part in f.operands), strict=True)]
            case Disjunction():
                return [any(values) for values in zip(*(self.truth(part, since) for part in f.operands), strict=True)]
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
            case _:
                raise TypeError(f"the reference has no definition of {type(f).__name__}")

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
            case NumberComparison(for_s=0) if not isinstance(f.left, TimeSince) and not self.has_values(f, p):
                return -math.inf
            case NumberComparison(for_s=0) if not isinstance(f.left, TimeSince):
                gap = self.number(f.right, p) - self.number(f.left, p)
                return {"<": gap, "<=": gap, ">": -gap, ">=": -gap, "==": -abs(gap), "!=": abs(gap)}[f.relation]
            case Negation():
                return -self.distance(f.operand, p)
            case Conjunction():
                return min(self.distance(part, p) for part in f.operands)
            case Disjunction():
                return max(self.distance(part, p) for part in f.operands)
            case _:
                return math.inf if self.truth(f)[p] else -math.inf
