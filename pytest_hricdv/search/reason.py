"""Why a requirement failed: which part of its condition was violated, so that two failures can be told apart."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping

from pytest_hricdv.monitor import Requirement, Verdict, Violation
from pytest_hricdv.monitor.analysis import conjuncts
from pytest_hricdv.monitor.formula import (
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Eventually,
    FloatName,
    Negative,
    Not,
    Number,
    Or,
    PastFormula,
    Term,
)

_RELATIONS: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
_ARITHMETIC: Mapping[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}

#: The texts of the conjuncts that were false.
Reason = tuple[str, ...]


def reason(requirement: Requirement, violation: Violation) -> Reason:
    """The conjuncts of the requirement's condition that were false when it was violated.

    They are told by the violation's values, so one that depends on more than these (on an event, on the past) counts
    as false only where no other was. A deadline is missed as a whole.
    """
    response = requirement.formula.response
    parts = tuple(conjuncts(response.condition))
    if isinstance(response, Eventually):
        return tuple(str(part) for part in parts)
    told = [_truth(part, violation.values) for part in parts]
    wrong = tuple(str(part) for part, true in zip(parts, told, strict=True) if true is False)
    return wrong or tuple(str(part) for part, true in zip(parts, told, strict=True) if true is None)


def is_same(requirement: Requirement, wanted: Reason, verdict: Verdict) -> bool:
    """Whether the verdict is a failure with at least one violation for the wanted reason."""
    return verdict.verdict == "Failed" and any(reason(requirement, each) == wanted for each in verdict.violations)


def _truth(formula: PastFormula, values: Mapping[str, float | bool]) -> bool | None:
    """Whether it holds; None where the values alone do not say."""
    match formula:
        case BooleanName():
            value = values.get(formula.name)
            return None if value is None else bool(value)
        case Comparison(for_s=0):
            left, right = _number(formula.left, values), _number(formula.right, values)
            return None if left is None or right is None else _RELATIONS[formula.relation](left, right)
        case Not():
            inner = _truth(formula.operand, values)
            return None if inner is None else not inner
        case And() | Or():
            sides = (_truth(formula.left, values), _truth(formula.right, values))
            decisive = isinstance(formula, Or)
            return decisive if decisive in sides else None if None in sides else not decisive
        case _:
            return None


def _number(term: Term, values: Mapping[str, float | bool]) -> float | None:
    match term:
        case Number():
            return term.value
        case FloatName():
            return values.get(term.name)
        case Negative():
            inner = _number(term.operand, values)
            return None if inner is None else -inner
        case Arithmetic():
            left, right = _number(term.left, values), _number(term.right, values)
            if left is None or right is None or (term.operator == "/" and right == 0):
                return None
            return _ARITHMETIC[term.operator](left, right)
