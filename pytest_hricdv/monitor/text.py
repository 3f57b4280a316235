"""Formula to text: what the parser would read as the same formula, with no more parentheses than it needs."""

from __future__ import annotations

import math
from enum import IntEnum

from pytest_hricdv.monitor.formula import (
    AlwaysWithin,
    And,
    Arithmetic,
    BooleanName,
    Comparison,
    Eventually,
    Fall,
    FloatName,
    Formula,
    Historically,
    Holds,
    HoldsUntil,
    Negative,
    Node,
    Not,
    Number,
    On,
    Once,
    Or,
    Past,
    Previously,
    Rise,
    Since,
    Term,
)


class Strength(IntEnum):
    """How strongly the outermost sign of a text binds, from weak to strong: what needs parentheses inside of what."""

    SINCE = 0
    OR = 1
    AND = 2
    NOT = 3
    COMPARISON = 4
    SUM = 5
    PRODUCT = 6
    UNARY = 7
    ATOM = 8


def text_of(node: Node) -> str:
    """The text of a formula or of a part of it.

    >>> text_of(And(Or(BooleanName("p"), BooleanName("q")), Comparison("<", FloatName("x"), Number(1.0), for_s=2.5)))
    '(p | q) & x < 1 [for 2.5]'
    """
    match node:
        case Formula():
            return f"always({text_of(node.antecedent)} -> {text_of(node.response)})"
        case Holds():
            return text_of(node.condition)
        case Eventually():
            return f"eventually{_window(node.start_s, node.end_s)}({text_of(node.condition)})"
        case AlwaysWithin():
            return f"always{_window(node.start_s, node.end_s)}({text_of(node.condition)})"
        case HoldsUntil():
            return f"always({text_of(node.condition)}) until {text_of(node.release)}"
        case Number() | FloatName() | Negative() | Arithmetic():
            return _term(node)[1]
        case _:
            assert isinstance(node, Past), node
            return _past(node)[1]


def _past(formula: Past) -> tuple[Strength, str]:
    match formula:
        case BooleanName():
            return Strength.ATOM, formula.name
        case On():
            return Strength.ATOM, f"on({formula.topic})"
        case Comparison():
            return Strength.COMPARISON, _comparison(formula)
        case Not():
            return Strength.NOT, f"!{_within(formula.operand, Strength.ATOM)}"
        case And():
            left, right = _within(formula.left, Strength.AND), _within(formula.right, Strength.NOT)
            return Strength.AND, f"{left} & {right}"
        case Or():
            left, right = _within(formula.left, Strength.OR), _within(formula.right, Strength.AND)
            return Strength.OR, f"{left} | {right}"
        case Since():
            left, right = _within(formula.left, Strength.OR), _within(formula.right, Strength.OR)
            return Strength.SINCE, f"{left} since {right}"
        case Rise() | Fall() | Previously():
            return Strength.ATOM, f"{type(formula).__name__.lower()}({text_of(formula.operand)})"
        case Once() | Historically():
            ever = (formula.start_s, formula.end_s) == (0, math.inf)
            window = "" if ever else _window(formula.start_s, formula.end_s)
            return Strength.ATOM, f"{type(formula).__name__.lower()}{window}({text_of(formula.operand)})"


def _comparison(formula: Comparison) -> str:
    left, right = _within(formula.left, Strength.SUM), _within(formula.right, Strength.SUM)
    hysteresis = f" [hysteresis {_number(formula.hysteresis)}]" if formula.hysteresis else ""
    duration = f" [for {_number(formula.for_s)}]" if formula.for_s else ""
    return f"{left} {formula.relation} {right}{hysteresis}{duration}"


def _term(term: Term) -> tuple[Strength, str]:
    match term:
        case Number():
            return Strength.ATOM, _number(term.value)
        case FloatName():
            return Strength.ATOM, term.name
        case Negative():
            return Strength.UNARY, f"-{_within(term.operand, Strength.ATOM)}"
        case Arithmetic():
            strength = Strength.SUM if term.operator in "+-" else Strength.PRODUCT
            # Equal signs are read from left to right, so on the right side one needs its parentheses.
            left, right = _within(term.left, strength), _within(term.right, Strength(strength + 1))
            return strength, f"{left} {term.operator} {right}"


def _within(node: Past | Term, least: Strength) -> str:
    strength, text = _term(node) if isinstance(node, Term) else _past(node)
    return text if strength >= least else f"({text})"


def _window(start_s: float, end_s: float) -> str:
    return f"[{_number(start_s)}:{_number(end_s)}]"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
