"""Past formulas compiled to Python expressions, and the stateful operators that these expressions read.

A past formula, which depends only on the run so far, becomes a Python expression over `v` (values), `m` (topic ->
number of messages at this instant) and `o` (outputs of operators). What needs memory, such as `once`, becomes an
operator. It is stepped separately, and the expression reads its output. Each class of formulas and terms writes its
own expression with the methods of `ExpressionCompiler`; `program` assembles the program of a monitor from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from pytest_hricdv.monitor.evaluation_state import Condition
from pytest_hricdv.monitor.node import FormulaNode, HysteresisScope, PastFormula, Term, is_optional
from pytest_hricdv.monitor.number_operators import NumberOperator
from pytest_hricdv.monitor.operators import HysteresisOperator, Operator
from pytest_hricdv.monitor.past_formula import NumberComparison, On, Rise, TextComparison
from pytest_hricdv.monitor.terms import leaves


def function_of(expression: str) -> Callable[..., Any]:
    """An expression as a Python function of `v`, `m` and `o`."""
    # Safe to evaluate: the formulas write only checked names (as literals), numbers and operators.
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
    """Collects the operators of a formula; an expression reads the output of the one with the number n as `o[n]`.

    Attributes:
        run_operators, trigger_operators: constructors of operators, as in `RequirementProgram`.
        past_numbers: the text of each count, or time between two events -> the number of its operator.
        run_sources, trigger_sources: the sources whose updates can change the operands of these operators.
    """

    def __init__(self) -> None:
        self.run_operators: list[Callable[[], Operator]] = []
        self.trigger_operators: list[Callable[[], HysteresisOperator]] = []
        self.past_numbers: dict[str, int] = {}
        self.run_sources: list[frozenset[str]] = []
        self.trigger_sources: list[frozenset[str]] = []
        self._outputs: dict[FormulaNode, str] = {}  # equal subformulas share one operator

    def output(self, formula: PastFormula, make: Callable[..., Operator], *operands: PastFormula) -> str:
        """The output of an operator over conditions; `make` constructs it from its number and their functions."""
        if formula not in self._outputs:
            # Operands first: the operators in them have to be stepped before this one.
            functions = [function_of(operand.expression(self, HysteresisScope.RUN)) for operand in operands]
            self._outputs[formula] = self._add(partial(make, self._next_index(), *functions), *operands)
        return self._outputs[formula]

    def number_output(self, number: Term, make: Callable[..., NumberOperator], *operands: PastFormula) -> str:
        """The output of an operator over occurrences: messages, or instants at which an operand becomes true."""
        if number not in self._outputs:
            functions = [function_of(self._occurrences(operand)) for operand in operands]
            self.past_numbers[str(number)] = self._next_index()
            self._outputs[number] = self._add(partial(make, self._next_index(), *functions), *operands)
        return self._outputs[number]

    def _occurrences(self, operand: PastFormula) -> str:
        if isinstance(operand, On):
            return f"m.get({operand.topic!r}, 0)"
        return Rise(operand).expression(self, HysteresisScope.RUN)

    def comparison(self, formula: NumberComparison, scope: HysteresisScope) -> str:
        """A comparison of numbers without duration: its expression, or the output of its hysteresis."""
        if formula.hysteresis == 0 or scope is HysteresisScope.NEVER:
            return self.comparison_text(formula)
        if scope is HysteresisScope.RUN and formula in self._outputs:
            return self._outputs[formula]
        bounds = self._both_bounds(formula)
        make = partial(HysteresisOperator, self._next_index(), *bounds)
        if scope is HysteresisScope.RUN:
            self._outputs[formula] = self._add(make, formula)
            return self._outputs[formula]
        # Not shared with equal comparisons: it is reset at each trigger, which others must not notice.
        index = self._next_index()
        self.trigger_operators.append(make)
        self.trigger_sources.append(formula.sources)
        return f"o[{index}]"

    def comparison_text(self, formula: NumberComparison | TextComparison, shift: str = "") -> str:
        """The expression of a comparison, without memory; false where a value is missing."""
        left, right = formula.left.expression(self), formula.right.expression(self)
        return f"({' and '.join([*self._guards(formula), f'{left} {formula.relation} {right}{shift}'])})"

    def distance(self, formula: NumberComparison) -> str:
        """Positive inside the bound, in the unit of the terms; 0 at the bound, for `<` and for `<=`."""
        left, right = formula.left.expression(self), formula.right.expression(self)
        gap = f"{right} - {left}" if formula.relation in ("<", "<=") else f"{left} - {right}"
        distance = {"==": f"-abs({gap})", "!=": f"abs({gap})"}.get(formula.relation, gap)
        guard = " and ".join(self._guards(formula))
        return f"({distance} if {guard} else -INFINITY)" if guard else f"({distance})"

    def _both_bounds(self, formula: NumberComparison) -> tuple[Condition, Condition]:
        """The comparison with its own bound, and with the bound shifted by the hysteresis."""
        sign = "-" if formula.relation in ("<", "<=") else "+"
        shifted = self.comparison_text(formula, f" {sign} {formula.hysteresis!r}")
        return function_of(self.comparison_text(formula)), function_of(shifted)

    def _guards(self, formula: NumberComparison | TextComparison) -> list[str]:
        """Whether there is what a comparison reads. A comparison with what is not there yet is false."""
        names = [f"{name!r} in v" for name, kind in formula.own_names.items() if is_optional(name, kind)]
        terms = [term for side in (formula.left, formula.right) for term in leaves(side) if isinstance(term, Term)]
        return names + [f"{term.expression(self)} is not None" for term in terms if term.MAY_BE_MISSING]

    def _add(self, make: Callable[[], Operator], *operands: PastFormula) -> str:
        """The output of a new operator over the run, which has to be stepped when its operands can change."""
        index = self._next_index()
        self.run_operators.append(make)
        self.run_sources.extend(operand.sources for operand in operands)
        return f"o[{index}]"

    def _next_index(self) -> int:
        return len(self.run_operators) + len(self.trigger_operators)
