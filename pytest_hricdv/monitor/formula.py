"""The formula of a requirement as data: `always(antecedent -> response)`.

A formula is about a run in dense time: signals are constant between updates, and a message exists for one instant.
Nodes are frozen dataclasses that compare by value, so equal requirements share one compiled program. `str(node)` is its
text in the requirement language, which is parsed to an equal node. Times are in seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar, Literal

ArithmeticOperator = Literal["+", "-", "*", "/"]
Relation = Literal["<", "<=", ">", ">=", "==", "!="]


class Precedence(IntEnum):
    """How strongly the outermost operator of a text binds, from weak to strong, as in `requirement.lark`."""

    SINCE = 0
    OR = 1
    AND = 2
    NOT = 3
    COMPARISON = 4
    SUM = 5
    PRODUCT = 6
    UNARY = 7
    ATOM = 8


class Node:
    """Any part of a formula. A subclass whose text is not an atom sets `PRECEDENCE`."""

    PRECEDENCE: ClassVar[Precedence] = Precedence.ATOM

    @property
    def precedence(self) -> Precedence:
        """How strongly the text of this node binds."""
        return self.PRECEDENCE

    def operand_text(self, minimum: Precedence) -> str:
        """The text as an operand; in parentheses if it binds more weakly than `minimum`."""
        return str(self) if self.precedence >= minimum else f"({self})"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")


def _window(start_s: float, end_s: float) -> str:
    return f"[{_number(start_s)}:{_number(end_s)}]"


# --- terms: a number at each time


@dataclass(frozen=True)
class Number(Node):
    value: float

    def __str__(self) -> str:
        return _number(self.value)


@dataclass(frozen=True)
class FloatName(Node):
    """A float signal, or `topic.field`: the last value of a float field."""

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
        # Operators of one precedence group from the left, so an equal one on the right side needs parentheses.
        left = self.left.operand_text(self.precedence)
        return f"{left} {self.operator} {self.right.operand_text(Precedence(self.precedence + 1))}"


Term = Number | FloatName | Negative | Arithmetic


# --- past formulas: true or false at each time, decided by the run up to that time


@dataclass(frozen=True)
class BooleanName(Node):
    """A boolean signal, or `topic.field`: the last value of a boolean field."""

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
        hysteresis = f" [hysteresis {_number(self.hysteresis)}]" if self.hysteresis else ""
        duration = f" [for {_number(self.for_s)}]" if self.for_s else ""
        return f"{left} {self.relation} {right}{hysteresis}{duration}"


@dataclass(frozen=True)
class Not(Node):
    PRECEDENCE = Precedence.NOT
    operand: PastFormula

    def __str__(self) -> str:
        return f"!{self.operand.operand_text(Precedence.ATOM)}"


@dataclass(frozen=True)
class And(Node):
    PRECEDENCE = Precedence.AND
    left: PastFormula
    right: PastFormula

    def __str__(self) -> str:
        return f"{self.left.operand_text(Precedence.AND)} & {self.right.operand_text(Precedence.NOT)}"


@dataclass(frozen=True)
class Or(Node):
    PRECEDENCE = Precedence.OR
    left: PastFormula
    right: PastFormula

    def __str__(self) -> str:
        return f"{self.left.operand_text(Precedence.OR)} | {self.right.operand_text(Precedence.AND)}"


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
        window = "" if (self.start_s, self.end_s) == (0, math.inf) else _window(self.start_s, self.end_s)
        return f"{type(self).__name__.lower()}{window}({self.operand})"


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


PastFormula = BooleanName | On | Comparison | Not | And | Or | Rise | Fall | Once | Historically | Previously | Since


# --- responses: what has to follow when the antecedent is true


@dataclass(frozen=True)
class Holds(Node):
    """State response: true while the antecedent is true; an attempt is an episode of the antecedent."""

    condition: PastFormula

    def __str__(self) -> str:
        return str(self.condition)


@dataclass(frozen=True)
class Eventually(Node):
    """True at some time in [trigger + start_s, trigger + end_s]; an attempt starts when the antecedent becomes true."""

    condition: PastFormula
    start_s: float
    end_s: float

    def __str__(self) -> str:
        return f"eventually{_window(self.start_s, self.end_s)}({self.condition})"


@dataclass(frozen=True)
class AlwaysWithin(Node):
    """True at all times in [trigger + start_s, trigger + end_s]; an attempt starts when the antecedent becomes true."""

    condition: PastFormula
    start_s: float
    end_s: float

    def __str__(self) -> str:
        return f"always{_window(self.start_s, self.end_s)}({self.condition})"


@dataclass(frozen=True)
class HoldsUntil(Node):
    """Weak until: true from the trigger until `release` is first true, or to the end of the run.

    At the instant of `release`, `condition` may already be false.
    """

    condition: PastFormula
    release: PastFormula

    def __str__(self) -> str:
        return f"always({self.condition}) until {self.release}"


Response = Holds | Eventually | AlwaysWithin | HoldsUntil


@dataclass(frozen=True)
class Formula(Node):
    """`always(antecedent -> response)`."""

    antecedent: PastFormula
    response: Response

    def __str__(self) -> str:
        return f"always({self.antecedent} -> {self.response})"
