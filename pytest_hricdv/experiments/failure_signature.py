"""Failure signatures: the conjuncts of a requirement that a violation made false.

Violations of a requirement with the same signature count as one failure. So shrinking keeps the signature
(`has_signature`), and the closing loop counts signatures (`failure_signature`).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping

from pytest_hricdv.monitor import Criterion, Requirement, Value, Verdict, Violation
from pytest_hricdv.monitor.analysis import conjuncts
from pytest_hricdv.monitor.formula import Eventually
from pytest_hricdv.monitor.node import PastFormula, Term, TextTerm
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Conjunction,
    Disjunction,
    Negation,
    NumberComparison,
    TextComparison,
)
from pytest_hricdv.monitor.terms import ArithmeticTerm, Count, FloatName, Negative, NumberTerm, Text, TimeBetween

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

FailureSignature = tuple[str, ...]
"""The texts of the conjuncts that were false."""


def failure_signature(requirement: Criterion, verdict: Verdict, violation: Violation) -> FailureSignature:
    """The conjuncts of the requirement's condition that were false when it was violated.

    They are evaluated on the values of the violation. A conjunct that depends on more (an event, or the past) counts as
    false only if no other one is. The signature of a missed deadline is the whole condition. A criterion that is no
    requirement puts a signature into its verdict.
    """
    if not isinstance(requirement, Requirement):
        return verdict.signature
    response = requirement.formula.response
    parts = tuple(conjuncts(response.condition))
    if isinstance(response, Eventually):
        return tuple(str(part) for part in parts)
    truths = [_evaluate(part, violation.values) for part in parts]
    false = tuple(str(part) for part, truth in zip(parts, truths, strict=True) if truth is False)
    return false or tuple(str(part) for part, truth in zip(parts, truths, strict=True) if truth is None)


def has_signature(
    requirement: Criterion, signature: FailureSignature, verdict: Verdict, *, outside: bool = False
) -> bool:
    """Whether the verdict is a failure with a violation of this signature that is, or is not, `Violation.outside`."""
    violations = (violation for violation in verdict.violations if violation.outside == outside)
    return verdict.verdict == "Failed" and any(
        failure_signature(requirement, verdict, violation) == signature for violation in violations
    )


def _evaluate(formula: PastFormula, values: Mapping[str, Value]) -> bool | None:
    """Whether the formula holds; None if the values alone do not determine it."""
    match formula:
        case BooleanName():
            value = values.get(formula.name)
            return None if value is None else bool(value)
        case NumberComparison(for_s=0):
            left, right = _number(formula.left, values), _number(formula.right, values)
            return None if left is None or right is None else _RELATIONS[formula.relation](left, right)
        case TextComparison(for_s=0):
            texts = _text(formula.left, values), _text(formula.right, values)
            return None not in texts and (texts[0] == texts[1]) == (formula.relation == "==")
        case Negation():
            inner = _evaluate(formula.operand, values)
            return None if inner is None else not inner
        case Conjunction() | Disjunction():
            sides = {_evaluate(operand, values) for operand in formula.operands}
            dominant = isinstance(formula, Disjunction)
            return dominant if dominant in sides else None if None in sides else not dominant
        case _:
            return None


def _number(term: Term, values: Mapping[str, Value]) -> float | None:
    match term:
        case NumberTerm():
            return term.value
        case FloatName():
            value = values.get(term.name)
            return None if value is None else float(value)
        case Count() | TimeBetween():
            value = values.get(str(term))
            return None if value is None else float(value)
        case Negative():
            inner = _number(term.operand, values)
            return None if inner is None else -inner
        case ArithmeticTerm():
            left, right = _number(term.left, values), _number(term.right, values)
            if left is None or right is None or (term.operator == "/" and right == 0):
                return None
            return _ARITHMETIC[term.operator](left, right)
        case _:
            return None  # violations have no values of time_since


def _text(term: TextTerm, values: Mapping[str, Value]) -> Value | None:
    return term.value if isinstance(term, Text) else values.get(str(term))
