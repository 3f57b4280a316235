"""Static analysis of formulas: what a formula reads, and when its value can change.

A monitor is evaluated only when an update can change the value of its formula; `sources` decides which updates can.
A *source* is what is fed: the name of a signal, or `on(topic)` for a topic (its fields change only with a message).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from pytest_hricdv.monitor.formula import (
    And,
    Arithmetic,
    BooleanName,
    Comparison,
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
)
from pytest_hricdv.monitor.vocabulary import Kind


def source_of(name: str) -> str:
    """The source whose updates change `name` (a signal, or `topic.field`)."""
    topic, dot, _ = name.partition(".")
    return f"on({topic})" if dot else name


def children(formula: PastFormula) -> tuple[PastFormula, ...]:
    """The formulas directly inside `formula`."""
    match formula:
        case BooleanName() | On() | Comparison() | TextComparison():
            return ()
        case And() | Or() | Since():
            return (formula.left, formula.right)
        case _:
            return (formula.operand,)


def walk(formula: PastFormula) -> Iterator[PastFormula]:
    """`formula` and all formulas inside it, in the order of the text."""
    yield formula
    for child in children(formula):
        yield from walk(child)


def conjuncts(formula: PastFormula) -> Iterator[PastFormula]:
    """The operands of the outermost conjunctions of `formula`, in the order of the text."""
    if isinstance(formula, And):
        yield from conjuncts(formula.left)
        yield from conjuncts(formula.right)
    else:
        yield formula


def conditions(response: Response) -> tuple[PastFormula, ...]:
    """The past formulas of a response."""
    return (response.condition, response.release) if isinstance(response, HoldsUntil) else (response.condition,)


def term_names(term: Term | TextTerm) -> Iterator[FloatName | TextName]:
    """The signals and fields that a term reads."""
    match term:
        case FloatName() | TextName():
            yield term
        case Negative():
            yield from term_names(term.operand)
        case Arithmetic():
            yield from term_names(term.left)
            yield from term_names(term.right)
        case Number() | Text():
            return


def names_compared(comparison: Comparison | TextComparison) -> Iterator[FloatName | TextName]:
    """The signals and fields that both sides of a comparison read."""
    yield from term_names(comparison.left)
    yield from term_names(comparison.right)


def names_of(parts: Iterable[PastFormula]) -> dict[str, Kind]:
    """Name -> type of all signals and fields that the formulas read, in the order of the text."""
    kinds: dict[str, Kind] = {}
    for part in parts:
        for node in walk(part):
            match node:
                case BooleanName():
                    kinds[node.name] = bool
                case Comparison() | TextComparison():
                    names = names_compared(node)
                    kinds.update((each.name, str if isinstance(each, TextName) else float) for each in names)
                case _:
                    pass
    return kinds


def names_read(formula: Formula) -> dict[str, Kind]:
    """Name -> type of all signals and fields that a requirement reads, in the order of the text."""
    return names_of((formula.antecedent, *conditions(formula.response)))


def topics_of(parts: Sequence[PastFormula]) -> frozenset[str]:
    """The topics whose messages the formulas read, by `on(topic)` or by a field."""
    arrivals = {node.topic for part in parts for node in walk(part) if isinstance(node, On)}
    return frozenset(arrivals | {name.partition(".")[0] for name in names_of(parts) if "." in name})


def topics_read(formula: Formula) -> frozenset[str]:
    """The topics whose messages a requirement reads."""
    return topics_of((formula.antecedent, *conditions(formula.response)))


def is_instantaneous(formula: PastFormula) -> bool:
    """Whether `formula` can be true only at isolated instants, never for a length of time."""
    match formula:
        case On() | Rise() | Fall():
            return True
        case And():
            return is_instantaneous(formula.left) or is_instantaneous(formula.right)
        case Or():
            return is_instantaneous(formula.left) and is_instantaneous(formula.right)
        case _:
            return False


def is_right_continuous(formula: PastFormula) -> bool:
    """Whether the value at each instant is also the value right after it, so that only instants need evaluation.

    Signals and formulas over signals are. Messages, edges and `previously` differ at single instants.
    """
    return not any(isinstance(node, On | Rise | Fall | Previously) for node in walk(formula))


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
            return frozenset(source_of(each.name) for each in names_compared(formula))
        case And() if is_instantaneous(formula.left):
            return sources(formula.left)
        case And() if is_instantaneous(formula.right):
            return sources(formula.right)
        case _:
            return frozenset().union(*map(sources, children(formula)))
