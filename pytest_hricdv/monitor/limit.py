"""Limits: what a formula reads, and the constants that it compares single numbers with, for pictures of runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.monitor.analysis import conditions, names_compared, walk
from pytest_hricdv.monitor.formula import (
    Arithmetic,
    BooleanName,
    Comparison,
    FloatName,
    Formula,
    Negative,
    Number,
    On,
    PastFormula,
    Relation,
    Term,
    TextComparison,
)
from pytest_hricdv.monitor.vocabulary import field_of

_TURNED: dict[Relation, Relation] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


@dataclass(frozen=True)
class Limit:
    """A number that a signal or field is compared with.

    Attributes:
        name: of the signal, or `topic.field`.
        relation: of its value, on the left, to the limit.
        value: of the limit, in the unit of the name.
    """

    name: str
    relation: Relation
    value: float


def names_read(formula: Formula) -> tuple[str, ...]:
    """Signals, `topic.field` and topics that a formula reads, each once, in the order of the text."""
    names: dict[str, None] = {}
    for part in _parts(formula):
        match part:
            case BooleanName():
                names[_name(part.name)] = None
            case On():
                names[part.topic] = None
            case Comparison() | TextComparison():
                names.update(dict.fromkeys(map(_name, names_compared(part))))
            case _:
                pass
    return tuple(names)


def limits(formula: Formula) -> tuple[Limit, ...]:
    """The limits in a formula, each once, in the order of the text; computed terms have none that could be drawn."""
    drawable: dict[Limit, None] = {}
    for part in _parts(formula):
        if isinstance(part, Comparison) and (limit := _limit(part)) is not None:
            drawable[limit] = None
    return tuple(drawable)


def _parts(formula: Formula) -> Iterator[PastFormula]:
    for condition in (formula.antecedent, *conditions(formula.response)):
        yield from walk(condition)


def _limit(comparison: Comparison) -> Limit | None:
    left, right = comparison.left, comparison.right
    if isinstance(left, FloatName) and (value := _constant(right)) is not None:
        return Limit(_name(left.name), comparison.relation, value)
    if isinstance(right, FloatName) and (value := _constant(left)) is not None:
        return Limit(_name(right.name), _TURNED[comparison.relation], value)
    return None


def _name(name: str) -> str:
    """A signal, or `topic.field`, also of its value in the message before."""
    return field_of(name) or name


def _constant(term: Term) -> float | None:
    """The value of a term that reads nothing; None for others, and for what cannot be divided."""
    match term:
        case Number():
            return term.value
        case Negative():
            value = _constant(term.operand)
            return None if value is None else -value
        case Arithmetic():
            left, right = _constant(term.left), _constant(term.right)
            return None if left is None or right is None else _computed(term.operator, left, right)
        case _:
            return None


def _computed(operator: str, left: float, right: float) -> float | None:
    match operator:
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
        case _:
            return left / right if right else None
