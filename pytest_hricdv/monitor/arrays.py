"""Past formulas evaluated over all times of a logged run at once, as numpy arrays.

A run is cut at the times at which anything can change. At each there is the instant itself and the time right after
it, up to the next; and, for operators whose history begins there, what was just before (see `operators`).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pytest_hricdv.monitor import sweep
from pytest_hricdv.monitor.analysis import names_of, topics_of
from pytest_hricdv.monitor.errors import MonitorError, no_value_yet
from pytest_hricdv.monitor.expression import HysteresisScope
from pytest_hricdv.monitor.formula import (
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Fall,
    FloatName,
    Historically,
    Negative,
    Not,
    Number,
    On,
    Once,
    Or,
    Past,
    Previously,
    Rise,
    Since,
    Term,
)
from pytest_hricdv.monitor.series import SeriesOfLog, Times
from pytest_hricdv.monitor.sweep import UNDEFINED, UNKNOWN, Codes, Truth
from pytest_hricdv.monitor.view import nanoseconds, seconds

Numbers = NDArray[np.float64]

_COMPARE: dict[str, Callable[[Numbers, Numbers], NDArray[np.bool_]]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}
_COMPUTE: dict[str, Callable[[Numbers, Numbers], Numbers]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
}


def grid_of(parts: tuple[Past, ...], series: SeriesOfLog, more: Times | None = None) -> Times:
    """The times (ns) at which any of some formulas can change, the first and the last of the run, and `more`."""
    ends = np.array([series.start_ns, series.end_ns], np.int64)
    times = [ends, *(_changes(part, series) for part in parts), *([] if more is None else [more])]
    grid = np.sort(np.concatenate(times), kind="stable")  # sorted runs one after the other: nearly linear
    return grid[np.append(np.diff(grid) > 0, True) & (grid <= series.end_ns)]


def _changes(formula: Past, series: SeriesOfLog) -> Times:
    match formula:
        case Once() | Historically():
            shifts = [formula.start_s, formula.end_s]
            inner = np.append(_changes(formula.operand, series), series.start_ns)
        case Comparison():
            shifts = [0.0, formula.for_s]
            inner = np.append(_updates(formula, series), series.start_ns)
        case BooleanName() | On():
            return _updates(formula, series)
        case And() | Or() | Since():
            return np.concatenate((_changes(formula.left, series), _changes(formula.right, series)))
        case _:
            return _changes(formula.operand, series)
    shifted = [inner + int(nanoseconds(shift)) for shift in {0.0, *shifts} if math.isfinite(shift)]
    return np.concatenate(shifted)


def _updates(formula: Past, series: SeriesOfLog) -> Times:
    signals = [name for name in names_of([formula]) if "." not in name]
    sources = [*signals, *(f"on({topic})" for topic in topics_of([formula]))]
    return np.concatenate([np.empty(0, np.int64), *(series.updates(source) for source in sources)])


class Evaluator:
    """Evaluates formulas of one requirement on one grid of times.

    Args:
        requirement: its id, for errors.
        starts: positions at which attempts begin: comparisons with a hysteresis in a state response start afresh there.
    """

    def __init__(self, requirement: str, series: SeriesOfLog, grid: Times, starts: NDArray[np.intp]) -> None:
        self.grid = grid
        self._requirement = requirement
        self._series = series
        self._starts = starts

    def truth(self, formula: Past, scope: HysteresisScope = HysteresisScope.RUN) -> Truth:
        """The truth of a formula; inside past operators hysteresis is always over the run."""
        match formula:
            case BooleanName():
                values, known = self._values(formula.name)
                codes = np.where(known, values != 0, UNKNOWN).astype(np.int8)
                return Truth(codes, codes, codes)
            case On():
                nothing = np.zeros(len(self.grid), np.int8)
                arrived = np.isin(self.grid, self._series.arrivals(formula.topic)).astype(np.int8)
                return Truth(arrived, nothing, nothing)
            case Comparison(for_s=0):
                return self._comparison(formula, scope)
            case Not():
                return Truth(*(sweep.negated(codes) for codes in self.truth(formula.operand, scope)))
            case And():
                pairs = zip(self.truth(formula.left, scope), self.truth(formula.right, scope), strict=True)
                return Truth(*(np.where(left == 1, right, left) for left, right in pairs))
            case Or():
                pairs = zip(self.truth(formula.left, scope), self.truth(formula.right, scope), strict=True)
                return Truth(*(np.where(left == 0, right, left) for left, right in pairs))
            case _:
                return self._past(formula)

    def robustness(self, formula: Past) -> Numbers | None:
        """The signed distance to the bounds at each position; infinite where unknown; None if nothing is compared.

        See `ExpressionWriter.robustness`.
        """
        distance = self._distance(formula)
        return None if distance is None else np.where(np.isnan(distance), np.inf, distance)

    def _distance(self, formula: Past) -> Numbers | None:
        match formula:
            case Comparison(for_s=0):
                left, right, codes = self._sides(formula)
                with np.errstate(all="ignore"):
                    gap = right - left if formula.relation in ("<", "<=") else left - right
                if formula.relation in ("==", "!="):
                    gap = np.abs(gap) if formula.relation == "!=" else -np.abs(gap)
                return np.repeat(np.where(codes < 0, np.nan, gap), 2)[:-1]
            case Not():
                inner = self._distance(formula.operand)
                return None if inner is None else -inner
            case And() | Or():
                parts = [self._distance(part) for part in (formula.left, formula.right)]
                if parts[0] is None and parts[1] is None:
                    return None
                left, right = (
                    self._infinite(part) if distance is None else distance
                    for part, distance in zip((formula.left, formula.right), parts, strict=True)
                )
                # These let NaN, which stands for unknown here, prevail.
                return np.minimum(left, right) if isinstance(formula, And) else np.maximum(left, right)
            case _:
                return None

    def _infinite(self, formula: Past) -> Numbers:
        codes = self.truth(formula, HysteresisScope.NEVER).positions()
        return np.where(codes < 0, np.nan, np.where(codes == 1, np.inf, -np.inf))

    # --- comparisons

    def _values(self, name: str) -> tuple[Numbers, NDArray[np.bool_]]:
        series = self._series.of(name)
        if series is None:
            return np.zeros(len(self.grid)), np.zeros(len(self.grid), bool)
        return series.at(self.grid), series.known(self.grid)

    def _number(self, term: Term) -> tuple[Numbers, Codes]:
        """The values of a term, and codes that are negative where it has none."""
        match term:
            case Number():
                return np.full(len(self.grid), term.value), np.ones(len(self.grid), np.int8)
            case FloatName():
                values, known = self._values(term.name)
                return values, np.where(known, 1, UNKNOWN).astype(np.int8)
            case Negative():
                values, codes = self._number(term.operand)
                return -values, codes
            case Arithmetic():
                (left, left_codes), (right, right_codes) = self._number(term.left), self._number(term.right)
                with np.errstate(all="ignore"):
                    values = _COMPUTE[term.operator](left, right)
                defined = np.where(np.isfinite(values), 1, UNDEFINED).astype(np.int8)
                return values, sweep.first_fault(sweep.first_fault(left_codes, right_codes), defined)

    def _sides(self, formula: Comparison) -> tuple[Numbers, Numbers, Codes]:
        (left, left_codes), (right, right_codes) = self._number(formula.left), self._number(formula.right)
        return left, right, sweep.first_fault(left_codes, right_codes)

    def _comparison(self, formula: Comparison, scope: HysteresisScope) -> Truth:
        left, right, codes = self._sides(formula)
        compare = _COMPARE[formula.relation]
        holds = np.where(codes < 0, codes, compare(left, right)).astype(np.int8)
        if formula.hysteresis == 0 or scope is HysteresisScope.NEVER:
            return Truth(holds, holds, holds)
        shift = -formula.hysteresis if formula.relation in ("<", "<=") else formula.hysteresis
        returned = np.where(codes < 0, codes, compare(left, right + shift)).astype(np.int8)
        starts = self._starts if scope is HysteresisScope.ATTEMPT else np.empty(0, np.intp)
        return sweep.latched(holds, returned, starts)

    # --- past operators

    def _past(self, formula: Past) -> Truth:
        """An operator's history begins when its operands are first known, at an instant and right after it."""
        match formula:
            case Since():
                operands = [self.truth(formula.left), self.truth(formula.right)]
            case Comparison():
                bare = Comparison(formula.relation, formula.left, formula.right, formula.hysteresis)
                operands = [self.truth(bare)]
            case Rise() | Fall() | Previously() | Once() | Historically():
                operands = [self.truth(formula.operand)]
            case _:
                raise AssertionError(formula)
        unknown = np.any([(codes < 0) for truth in operands for codes in truth[:2]], axis=0)
        begin = int(np.argmin(unknown)) if not unknown.all() else len(unknown)
        self._require_known(formula, operands, begin)
        known = [Truth(*(codes[begin:] for codes in truth)) for truth in operands]
        at, after, first = self._operator(formula, known, self.grid[begin:])
        nothing = np.full(begin, UNKNOWN, np.int8)
        before = np.concatenate((nothing, first, after[:-1]))
        return Truth(np.concatenate((nothing, at)), np.concatenate((nothing, after)), before.astype(np.int8))

    def _require_known(self, formula: Past, operands: list[Truth], begin: int) -> None:
        for truth in operands:
            codes = np.minimum(truth.at, truth.after)
            faults = (codes < 0) & ((codes == UNDEFINED) | (np.arange(len(codes)) >= begin))
            if faults.any():
                index = int(np.argmax(faults))
                raise self.fault(codes[index : index + 1], index, formula)

    def fault(self, codes: Codes, index: int, read: Past) -> MonitorError:
        """The error of reading a formula that is unknown or undefined at a time of the grid."""
        time_s = seconds(int(self.grid[index]))
        if UNDEFINED in codes:
            return MonitorError(f"{self._requirement} at {time_s} s: an arithmetic result is not a finite number")
        names = names_of([read])
        known = self._series.values_at(names, int(self.grid[index]))
        return no_value_yet(self._requirement, time_s, ", ".join(name for name in names if name not in known))

    def _operator(self, formula: Past, operands: list[Truth], grid: Times) -> tuple[Codes, Codes, Codes]:
        """At, after, and (a single value) before its first time."""
        truth = operands[0]
        no = np.zeros(min(1, len(grid)), np.int8)
        match formula:
            case Rise():
                return (*sweep.risen(truth), no)
            case Fall():
                return (*sweep.risen(Truth(*(sweep.negated(codes) for codes in truth))), no)
            case Previously():
                return sweep.shifted(truth.after, truth.before), truth.after, truth.before[:1]
            case Since():
                return (*sweep.since(operands[0], operands[1]), no)
            case Once():
                return (*sweep.once(truth, grid, formula.start_s, formula.end_s), no)
            case Historically():
                negated = Truth(*(sweep.negated(codes) for codes in truth))
                at, after = sweep.once(negated, grid, formula.start_s, formula.end_s)
                return sweep.negated(at), sweep.negated(after), 1 - no
            case _:
                assert isinstance(formula, Comparison)
                held = sweep.held(truth.at, grid, int(nanoseconds(formula.for_s)))
                return held, held, no
