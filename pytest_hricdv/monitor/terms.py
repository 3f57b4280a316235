"""Terms as data, what comparisons compare: numbers, signals, fields, arithmetic, counts and texts.

The parser and `build` make terms such as `FloatName` and `Count`; each compiles to a part of a Python expression.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Literal

from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.node import Compiler, Kind, PastFormula, Precedence, Term, TextTerm, number_text, window_text
from pytest_hricdv.monitor.number_operators import CountOperator, TimeBetweenOperator

ArithmeticOperator = Literal["+", "-", "*", "/"]


def window_of_past(start_s: float, end_s: float) -> str:
    """The text of a window; empty for the complete past."""
    return "" if (start_s, end_s) == (0, math.inf) else window_text(start_s, end_s)


@dataclass(frozen=True)
class NumberTerm(Term):
    value: float

    def __str__(self) -> str:
        return number_text(self.value)

    def expression(self, compiler: Compiler) -> str:
        return repr(self.value)


@dataclass(frozen=True)
class FloatName(Term):
    """A float signal, `topic.field`, the last value of a float field, or `last(topic.field)`, the one before it."""

    name: str

    @property
    def own_names(self) -> dict[str, Kind]:
        return {self.name: float}

    def __str__(self) -> str:
        return self.name

    def expression(self, compiler: Compiler) -> str:
        return f"v[{self.name!r}]"


@dataclass(frozen=True)
class Negative(Term):
    PRECEDENCE = Precedence.UNARY
    operand: Term

    def __str__(self) -> str:
        return f"-{self.operand.operand_text(Precedence.ATOM)}"

    def expression(self, compiler: Compiler) -> str:
        return f"(-{self.operand.expression(compiler)})"


@dataclass(frozen=True)
class ArithmeticTerm(Term):
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

    def expression(self, compiler: Compiler) -> str:
        return f"finite({self.left.expression(compiler)} {self.operator} {self.right.expression(compiler)})"


@dataclass(frozen=True)
class Count(Term):
    """How often the operand became true at times in [t - end_s, t - start_s], within the run, as `rise(operand)` does.

    `count(on(topic))` counts messages: two at one instant are two.
    """

    UNIT: ClassVar[str] = ""
    operand: PastFormula
    start_s: float = 0.0
    end_s: float = math.inf

    @property
    def is_right_continuous(self) -> bool:
        # A count in a window of the past changes right after its end.
        return math.isinf(self.end_s)

    def __str__(self) -> str:
        return f"count{window_of_past(self.start_s, self.end_s)}({self.operand})"

    def expression(self, compiler: Compiler) -> str:
        count = partial(CountOperator, start_ns=nanoseconds(self.start_s), end_ns=nanoseconds(self.end_s))
        return compiler.number_output(self, count, self.operand)


@dataclass(frozen=True)
class TimeSince(Term):
    """The time (s) since the operand was last true: 0 while it is, infinite before it ever was.

    It changes all the time, so it is only the left side of a comparison with a number, which compiles it.
    """

    UNIT: ClassVar[str] = "s"
    operand: PastFormula

    def __str__(self) -> str:
        return f"time_since({self.operand})"

    def expression(self, compiler: Compiler) -> str:
        raise TypeError(f"{self} is the left side of a comparison with a number, and nothing else")


@dataclass(frozen=True)
class TimeBetween(Term):
    """The time (s) from when `begin` last became true to when `end` last became true, as `rise` does.

    It has a value once `end` has become true at or after `begin`, and keeps it until `end` becomes true again.
    """

    UNIT: ClassVar[str] = "s"
    MAY_BE_MISSING = True
    begin: PastFormula
    end: PastFormula

    def __str__(self) -> str:
        return f"time_between({self.begin}, {self.end})"

    def expression(self, compiler: Compiler) -> str:
        return compiler.number_output(self, TimeBetweenOperator, self.begin, self.end)


PastNumber = Count | TimeSince | TimeBetween

PAST_NUMBERS: Mapping[str, type[PastNumber]] = {"count": Count, "time_since": TimeSince, "time_between": TimeBetween}
"""The numbers about the past, which are written as functions, by their words."""


@dataclass(frozen=True)
class Text(TextTerm):
    """A string. It has at most one type of quotation mark, as there are no escapes."""

    value: str

    def __str__(self) -> str:
        return f"'{self.value}'" if '"' in self.value else f'"{self.value}"'

    def expression(self, compiler: Compiler) -> str:
        return repr(self.value)


@dataclass(frozen=True)
class TextName(TextTerm):
    """A signal, `topic.field` or `last(topic.field)`, whose values are strings."""

    name: str

    @property
    def own_names(self) -> dict[str, Kind]:
        return {self.name: str}

    def __str__(self) -> str:
        return self.name

    def expression(self, compiler: Compiler) -> str:
        return f"v[{self.name!r}]"


def leaves(term: Term | TextTerm) -> Iterator[Term | TextTerm]:
    """The operands of a term, in the order of the text."""
    operands = [part for part in term.parts if isinstance(part, Term | TextTerm)]
    for operand in operands:
        yield from leaves(operand)
    if not operands:
        yield term
