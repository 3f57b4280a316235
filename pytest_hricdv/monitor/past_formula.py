"""Past formulas as data: conditions that are true or false at each time, decided by the run up to that time.

A formula is about a run in dense time: signals are constant between updates, and a message exists for one instant.
Nodes are frozen dataclasses that compare by value, so equal requirements share one compiled program. `str(node)` is its
text in the requirement language, which is parsed to an equal node. Times are in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self

from pytest_hricdv.monitor.node import Node, Precedence, number_text, window_text

ArithmeticOperator = Literal["+", "-", "*", "/"]
Relation = Literal["<", "<=", ">", ">=", "==", "!="]
Equality = Literal["==", "!="]


def _duration(for_s: float) -> str:
    return f" [for {number_text(for_s)}]" if for_s else ""


def _window_of_past(start_s: float, end_s: float) -> str:
    return "" if (start_s, end_s) == (0, math.inf) else window_text(start_s, end_s)


# --- terms: a number at each time


@dataclass(frozen=True)
class Number(Node):
    value: float

    def __str__(self) -> str:
        return number_text(self.value)


@dataclass(frozen=True)
class FloatName(Node):
    """A float signal, `topic.field`, the last value of a float field, or `last(topic.field)`, the one before it."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Negative(Node):
    PRECEDENCE = Precedence.UNARY
    operand: Term

    def __str__(self) -> str:
        return f"-{self.operand.operand_text(Precedence.ATOM)}"


@dataclass(frozen=True)
class Arithmetic(Node):
    operator: ArithmeticOperator
    left: Term
    right: Term

    @property
    def precedence(self) -> Precedence:
        return Precedence.SUM if self.operator in "+-" else Precedence.PRODUCT

    def __str__(self) -> str:
        # Operators of one precedence group from the left, so an equal one on the right side needs parentheses. Sums of
        # floats are not associative: leaving them out would make another formula.
        left = self.left.operand_text(self.precedence)
        return f"{left} {self.operator} {self.right.operand_text(Precedence(self.precedence + 1))}"


@dataclass(frozen=True)
class Count(Node):
    """How often the operand became true at times in [t - end_s, t - start_s], within the run, as `rise(operand)` does.

    `count(on(topic))` counts messages: two at one instant are two.
    """

    operand: PastFormula
    start_s: float = 0.0
    end_s: float = math.inf

    def __str__(self) -> str:
        return f"count{_window_of_past(self.start_s, self.end_s)}({self.operand})"


@dataclass(frozen=True)
class TimeSince(Node):
    """The time (s) since the operand was last true: 0 while it is, infinite before it ever was.

    It changes all the time, so it is only the left side of a comparison with a number.
    """

    operand: PastFormula

    def __str__(self) -> str:
        return f"time_since({self.operand})"


@dataclass(frozen=True)
class TimeBetween(Node):
    """The time (s) from when `begin` last became true to when `end` last became true, as `rise` does.

    It has a value once `end` has become true at or after `begin`, and keeps it until `end` becomes true again.
    """

    begin: PastFormula
    end: PastFormula

    def __str__(self) -> str:
        return f"time_between({self.begin}, {self.end})"


Term = Number | FloatName | Negative | Arithmetic | Count | TimeSince | TimeBetween


# --- texts: a string at each time


@dataclass(frozen=True)
class Text(Node):
    """A string. It has at most one kind of quotation mark, as there are no escapes."""

    value: str

    def __str__(self) -> str:
        return f"'{self.value}'" if '"' in self.value else f'"{self.value}"'


@dataclass(frozen=True)
class TextName(Node):
    """A signal, `topic.field` or `last(topic.field)`, whose values are strings."""

    name: str

    def __str__(self) -> str:
        return self.name


TextTerm = Text | TextName


# --- past formulas: true or false at each time, decided by the run up to that time


@dataclass(frozen=True)
class BooleanName(Node):
    """A boolean signal, `topic.field`, the last value of a boolean field, or `last(topic.field)`, the one before it."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class On(Node):
    """True only at an instant at which a message of the topic arrives."""

    topic: str

    def __str__(self) -> str:
        return f"on({self.topic})"


@dataclass(frozen=True)
class Comparison(Node):
    """`left relation right [hysteresis h] [for d]`.

    With a hysteresis, a comparison that became false is true again only when it passes the bound by `hysteresis` (same
    unit as the terms). With `for_s`, it is true once the comparison has held for that long without a break.
    """

    PRECEDENCE = Precedence.COMPARISON
    relation: Relation
    left: Term
    right: Term
    hysteresis: float = 0.0
    for_s: float = 0.0

    def __str__(self) -> str:
        left, right = self.left.operand_text(Precedence.SUM), self.right.operand_text(Precedence.SUM)
        hysteresis = f" [hysteresis {number_text(self.hysteresis)}]" if self.hysteresis else ""
        return f"{left} {self.relation} {right}{hysteresis}{_duration(self.for_s)}"


@dataclass(frozen=True)
class TextComparison(Node):
    """`left == right [for d]` or `left != right [for d]`, of strings."""

    PRECEDENCE = Precedence.COMPARISON
    relation: Equality
    left: TextTerm
    right: TextTerm
    for_s: float = 0.0

    def __str__(self) -> str:
        return f"{self.left} {self.relation} {self.right}{_duration(self.for_s)}"


@dataclass(frozen=True)
class Not(Node):
    PRECEDENCE = Precedence.NOT
    operand: PastFormula

    def __str__(self) -> str:
        return f"!{self.operand.operand_text(Precedence.ATOM)}"


@dataclass(frozen=True, init=False)
class _Connective(Node):
    """A connective of two or more operands: a long one does not nest."""

    SYMBOL: ClassVar[str]
    operands: tuple[PastFormula, ...]

    def __init__(self, *operands: PastFormula) -> None:
        object.__setattr__(self, "operands", operands)

    def __str__(self) -> str:
        within = Precedence(self.PRECEDENCE + 1)
        return f" {self.SYMBOL} ".join(operand.operand_text(within) for operand in self.operands)

    def changed(self, change: Callable[[Any], Any]) -> Self:
        return type(self)(*map(change, self.operands))


class And(_Connective):
    PRECEDENCE, SYMBOL = Precedence.AND, "&"


class Or(_Connective):
    PRECEDENCE, SYMBOL = Precedence.OR, "|"


@dataclass(frozen=True)
class _NamedOperator(Node):
    """An operator that is written as its lower-case class name, with one operand."""

    operand: PastFormula

    def __str__(self) -> str:
        return f"{type(self).__name__.lower()}({self.operand})"


class Rise(_NamedOperator):
    """True only at an instant at which the operand becomes true, at that instant or right after it."""


class Fall(_NamedOperator):
    """True only at an instant at which the operand becomes false, at that instant or right after it."""


class Previously(_NamedOperator):
    """The operand just before: the left limit, not the previous sample, so that the sampling rate does not matter."""


@dataclass(frozen=True)
class _WindowedOperator(_NamedOperator):
    """A named operator over a window of the past; without a window: over the whole past."""

    start_s: float = 0.0
    end_s: float = math.inf

    def __str__(self) -> str:
        return f"{type(self).__name__.lower()}{_window_of_past(self.start_s, self.end_s)}({self.operand})"


class Once(_WindowedOperator):
    """At time t: the operand was true at some time in [t - end_s, t - start_s], within the run."""


class Historically(_WindowedOperator):
    """At time t: the operand was true at all times in [t - end_s, t - start_s], within the run."""


@dataclass(frozen=True)
class Since(Node):
    """`right` was true at some time, and `left` has been true at all times after it, up to now.

    It is enough that `left` becomes true at the very time at which `right` becomes false.
    """

    PRECEDENCE = Precedence.SINCE
    left: PastFormula
    right: PastFormula

    def __str__(self) -> str:
        return f"{self.left.operand_text(Precedence.OR)} since {self.right.operand_text(Precedence.OR)}"


PastFormula = (
    BooleanName
    | On
    | Comparison
    | TextComparison
    | Not
    | And
    | Or
    | Rise
    | Fall
    | Once
    | Historically
    | Previously
    | Since
)
"""A formula about the present and the past: a condition, an antecedent, or what a response is made of."""
