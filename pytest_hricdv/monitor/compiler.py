"""Past formulas compiled to Python expressions, and the stateful operators that these expressions read.

A past formula becomes a Python expression over the values `v`, the topics with a message `m` and the outputs of
operators `o`. What needs memory becomes an operator; it is stepped separately and the expression reads its output.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from enum import Enum, auto
from functools import partial
from typing import Any

from pytest_hricdv.monitor.analysis import names_compared, sources
from pytest_hricdv.monitor.evaluation_state import nanoseconds
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
    Text,
    TextComparison,
    TextName,
    TextTerm,
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

_Stateful = Rise | Once | Previously | Since | Comparison | TextComparison


class HysteresisScope(Enum):
    """Since when a comparison with hysteresis remembers that it was violated."""

    RUN = auto()
    ATTEMPT = auto()
    NEVER = auto()


def function_of(expression: str) -> Callable[..., Any]:
    """The Python function of `v` (values), `m` (topics with a message) and `o` (outputs of operators)."""
    # Safe to evaluate: ExpressionCompiler writes only checked names (as literals), numbers and operators.
    environment = {"INFINITY": math.inf, "finite": _finite}
    return eval(f"lambda v, m, o: {expression}", environment)  # type: ignore[no-any-return]


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise OverflowError("an arithmetic result is not a finite number")
    return value


class ExpressionCompiler:
    """Writes expressions, and collects the operators whose outputs they read by number.

    Attributes:
        run_operators, attempt_operators: as of `Program`.
        run_sources, attempt_sources: the sources whose updates can change the operands of these operators.
    """

    def __init__(self) -> None:
        self.run_operators: list[Callable[[], Operator]] = []
        self.attempt_operators: list[Callable[[], HysteresisOperator]] = []
        self.run_sources: list[frozenset[str]] = []
        self.attempt_sources: list[frozenset[str]] = []
        self._compiled: dict[PastFormula, str] = {}  # equal subformulas share one operator

    def condition(self, formula: PastFormula, scope: HysteresisScope) -> str:
        """An expression for the truth of `formula`; inside past operators, the scope of a hysteresis is the run."""
        match formula:
            case BooleanName():
                return f"v[{formula.name!r}]"
            case On():
                return f"({formula.topic!r} in m)"
            case Comparison() | TextComparison():
                return self._comparison(formula, scope)
            case Not():
                return f"(not {self.condition(formula.operand, scope)})"
            case And():
                return f"({self.condition(formula.left, scope)} and {self.condition(formula.right, scope)})"
            case Or():
                return f"({self.condition(formula.left, scope)} or {self.condition(formula.right, scope)})"
            case Historically():
                return f"(not {self._stateful(Once(Not(formula.operand), formula.start_s, formula.end_s))})"
            case Fall():
                return self._stateful(Rise(Not(formula.operand)))
            case Rise() | Previously() | Once() | Since():
                return self._stateful(formula)

    def robustness(self, formula: PastFormula) -> str | None:
        """An expression for the signed distance of `formula` to its bounds; None if it contains no comparison.

        The quantitative semantics of signal temporal logic (Donze and Maler, "Robust satisfaction of temporal logic
        over real-valued signals", FORMATS 2010): min for `&`, max for `|`, plus or minus infinity for a formula
        without a comparison. Past operators and `[for d]` count as such. A hysteresis does not move the bound.
        """
        match formula:
            case Comparison(for_s=0):
                return _distance(formula)
            case Not():
                inner = self.robustness(formula.operand)
                return None if inner is None else f"-{inner}"
            case And() | Or():
                left, right = self.robustness(formula.left), self.robustness(formula.right)
                if left is None and right is None:
                    return None
                left, right = left or self._infinite(formula.left), right or self._infinite(formula.right)
                return f"{'min' if isinstance(formula, And) else 'max'}({left}, {right})"
            case _:
                return None

    def _infinite(self, formula: PastFormula) -> str:
        return f"(INFINITY if {self.condition(formula, HysteresisScope.NEVER)} else -INFINITY)"

    def _comparison(self, formula: Comparison | TextComparison, scope: HysteresisScope) -> str:
        has_hysteresis = isinstance(formula, Comparison) and formula.hysteresis > 0
        if formula.for_s > 0 or (has_hysteresis and scope is HysteresisScope.RUN):
            return self._stateful(formula)
        if not isinstance(formula, Comparison) or not has_hysteresis or scope is HysteresisScope.NEVER:
            return _comparison_text(formula)
        index = self._next_index()
        self.attempt_operators.append(partial(HysteresisOperator, index, *_both_bounds(formula)))
        self.attempt_sources.append(sources(formula))
        return f"o[{index}]"

    def _stateful(self, formula: _Stateful) -> str:
        """The output of an operator over the run."""
        if formula not in self._compiled:
            self._compiled[formula] = self._operator(formula)
        return self._compiled[formula]

    def _operator(self, formula: _Stateful) -> str:
        match formula:
            case Rise():
                return self._past_operator(RiseOperator, formula.operand)
            case Previously():
                return self._past_operator(PreviouslyOperator, formula.operand)
            case Since():
                return self._past_operator(SinceOperator, formula.left, formula.right)
            case Once():
                start_ns, end_ns = nanoseconds(formula.start_s), nanoseconds(formula.end_s)
                return self._past_operator(partial(OnceOperator, start_ns=start_ns, end_ns=end_ns), formula.operand)
            case TextComparison() | Comparison() if formula.for_s > 0:
                length_ns = nanoseconds(formula.for_s)
                return self._past_operator(partial(ForOperator, length_ns=length_ns), replace(formula, for_s=0.0))
            case Comparison():
                index = self._next_index()
                self.run_operators.append(partial(HysteresisOperator, index, *_both_bounds(formula)))
                self.run_sources.append(sources(formula))
                return f"o[{index}]"
            case TextComparison():
                raise AssertionError("a comparison of texts without duration has no memory")

    def _past_operator(self, make: Callable[..., Operator], *operands: PastFormula) -> str:
        # Operands first: the operators in them have to be stepped before this one.
        functions = [function_of(self.condition(operand, HysteresisScope.RUN)) for operand in operands]
        index = self._next_index()
        self.run_operators.append(partial(make, index, *functions))
        self.run_sources.extend(map(sources, operands))
        return f"o[{index}]"

    def _next_index(self) -> int:
        return len(self.run_operators) + len(self.attempt_operators)


def _comparison_text(formula: Comparison | TextComparison, shift: str = "") -> str:
    # A comparison with a text that no message has brought yet is false.
    known = [
        f"{each.name!r} in v" for each in names_compared(formula) if isinstance(each, TextName) and "." in each.name
    ]
    return f"({' and '.join([*known, f'{_term(formula.left)} {formula.relation} {_term(formula.right)}{shift}'])})"


def _both_bounds(formula: Comparison) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The comparison with its own bound, and with the bound shifted by the hysteresis."""
    sign = "-" if formula.relation in ("<", "<=") else "+"
    shifted = _comparison_text(formula, f" {sign} {formula.hysteresis!r}")
    return function_of(_comparison_text(formula)), function_of(shifted)


def _distance(formula: Comparison) -> str:
    """Positive inside the bound, in the unit of the terms; 0 at the bound, for `<` and for `<=`."""
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


def _term(term: Term | TextTerm) -> str:
    match term:
        case Number() | Text():
            return repr(term.value)
        case FloatName() | TextName():
            return f"v[{term.name!r}]"
        case Negative():
            return f"(-{_term(term.operand)})"
        case Arithmetic():
            return f"finite({_term(term.left)} {term.operator} {_term(term.right)})"
