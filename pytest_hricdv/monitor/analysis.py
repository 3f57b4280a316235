"""Static analysis of formulas: their parts, the signals and messages that they read, the limits that reports show.

Compilation and monitors ask which names a formula reads, reports for `names_shown` and `limits`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.monitor.compiler import ExpressionCompiler, function_of
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.node import Kind, PastFormula, Term, field_of, last_of
from pytest_hricdv.monitor.past_formula import FLIPPED, Conjunction, Disjunction, NumberComparison, On, Relation
from pytest_hricdv.monitor.terms import FloatName


@dataclass(frozen=True)
class Limit:
    """A number that a signal or field is compared with.

    Attributes:
        name: the signal's name, or `topic.field`.
        relation: the relation of its value, on the left, to the limit.
        value: the value of the limit, in the unit of the name.
    """

    name: str
    relation: Relation
    value: float


def walk(formula: PastFormula) -> Iterator[PastFormula]:
    """`formula` and all formulas inside it, in the order of the text."""
    yield formula
    for child in formula.children:
        yield from walk(child)


def conjuncts(formula: PastFormula) -> Iterator[PastFormula]:
    """The operands of the outermost conjunctions of `formula`, in the order of the text."""
    yield from _operands_of(Conjunction, formula)


def disjuncts(formula: PastFormula) -> Iterator[PastFormula]:
    """The operands of the outermost disjunctions of `formula`, in the order of the text."""
    yield from _operands_of(Disjunction, formula)


def _operands_of(connective: type[Conjunction] | type[Disjunction], formula: PastFormula) -> Iterator[PastFormula]:
    if isinstance(formula, connective):
        for operand in formula.operands:
            yield from _operands_of(connective, operand)
    else:
        yield formula


def names_of(parts: Iterable[PastFormula]) -> dict[str, Kind]:
    """Name -> type of all signals and fields that the formulas read, in the order of the text."""
    kinds: dict[str, Kind] = {}
    for part in parts:
        for node in walk(part):
            kinds.update(node.own_names)
    return kinds


def names_read(formula: Formula) -> dict[str, Kind]:
    """Name -> type of all signals and fields that a requirement reads, in the order of the text."""
    return names_of(formula.conditions)


def topics_of(parts: Sequence[PastFormula]) -> frozenset[str]:
    """The topics whose messages the formulas read, by `on(topic)` or by a field."""
    arrivals = {node.topic for part in parts for node in walk(part) if isinstance(node, On)}
    return frozenset(arrivals | {field_of(name).partition(".")[0] for name in names_of(parts) if "." in name})


def topics_read(formula: Formula) -> frozenset[str]:
    """The topics whose messages a requirement reads."""
    return topics_of(formula.conditions)


def fields_read(kinds: Mapping[str, Kind], topic: str) -> dict[str, bool]:
    """The fields of a topic among names, as `topic.field` -> whether its value in the message before is read."""
    fields = [field_of(name) for name in kinds if field_of(name).startswith(f"{topic}.")]
    return {field: last_of(field) in kinds for field in fields}


def names_shown(formula: Formula) -> tuple[str, ...]:
    """Signals, `topic.field` and topics that a formula reads, each once, in the order of the text."""
    names: dict[str, None] = {}
    for part in _parts(formula):
        read = [part.topic] if isinstance(part, On) else map(_name_shown, part.own_names)
        names.update(dict.fromkeys(read))
    return tuple(names)


def limits(formula: Formula) -> tuple[Limit, ...]:
    """The limits in a formula, each once, in the order of the text; computed terms have none that could be drawn."""
    comparisons = [part for part in _parts(formula) if isinstance(part, NumberComparison)]
    return tuple(dict.fromkeys(limit for part in comparisons if (limit := _limit(part)) is not None))


def _parts(formula: Formula) -> Iterator[PastFormula]:
    for condition in formula.conditions:
        yield from walk(condition)


def _limit(comparison: NumberComparison) -> Limit | None:
    left, right = comparison.left, comparison.right
    if isinstance(left, FloatName) and (value := _constant(right)) is not None:
        return Limit(_name_shown(left.name), comparison.relation, value)
    if isinstance(right, FloatName) and (value := _constant(left)) is not None:
        return Limit(_name_shown(right.name), FLIPPED[comparison.relation], value)
    return None


def _name_shown(name: str) -> str:
    """A signal, or `topic.field`, also of its value in the message before."""
    return field_of(name) or name


def _constant(term: Term) -> float | None:
    """The value of a term that reads nothing; None for others, and for what has no value."""
    try:
        return float(function_of(term.expression(ExpressionCompiler()))({}, {}, {}))
    except (LookupError, ArithmeticError, TypeError):
        return None
