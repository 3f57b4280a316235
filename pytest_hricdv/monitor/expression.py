"""Formulas written as Python expressions over the values, the messages of the instant, and the stateful operators."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto
from functools import partial
from typing import Any

from pytest_hricdv.monitor.analysis import sources
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
from pytest_hricdv.monitor.operators import (
    ForOperator,
    HysteresisOperator,
    OnceOperator,
    Operator,
    PreviouslyOperator,
    RiseOperator,
    SinceOperator,
)
from pytest_hricdv.monitor.view import nanoseconds


class HysteresisScope(Enum):
    """From when on a comparison with hysteresis remembers that it was violated."""

    RUN = auto()
    ATTEMPT = auto()
    NEVER = auto()


def function_of(expression: str) -> Callable[..., Any]:
    """The Python function of `v` (values), `m` (topics with a message) and `o` (outputs of operators)."""
    # The text is made of checked names (as literals), numbers and operators only: see ExpressionWriter.
    environment = {"INFINITY": math.inf, "finite": _finite}
    return eval(f"lambda v, m, o: {expression}", environment)  # type: ignore[no-any-return]


class ExpressionWriter:
    """Writes expressions, and collects the operators that they read by number.

    Attributes:
        operators: make the operators over the run, in the order in which they have to be stepped.
        latches: make the comparisons with hysteresis that start afresh with each attempt.
        operator_sources, latch_sources: the sources whose updates can change their operands.
    """

    def __init__(self) -> None:
        self.operators: list[Callable[[], Operator]] = []
        self.latches: list[Callable[[], HysteresisOperator]] = []
        self.operator_sources: list[frozenset[str]] = []
        self.latch_sources: list[frozenset[str]] = []
        self._written: dict[Past, str] = {}  # what is said twice is computed once

    def condition(self, formula: Past, scope: HysteresisScope) -> str:
        """An expression for the truth of `formula`; inside past operators hysteresis is always over the run."""
        match formula:
            case BooleanName():
                return f"v[{formula.name!r}]"
            case On():
                return f"({formula.topic!r} in m)"
            case Comparison():
                return self._comparison(formula, scope)
            case Not():
                return f"(not {self.condition(formula.operand, scope)})"
            case And():
                return f"({self.condition(formula.left, scope)} and {self.condition(formula.right, scope)})"
            case Or():
                return f"({self.condition(formula.left, scope)} or {self.condition(formula.right, scope)})"
            case Historically():
                return f"(not {self._past(Once(Not(formula.operand), formula.start_s, formula.end_s))})"
            case Fall():
                return self._past(Rise(Not(formula.operand)))
            case _:
                return self._past(formula)

    def robustness(self, formula: Past) -> str | None:
        """An expression for the signed distance of `formula` to its bounds; None if no comparison is in it.

        The quantitative semantics of signal temporal logic (Donze and Maler, "Robust satisfaction of temporal logic
        over real-valued signals", FORMATS 2010): min for `&`, max for `|`, and plus or minus infinity for what is
        only true or false. So are past operators and `[for d]` here. A hysteresis does not move the bound.
        """
        match formula:
            case Comparison() if formula.for_s == 0:
                return _distance(formula)
            case Not():
                inner = self.robustness(formula.operand)
                return None if inner is None else f"-{inner}"
            case And() | Or():
                parts = [self.robustness(part) for part in (formula.left, formula.right)]
                if parts == [None, None]:
                    return None
                distances = [
                    f"(INFINITY if {self.condition(part, HysteresisScope.NEVER)} else -INFINITY)"
                    if code is None
                    else code
                    for part, code in zip((formula.left, formula.right), parts, strict=True)
                ]
                return f"{'min' if isinstance(formula, And) else 'max'}({', '.join(distances)})"
            case _:
                return None

    def _past(self, formula: Rise | Once | Previously | Since | Comparison) -> str:
        """A past operator; as such counts a comparison with `[for d]` or with a hysteresis over the run."""
        if formula in self._written:
            return self._written[formula]
        match formula:
            case Rise():
                code = self._operator(RiseOperator, formula.operand)
            case Previously():
                code = self._operator(PreviouslyOperator, formula.operand)
            case Since():
                code = self._operator(SinceOperator, formula.left, formula.right)
            case Once():
                start_ns, end_ns = nanoseconds(formula.start_s), nanoseconds(formula.end_s)
                code = self._operator(partial(OnceOperator, start_ns=start_ns, end_ns=end_ns), formula.operand)
            case Comparison() if formula.for_s > 0:
                bare = Comparison(formula.relation, formula.left, formula.right, formula.hysteresis)
                code = self._operator(partial(ForOperator, length_ns=nanoseconds(formula.for_s)), bare)
            case Comparison():
                code = f"o[{self._next_index()}]"
                self.operators.append(partial(HysteresisOperator, self._next_index(), *_both_bounds(formula)))
                self.operator_sources.append(sources(formula))
        self._written[formula] = code
        return code

    def _operator(self, make: Callable[..., Operator], *operands: Past) -> str:
        # Operands first: they number and step their own operators before this one.
        codes = [function_of(self.condition(operand, HysteresisScope.RUN)) for operand in operands]
        index = self._next_index()
        self.operators.append(partial(make, index, *codes))
        self.operator_sources.extend(map(sources, operands))
        return f"o[{index}]"

    def _next_index(self) -> int:
        return len(self.operators) + len(self.latches)

    def _comparison(self, formula: Comparison, scope: HysteresisScope) -> str:
        if formula.for_s > 0 or (formula.hysteresis > 0 and scope is HysteresisScope.RUN):
            return self._past(formula)
        if formula.hysteresis == 0 or scope is HysteresisScope.NEVER:
            return _compared(formula)
        index = self._next_index()
        self.latches.append(partial(HysteresisOperator, index, *_both_bounds(formula)))
        self.latch_sources.append(sources(formula))
        return f"o[{index}]"


def _compared(formula: Comparison, shift: str = "") -> str:
    return f"({_term(formula.left)} {formula.relation} {_term(formula.right)}{shift})"


def _both_bounds(formula: Comparison) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The comparison with its own bound, and with the one to come back over after a violation."""
    sign = "-" if formula.relation in ("<", "<=") else "+"
    return function_of(_compared(formula)), function_of(_compared(formula, f" {sign} {formula.hysteresis!r}"))


def _distance(formula: Comparison) -> str:
    """Positive inside the bound, in the unit of the terms; at the bound 0, whichever way the comparison decides."""
    left, right = _term(formula.left), _term(formula.right)
    match formula.relation:
        case "<" | "<=":
            return f"({right} - {left})"
        case ">" | ">=":
            return f"({left} - {right})"
        case "==":
            return f"-abs({left} - {right})"
        case "!=":
            return f"abs({left} - {right})"


def _term(term: Term) -> str:
    match term:
        case Number():
            return repr(term.value)
        case FloatName():
            return f"v[{term.name!r}]"
        case Negative():
            return f"(-{_term(term.operand)})"
        case Arithmetic():
            return f"finite({_term(term.left)} {term.operator} {_term(term.right)})"


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise OverflowError("an arithmetic result is not a finite number")
    return value
