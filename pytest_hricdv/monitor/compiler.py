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

from pytest_hricdv.monitor.analysis import leaves, names_compared, sources
from pytest_hricdv.monitor.evaluation_state import Condition, nanoseconds
from pytest_hricdv.monitor.formula import (
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Count,
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
    TimeBetween,
    TimeSince,
)
from pytest_hricdv.monitor.number_operators import CountOperator, NumberOperator, TimeBetweenOperator
from pytest_hricdv.monitor.operators import (
    ForOperator,
    HysteresisOperator,
    OnceOperator,
    Operator,
    PreviouslyOperator,
    RiseOperator,
    SinceOperator,
    TimeSinceOperator,
)
from pytest_hricdv.monitor.vocabulary import is_optional

_Stateful = Rise | Once | Previously | Since | Comparison | TextComparison | Count | TimeBetween


class HysteresisScope(Enum):
    """Since when a comparison with hysteresis remembers that it was violated."""

    RUN = auto()
    TRIGGER = auto()
    NEVER = auto()


def function_of(expression: str) -> Callable[..., Any]:
    """The Python function of `v` (values), `m` (topic -> number of messages) and `o` (outputs of operators)."""
    # Safe to evaluate: ExpressionCompiler writes only checked names (as literals), numbers and operators.
    # Compiled once: it runs at every physics substep, where walking through the tree of the formula would take too
    # long.
    environment = {"INFINITY": math.inf, "finite": _finite}
    return eval(f"lambda v, m, o: {expression}", environment)  # type: ignore[no-any-return]


def _finite(value: float) -> float:
    # An overflow to infinity would make a comparison true or false without anybody noticing.
    if not math.isfinite(value):
        raise OverflowError("an arithmetic result is not a finite number")
    return value


class ExpressionCompiler:
    """Writes expressions, and collects the operators whose outputs they read by number.

    Attributes:
        run_operators, trigger_operators: as of `RequirementProgram`.
        past_numbers: the text of each count and time between -> the number of its operator.
        run_sources, trigger_sources: the sources whose updates can change the operands of these operators.
    """

    def __init__(self) -> None:
        self.run_operators: list[Callable[[], Operator]] = []
        self.trigger_operators: list[Callable[[], HysteresisOperator]] = []
        self.past_numbers: dict[str, int] = {}
        self.run_sources: list[frozenset[str]] = []
        self.trigger_sources: list[frozenset[str]] = []
        self._compiled: dict[_Stateful, str] = {}  # equal subformulas share one operator

    def condition(self, formula: PastFormula, scope: HysteresisScope) -> str:
        """An expression for the truth of `formula`; inside past operators, the scope of a hysteresis is the run."""
        match formula:
            case BooleanName():
                return f"v.get({formula.name!r}, False)" if is_optional(formula.name, bool) else f"v[{formula.name!r}]"
            case On():
                return f"({formula.topic!r} in m)"
            case Comparison() | TextComparison():
                return self._comparison(formula, scope)
            case Not():
                return f"(not {self.condition(formula.operand, scope)})"
            case And() | Or():
                word = " and " if isinstance(formula, And) else " or "
                return f"({word.join([self.condition(operand, scope) for operand in formula.operands])})"
            case Historically():
                # By its dual, so that only one operator has the windows to get right.
                return f"(not {self._stateful(Once(Not(formula.operand), formula.start_s, formula.end_s))})"
            case Fall():
                return self._stateful(Rise(Not(formula.operand)))
            case Rise() | Previously() | Once() | Since():
                return self._stateful(formula)

    def robustness(self, formula: PastFormula) -> str | None:
        """An expression for the signed distance of `formula` to its bounds; None if it contains no comparison.

        The quantitative semantics of signal temporal logic (Donze and Maler, "Robust satisfaction of temporal logic
        over real-valued signals", FORMATS 2010): min for `&`, max for `|`, plus or minus infinity for a formula
        without a comparison, such as past operators, `time_since` and `[for d]`. A hysteresis does not move the bound.
        """
        match formula:
            case Comparison(left=TimeSince()):
                return None
            case Comparison(for_s=0):
                return self._distance(formula)
            case Not():
                inner = self.robustness(formula.operand)
                return None if inner is None else f"-{inner}"
            case And() | Or():
                distances = [self.robustness(operand) for operand in formula.operands]
                if not any(distances):
                    return None
                parts = [
                    distance or self._infinite(part) for distance, part in zip(distances, formula.operands, strict=True)
                ]
                return f"{'min' if isinstance(formula, And) else 'max'}({', '.join(parts)})"
            case _:
                return None

    def _infinite(self, formula: PastFormula) -> str:
        return f"(INFINITY if {self.condition(formula, HysteresisScope.NEVER)} else -INFINITY)"

    def _comparison(self, formula: Comparison | TextComparison, scope: HysteresisScope) -> str:
        if formula.for_s > 0 or isinstance(formula.left, TimeSince):
            return self._stateful(formula)
        if not isinstance(formula, Comparison) or formula.hysteresis == 0 or scope is HysteresisScope.NEVER:
            return self._comparison_text(formula)
        if scope is HysteresisScope.RUN:
            return self._stateful(formula)
        # Not shared with equal comparisons: it is reset at each trigger, which others must not notice.
        bounds = self._both_bounds(formula)
        index = self._next_index()
        self.trigger_operators.append(partial(HysteresisOperator, index, *bounds))
        self.trigger_sources.append(sources(formula))
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
                once = partial(OnceOperator, start_ns=nanoseconds(formula.start_s), end_ns=nanoseconds(formula.end_s))
                return self._past_operator(once, formula.operand)
            case Count():
                start_ns, end_ns = nanoseconds(formula.start_s), nanoseconds(formula.end_s)
                counting = partial(CountOperator, start_ns=start_ns, end_ns=end_ns)
                return self._number_operator(counting, formula, formula.operand)
            case TimeBetween():
                return self._number_operator(TimeBetweenOperator, formula, formula.begin, formula.end)
            case Comparison() | TextComparison() if formula.for_s > 0:
                lasting = partial(ForOperator, length_ns=nanoseconds(formula.for_s))
                return self._past_operator(lasting, replace(formula, for_s=0.0))
            case Comparison(left=TimeSince(operand), right=Number(bound_s)):
                elapsed = partial(
                    TimeSinceOperator, bound_ns=nanoseconds(bound_s), closed=formula.relation in ("<=", ">")
                )
                output = self._past_operator(elapsed, operand)
                return output if formula.relation in ("<", "<=") else f"(not {output})"
            case Comparison():
                bounds = self._both_bounds(formula)
                return self._add(partial(HysteresisOperator, self._next_index(), *bounds), formula)
            case TextComparison():
                raise AssertionError("a comparison of texts without duration has no memory")

    def _number_operator(
        self, make: Callable[..., NumberOperator], number: Count | TimeBetween, *operands: PastFormula
    ) -> str:
        """The output of an operator over occurrences: of messages, or of instants at which an operand becomes true."""
        occurrences = [
            function_of(f"m.get({operand.topic!r}, 0)" if isinstance(operand, On) else self._stateful(Rise(operand)))
            for operand in operands
        ]
        self.past_numbers[str(number)] = self._next_index()
        return self._add(partial(make, self._next_index(), *occurrences), *operands)

    def _past_operator(self, make: Callable[..., Operator], *operands: PastFormula) -> str:
        # Operands first: the operators in them have to be stepped before this one.
        functions = [function_of(self.condition(operand, HysteresisScope.RUN)) for operand in operands]
        return self._add(partial(make, self._next_index(), *functions), *operands)

    def _add(self, make: Callable[[], Operator], *operands: PastFormula) -> str:
        """The output of a new operator over the run, which has to be stepped when its operands can change."""
        index = self._next_index()
        self.run_operators.append(make)
        self.run_sources.extend(map(sources, operands))
        return f"o[{index}]"

    def _next_index(self) -> int:
        return len(self.run_operators) + len(self.trigger_operators)

    # --- comparisons

    def _comparison_text(self, formula: Comparison | TextComparison, shift: str = "") -> str:
        compared = f"{self._term(formula.left)} {formula.relation} {self._term(formula.right)}{shift}"
        return f"({' and '.join([*self._guards(formula), compared])})"

    def _both_bounds(self, formula: Comparison) -> tuple[Condition, Condition]:
        """The comparison with its own bound, and with the bound shifted by the hysteresis."""
        sign = "-" if formula.relation in ("<", "<=") else "+"
        shifted = self._comparison_text(formula, f" {sign} {formula.hysteresis!r}")
        return function_of(self._comparison_text(formula)), function_of(shifted)

    def _distance(self, formula: Comparison) -> str:
        """Positive inside the bound, in the unit of the terms; 0 at the bound, for `<` and for `<=`."""
        left, right = self._term(formula.left), self._term(formula.right)
        gap = f"{right} - {left}" if formula.relation in ("<", "<=") else f"{left} - {right}"
        distance = {"==": f"-abs({gap})", "!=": f"abs({gap})"}.get(formula.relation, gap)
        guard = " and ".join(self._guards(formula))
        return f"({distance} if {guard} else -INFINITY)" if guard else f"({distance})"

    def _term(self, term: Term | TextTerm) -> str:
        match term:
            case Number() | Text():
                return repr(term.value)
            case FloatName() | TextName():
                return f"v[{term.name!r}]"
            case Negative():
                return f"(-{self._term(term.operand)})"
            case Arithmetic():
                return f"finite({self._term(term.left)} {term.operator} {self._term(term.right)})"
            case Count() | TimeBetween():
                return self._stateful(term)
            case TimeSince():
                raise TypeError(f"{term} is the left side of a comparison with a number, and nothing else")

    def _guards(self, formula: Comparison | TextComparison) -> list[str]:
        """Whether there is what a comparison reads. A comparison with what is not there yet is false."""
        parts = (*leaves(formula.left), *leaves(formula.right))
        names = [f"{name!r} in v" for name, kind in names_compared(formula).items() if is_optional(name, kind)]
        return names + [f"{self._stateful(part)} is not None" for part in parts if isinstance(part, TimeBetween)]
