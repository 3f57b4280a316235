"""Past formulas evaluated at all times of a logged run at once, as numpy arrays.

The grid of a run has all times at which anything can change. At each time of the grid a formula has a value at the
instant, one right after it, valid up to the next time, and, if its history starts there, one just before it (see
`monitor.operators`).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pytest_hricdv.monitor.analysis import names_of, topics_of
from pytest_hricdv.monitor.compiler import HysteresisScope
from pytest_hricdv.monitor.errors import MonitorError, unset_value_error
from pytest_hricdv.monitor.evaluation_state import nanoseconds, seconds
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
    PastFormula,
    Previously,
    Rise,
    Since,
    Term,
)
from pytest_hricdv.monitor.offline import array_operators
from pytest_hricdv.monitor.offline.array_operators import UNDEFINED, UNKNOWN, Codes, Truth
from pytest_hricdv.monitor.offline.series import SeriesOfLog, Times

Numbers = NDArray[np.float64]
# Formulas with a history; a comparison has one with `[for d]`.
_PastOperator = Comparison | Rise | Fall | Previously | Once | Historically | Since

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


def grid_of(parts: tuple[PastFormula, ...], series: SeriesOfLog, more: Times | None = None) -> Times:
    """The times (ns) at which one of the formulas can change, the first and the last time of the run, and `more`."""
    ends = np.array([series.start_ns, series.end_ns], np.int64)
    times = [ends, *(_changes(part, series) for part in parts), *([] if more is None else [more])]
    grid = np.sort(np.concatenate(times), kind="stable")  # concatenated sorted arrays: nearly linear
    return grid[np.append(np.diff(grid) > 0, True) & (grid <= series.end_ns)]


def _changes(formula: PastFormula, series: SeriesOfLog) -> Times:
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


def _updates(formula: PastFormula, series: SeriesOfLog) -> Times:
    signals = [name for name in names_of([formula]) if "." not in name]
    sources = [*signals, *(f"on({topic})" for topic in topics_of([formula]))]
    return np.concatenate([np.empty(0, np.int64), *(series.updates(source) for source in sources)])


class Evaluator:
    """Evaluates the formulas of one requirement on one grid.

    Args:
        requirement: its id, for errors.
        starts: positions at which attempts begin; the hystereses of a state response are reset there.
    """

    def __init__(self, requirement: str, series: SeriesOfLog, grid: Times, starts: NDArray[np.intp]) -> None:
        self.grid = grid
        self._requirement = requirement
        self._series = series
        self._starts = starts

    def truth(self, formula: PastFormula, scope: HysteresisScope = HysteresisScope.RUN) -> Truth:
        """The truth of a formula; inside past operators, the scope of a hysteresis is the run."""
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
                return self.truth(formula.operand, scope).negated()
            case And():
                pairs = zip(self.truth(formula.left, scope), self.truth(formula.right, scope), strict=True)
                return Truth(*(np.where(left == 1, right, left) for left, right in pairs))
            case Or():
                pairs = zip(self.truth(formula.left, scope), self.truth(formula.right, scope), strict=True)
                return Truth(*(np.where(left == 0, right, left) for left, right in pairs))
            case Comparison() | Rise() | Fall() | Previously() | Once() | Historically() | Since():
                return self._past(formula)

    def robustness(self, formula: PastFormula) -> Numbers | None:
        """The signed distance to the bounds at each position; infinite where unknown; None if nothing is compared.

        See `ExpressionCompiler.robustness`.
        """
        distance = self._distance(formula)
        return None if distance is None else np.where(np.isnan(distance), np.inf, distance)

    def _distance(self, formula: PastFormula) -> Numbers | None:
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
                # NaN means unknown here; minimum and maximum propagate it.
                return np.minimum(left, right) if isinstance(formula, And) else np.maximum(left, right)
            case _:
                return None

    def _infinite(self, formula: PastFormula) -> Numbers:
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
                codes = array_operators.first_fault(left_codes, right_codes)
                return values, array_operators.first_fault(codes, defined)

    def _sides(self, formula: Comparison) -> tuple[Numbers, Numbers, Codes]:
        (left, left_codes), (right, right_codes) = self._number(formula.left), self._number(formula.right)
        return left, right, array_operators.first_fault(left_codes, right_codes)

    def _comparison(self, formula: Comparison, scope: HysteresisScope) -> Truth:
        left, right, codes = self._sides(formula)
        compare = _COMPARE[formula.relation]
        holds = np.where(codes < 0, codes, compare(left, right)).astype(np.int8)
        if formula.hysteresis == 0 or scope is HysteresisScope.NEVER:
            return Truth(holds, holds, holds)
        shift = -formula.hysteresis if formula.relation in ("<", "<=") else formula.hysteresis
        returned = np.where(codes < 0, codes, compare(left, right + shift)).astype(np.int8)
        starts = self._starts if scope is HysteresisScope.ATTEMPT else np.empty(0, np.intp)
        return array_operators.with_hysteresis(holds, returned, starts)

    # --- past operators

    def _past(self, formula: _PastOperator) -> Truth:
        """The history of an operator starts when its operands are first known, at an instant and right after it."""
        match formula:
            case Since():
                operands = [self.truth(formula.left), self.truth(formula.right)]
            case Comparison():
                bare = Comparison(formula.relation, formula.left, formula.right, formula.hysteresis)
                operands = [self.truth(bare)]
            case Rise() | Fall() | Previously() | Once() | Historically():
                operands = [self.truth(formula.operand)]
        unknown = np.any([(codes < 0) for truth in operands for codes in truth[:2]], axis=0)
        begin = int(np.argmin(unknown)) if not unknown.all() else len(unknown)
        self._require_known(formula, operands, begin)
        known = [Truth(*(codes[begin:] for codes in truth)) for truth in operands]
        at, after, first = self._operator(formula, known, self.grid[begin:])
        nothing = np.full(begin, UNKNOWN, np.int8)
        before = np.concatenate((nothing, first, after[:-1]))
        return Truth(np.concatenate((nothing, at)), np.concatenate((nothing, after)), before.astype(np.int8))

    def _require_known(self, formula: _PastOperator, operands: list[Truth], begin: int) -> None:
        for truth in operands:
            codes = np.minimum(truth.at, truth.after)
            faults = (codes < 0) & ((codes == UNDEFINED) | (np.arange(len(codes)) >= begin))
            if faults.any():
                index = int(np.argmax(faults))
                raise self.fault(codes[index : index + 1], index, formula)

    def fault(self, codes: Codes, index: int, read: PastFormula) -> MonitorError:
        """The error of a formula that is read while it is unknown or undefined."""
        time_s = seconds(int(self.grid[index]))
        if UNDEFINED in codes:
            return MonitorError(f"{self._requirement} at {time_s} s: an arithmetic result is not a finite number")
        names = names_of([read])
        known = self._series.values_at(names, int(self.grid[index]))
        return unset_value_error(self._requirement, time_s, ", ".join(name for name in names if name not in known))

    def _operator(self, formula: _PastOperator, operands: list[Truth], grid: Times) -> tuple[Codes, Codes, Codes]:
        """The output at each time, right after it, and (one value) before the first time."""
        truth = operands[0]
        no = np.zeros(min(1, len(grid)), np.int8)
        match formula:
            case Rise():
                return (*array_operators.risen(truth), no)
            case Fall():
                return (*array_operators.risen(truth.negated()), no)
            case Previously():
                return array_operators.shifted(truth.after, truth.before), truth.after, truth.before[:1]
            case Since():
                return (*array_operators.since(operands[0], operands[1]), no)
            case Once():
                return (*array_operators.once(truth, grid, formula.start_s, formula.end_s), no)
            case Historically():
                at, after = array_operators.once(truth.negated(), grid, formula.start_s, formula.end_s)
                return array_operators.negated(at), array_operators.negated(after), 1 - no
            case Comparison():
                held = array_operators.held(truth.at, grid, int(nanoseconds(formula.for_s)))
                return held, held, no
