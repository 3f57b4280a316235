"""Static analysis of formulas: what a formula reads, and when its value can change.

A monitor is evaluated only when an update can change the value of its formula; `sources` decides which updates can.
A *source* is what is fed: the name of a signal, or `on(topic)` for a topic (its fields change only with a message).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pytest_hricdv.monitor.formula import (
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Count,
    Fall,
    FloatName,
    Formula,
    HoldsUntil,
    Negative,
    Number,
    On,
    Or,
    PastFormula,
    Previously,
    Response,
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
from pytest_hricdv.monitor.vocabulary import Kind, field_of, last_of

Leaf = Number | FloatName | Count | TimeSince | TimeBetween | Text | TextName


def source_of(name: str) -> str:
    """The source whose updates change `name` (a signal, a field, or its value in the message before)."""
    topic, dot, _ = field_of(name).partition(".")
    return f"on({topic})" if dot else name


def children(formula: PastFormula) -> tuple[PastFormula, ...]:
    """The formulas directly inside `formula`."""
    match formula:
        case BooleanName() | On():
            return ()
        case Comparison() | TextComparison():
            return tuple(operand for part in _parts(formula) for operand in _operands(part))
        case And() | Or():
            return formula.operands
        case Since():
            return (formula.left, formula.right)
        case _:
            return (formula.operand,)


def _operands(leaf: Leaf) -> tuple[PastFormula, ...]:
    match leaf:
        case Count() | TimeSince():
            return (leaf.operand,)
        case TimeBetween():
            return (leaf.begin, leaf.end)
        case _:
            return ()


def walk(formula: PastFormula) -> Iterator[PastFormula]:
    """`formula` and all formulas inside it, in the order of the text."""
    yield formula
    for child in children(formula):
        yield from walk(child)


def conjuncts(formula: PastFormula) -> Iterator[PastFormula]:
    """The operands of the outermost conjunctions of `formula`, in the order of the text."""
    yield from _operands_of(And, formula)


def disjuncts(formula: PastFormula) -> Iterator[PastFormula]:
    """The operands of the outermost disjunctions of `formula`, in the order of the text."""
    yield from _operands_of(Or, formula)


def _operands_of(connective: type[And] | type[Or], formula: PastFormula) -> Iterator[PastFormula]:
    if isinstance(formula, connective):
        for operand in formula.operands:
            yield from _operands_of(connective, operand)
    else:
        yield formula


def conditions(response: Response) -> tuple[PastFormula, ...]:
    """The past formulas of a response."""
    return (response.condition, response.release) if isinstance(response, HoldsUntil) else (response.condition,)


def leaves(term: Term | TextTerm) -> Iterator[Leaf]:
    """What a term computes with, in the order of the text."""
    match term:
        case Negative():
            yield from leaves(term.operand)
        case Arithmetic():
            yield from leaves(term.left)
            yield from leaves(term.right)
        case _:
            yield term


def names_compared(comparison: Comparison | TextComparison) -> Mapping[str, Kind]:
    """Name -> type of the signals and fields that a comparison reads by itself, not inside `count` or a time."""
    names = [part for part in _parts(comparison) if isinstance(part, FloatName | TextName)]
    return {part.name: str if isinstance(part, TextName) else float for part in names}


def _parts(comparison: Comparison | TextComparison) -> Iterator[Leaf]:
    yield from leaves(comparison.left)
    yield from leaves(comparison.right)


def names_of(parts: Iterable[PastFormula]) -> dict[str, Kind]:
    """Name -> type of all signals and fields that the formulas read, in the order of the text."""
    kinds: dict[str, Kind] = {}
    for part in parts:
        for node in walk(part):
            match node:
                case BooleanName():
                    kinds[node.name] = bool
                case Comparison() | TextComparison():
                    kinds.update(names_compared(node))
                case _:
                    pass
    return kinds


def names_read(formula: Formula) -> dict[str, Kind]:
    """Name -> type of all signals and fields that a requirement reads, in the order of the text."""
    return names_of((formula.antecedent, *conditions(formula.response)))


def topics_of(parts: Sequence[PastFormula]) -> frozenset[str]:
    """The topics whose messages the formulas read, by `on(topic)` or by a field."""
    arrivals = {node.topic for part in parts for node in walk(part) if isinstance(node, On)}
    return frozenset(arrivals | {field_of(name).partition(".")[0] for name in names_of(parts) if "." in name})


def fields_read(kinds: Mapping[str, Kind], topic: str) -> dict[str, bool]:
    """The fields of a topic among names, as `topic.field` -> whether its value in the message before is read."""
    fields = [field_of(name) for name in kinds if field_of(name).startswith(f"{topic}.")]
    return {field: last_of(field) in kinds for field in fields}


def topics_read(formula: Formula) -> frozenset[str]:
    """The topics whose messages a requirement reads."""
    return topics_of((formula.antecedent, *conditions(formula.response)))


def is_instantaneous(formula: PastFormula) -> bool:
    """Whether `formula` can be true only at isolated instants, never for a length of time."""
    match formula:
        case On() | Rise() | Fall():
            return True
        case And():
            return any(map(is_instantaneous, formula.operands))
        case Or():
            return all(map(is_instantaneous, formula.operands))
        case _:
            return False


def is_right_continuous(formula: PastFormula) -> bool:
    """Whether the value at each instant is also the value right after it, so that only instants need evaluation.

    Signals and formulas over signals are. Messages, edges and `previously` differ at single instants.
    """
    match formula:
        case On() | Rise() | Fall() | Previously():
            return False
        case Comparison(left=TimeSince()):
            # `time_since(f) <= d` becomes false right after d, `time_since(f) < d` at d.
            return formula.relation in ("<", ">=") and all(map(is_right_continuous, children(formula)))
        case Comparison():
            # A count in a window of the past changes right after its end.
            windows = (part.end_s for part in _parts(formula) if isinstance(part, Count))
            return all(map(math.isinf, windows))
        case _:
            return all(map(is_right_continuous, children(formula)))


def sources(formula: PastFormula) -> frozenset[str]:
    """The sources whose updates can change the value of `formula`.

    A conjunction with an operand that is true only at isolated instants can be true only at these instants, so updates
    of the other operand alone do not matter: `fall(leg_held) & leg_offset < 0.15` is evaluated when `leg_held` changes,
    however often `leg_offset` does. (The operands of past operators have sources of their own; see `compiler`.)
    """
    match formula:
        case BooleanName():
            return frozenset((source_of(formula.name),))
        case On():
            return frozenset((f"on({formula.topic})",))
        case Comparison() | TextComparison():
            names = frozenset(map(source_of, names_compared(formula)))
            return names.union(*map(sources, children(formula)))
        case And() if is_instantaneous(formula):
            # Any instantaneous operand will do; the first is often a message, which comes more rarely than a signal.
            return sources(next(filter(is_instantaneous, formula.operands)))
        case _:
            return frozenset().union(*map(sources, children(formula)))
