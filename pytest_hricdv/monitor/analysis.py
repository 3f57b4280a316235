"""What can be said about a formula without running it: what it reads, and when its value can change.

Monitors are evaluated only when something changes that can change their formula; this is where that is decided.
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
    Negative,
    Number,
    On,
    Or,
    Past,
    Previously,
    Response,
    Rise,
    Since,
    Term,
)


def source_of(name: str) -> str:
    """The source by whose updates `name` (a signal, or `topic.field`) changes."""
    topic, dot, _ = name.partition(".")
    return f"on({topic})" if dot else name


def children(formula: Past) -> tuple[Past, ...]:
    """The formulas directly inside `formula`."""
    match formula:
        case BooleanName() | On() | Comparison():
            return ()
        case And() | Or() | Since():
            return (formula.left, formula.right)
        case _:
            return (formula.operand,)


def walk(formula: Past) -> Iterator[Past]:
    """`formula` and all formulas inside it, in the order in which they are written."""
    yield formula
    for child in children(formula):
        yield from walk(child)


def conjuncts(formula: Past) -> Iterator[Past]:
    """The parts of `formula` that all have to be true for it to be true, in the order in which they are written."""
    if isinstance(formula, And):
        yield from conjuncts(formula.left)
        yield from conjuncts(formula.right)
    else:
        yield formula


def conditions(response: Response) -> tuple[Past, ...]:
    """The past formulas of a response."""
    release = getattr(response, "release", None)
    return (response.condition,) if release is None else (response.condition, release)


def term_names(term: Term) -> Iterator[FloatName]:
    """The signals and fields that a term reads."""
    match term:
        case FloatName():
            yield term
        case Negative():
            yield from term_names(term.operand)
        case Arithmetic():
            yield from term_names(term.left)
            yield from term_names(term.right)
        case Number():
            return


def names_of(parts: Iterable[Past]) -> dict[str, type[bool] | type[float]]:
    """Name -> type of all signals and fields that some formulas read, in the order in which they are written."""
    kinds: dict[str, type[bool] | type[float]] = {}
    for part in parts:
        for node in walk(part):
            match node:
                case BooleanName():
                    kinds[node.name] = bool
                case Comparison():
                    kinds.update((atom.name, float) for term in (node.left, node.right) for atom in term_names(term))
                case _:
                    pass
    return kinds


def names_read(formula: Formula) -> dict[str, type[bool] | type[float]]:
    """Name -> type of all signals and fields that a requirement reads, in the order in which they are written."""
    return names_of((formula.antecedent, *conditions(formula.response)))


def topics_of(parts: Sequence[Past]) -> frozenset[str]:
    """The topics whose messages some formulas need: named by `on(topic)` or by a field."""
    arrivals = {node.topic for part in parts for node in walk(part) if isinstance(node, On)}
    return frozenset(arrivals | {name.partition(".")[0] for name in names_of(parts) if "." in name})


def topics_read(formula: Formula) -> frozenset[str]:
    """The topics whose messages a requirement needs."""
    return topics_of((formula.antecedent, *conditions(formula.response)))


def is_instantaneous(formula: Past) -> bool:
    """Whether `formula` can be true at isolated instants only, never for any length of time."""
    match formula:
        case On() | Rise() | Fall():
            return True
        case And():
            return is_instantaneous(formula.left) or is_instantaneous(formula.right)
        case Or():
            return is_instantaneous(formula.left) and is_instantaneous(formula.right)
        case _:
            return False


def is_lasting(formula: Past) -> bool:
    """Whether the value at an instant is also the value right after it, so that the instant alone need be looked at.

    Signals are so, and what is made from them. Messages, edges and `previously` single out an instant.
    """
    return not any(isinstance(node, On | Rise | Fall | Previously) for node in walk(formula))


def sources(formula: Past) -> frozenset[str]:
    """The sources whose updates can change the value of `formula`.

    A conjunction with a part that is true at instants only can be true at those instants only, so the other part need
    not be followed: `fall(leg_held) & leg_offset < 0.15` is looked at when `leg_held` changes, however often
    `leg_offset` does. (The formulas inside past operators are followed for themselves; see `compile`.)
    """
    match formula:
        case BooleanName():
            return frozenset((source_of(formula.name),))
        case On():
            return frozenset((f"on({formula.topic})",))
        case Comparison():
            terms = (formula.left, formula.right)
            return frozenset(source_of(atom.name) for term in terms for atom in term_names(term))
        case And() if is_instantaneous(formula.left):
            return sources(formula.left)
        case And() if is_instantaneous(formula.right):
            return sources(formula.right)
        case _:
            return frozenset().union(*map(sources, children(formula)))
