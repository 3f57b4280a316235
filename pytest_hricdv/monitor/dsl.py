"""The values that the functions of `build` return: conditions and numbers whose operators (`&`, `<`) make formulas.

A `TruthValue` is a condition, a `NumberValue` a number, an `Implication` what `>>` makes of antecedent and response.
Patterns take them as arguments; `as_past`, `as_term` and `as_number` convert what users write, such as plain numbers.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NoReturn, Self, overload

from pytest_hricdv.monitor.formula import Holds, Response
from pytest_hricdv.monitor.node import PastFormula, Term, TextTerm
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Conjunction,
    Disjunction,
    Negation,
    NumberComparison,
    TextComparison,
)
from pytest_hricdv.monitor.terms import ArithmeticTerm, FloatName, Negative, NumberTerm, Text, TextName

_PARENTHESES = "in Python & | ~ >> bind more strongly than comparisons: put parentheses around each, as in p & (x < 1)"


class TruthValue:
    """A past formula: true or false at each time."""

    def __init__(self, past: PastFormula) -> None:
        self.past = past

    @overload
    def __and__(self, other: Implication) -> Implication: ...
    @overload
    def __and__(self, other: TruthValue) -> TruthValue: ...
    def __and__(self, other: TruthValue | Implication) -> TruthValue | Implication:
        # Python parses `p & q >> r` as `p & (q >> r)`; `(p & q) >> r` is meant.
        if isinstance(other, Implication):
            return Implication(self._join(Conjunction, other.antecedent), other.response)
        return TruthValue(self._join(Conjunction, as_past(other)))

    @overload
    def __or__(self, other: Implication) -> Implication: ...
    @overload
    def __or__(self, other: TruthValue) -> TruthValue: ...
    def __or__(self, other: TruthValue | Implication) -> TruthValue | Implication:
        if isinstance(other, Implication):
            return Implication(self._join(Disjunction, other.antecedent), other.response)
        return TruthValue(self._join(Disjunction, as_past(other)))

    def _join(self, connective: type[Conjunction | Disjunction], other: PastFormula) -> PastFormula:
        """Make one conjunction of `p & q & r`, as the text form does."""
        before = self.past.operands if isinstance(self.past, connective) else (self.past,)
        return connective(*before, other)

    def __invert__(self) -> TruthValue:
        return TruthValue(Negation(self.past))

    def __rshift__(self, response: TruthValue | Response) -> Implication:
        if isinstance(response, Response):
            return Implication(self.past, response)
        return Implication(self.past, Holds(as_past(response)))

    def __rand__(self, other: object) -> NoReturn:
        raise TypeError(f"{other!r} is not a condition; {_PARENTHESES}")

    __ror__ = __rand__

    def __eq__(self, other: object) -> NoReturn:
        raise TypeError(
            "== compares Python objects; write equal(a, b) or unequal(a, b) for numbers and strings, p or ~p for bools"
        )

    __hash__ = None  # type: ignore[assignment]  # without comparison, it cannot be a dict key

    def __bool__(self) -> NoReturn:
        raise TypeError(
            "a condition has no truth value in Python: write & | ~ for and, or, not, (a < x) & (x < b) for a < x < b"
        )

    def __repr__(self) -> str:
        return f"<condition {self.past}>"


class ComparisonValue(TruthValue):
    """A comparison, to which a minimum duration can be added."""

    def __init__(self, comparison: NumberComparison | TextComparison) -> None:
        super().__init__(comparison)
        self._comparison = comparison

    def held_for(self, duration_s: float) -> Self:
        """`[for d]`: true once it has held for `duration_s` seconds."""
        return type(self)(replace(self._comparison, for_s=as_number(duration_s, "a duration")))


class Inequality(ComparisonValue):
    """A comparison with `< <= > >=`, to which a hysteresis can be added as well."""

    _comparison: NumberComparison

    def hysteresis(self, width: float) -> Inequality:
        """`[hysteresis h]`: once false, true again only past the bound by `width`, in the unit of the comparison."""
        return Inequality(replace(self._comparison, hysteresis=as_number(width, "a hysteresis")))


class NumberValue:
    """A term: a number at each time."""

    def __init__(self, term: Term) -> None:
        self.term = term

    def __add__(self, other: NumberValue | float) -> NumberValue:
        return NumberValue(ArithmeticTerm("+", self.term, as_term(other)))

    def __radd__(self, other: float) -> NumberValue:
        return NumberValue(ArithmeticTerm("+", as_term(other), self.term))

    def __sub__(self, other: NumberValue | float) -> NumberValue:
        return NumberValue(ArithmeticTerm("-", self.term, as_term(other)))

    def __rsub__(self, other: float) -> NumberValue:
        return NumberValue(ArithmeticTerm("-", as_term(other), self.term))

    def __mul__(self, other: NumberValue | float) -> NumberValue:
        return NumberValue(ArithmeticTerm("*", self.term, as_term(other)))

    def __rmul__(self, other: float) -> NumberValue:
        return NumberValue(ArithmeticTerm("*", as_term(other), self.term))

    def __truediv__(self, other: NumberValue | float) -> NumberValue:
        return NumberValue(ArithmeticTerm("/", self.term, as_term(other)))

    def __rtruediv__(self, other: float) -> NumberValue:
        return NumberValue(ArithmeticTerm("/", as_term(other), self.term))

    def __neg__(self) -> NumberValue:
        return NumberValue(Negative(self.term))

    def __lt__(self, other: NumberValue | float) -> Inequality:
        return Inequality(NumberComparison("<", self.term, as_term(other)))

    def __le__(self, other: NumberValue | float) -> Inequality:
        return Inequality(NumberComparison("<=", self.term, as_term(other)))

    def __gt__(self, other: NumberValue | float) -> Inequality:
        return Inequality(NumberComparison(">", self.term, as_term(other)))

    def __ge__(self, other: NumberValue | float) -> Inequality:
        return Inequality(NumberComparison(">=", self.term, as_term(other)))

    __eq__ = TruthValue.__eq__
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<number {self.term}>"


class TextValue:
    """A text at each time."""

    def __init__(self, text: TextTerm) -> None:
        self.text = text

    __eq__ = TruthValue.__eq__
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<string {self.text}>"


class NameValue(TruthValue, NumberValue):
    """A signal or a field; its position decides whether it is a condition, a number or a string, as in the language."""

    def __init__(self, name: str) -> None:
        self.text = TextName(name)
        TruthValue.__init__(self, BooleanName(name))
        NumberValue.__init__(self, FloatName(name))

    def __repr__(self) -> str:
        return f"<name {self.past}>"


class Implication:
    """`antecedent >> response`, the argument of `always(...)`."""

    def __init__(self, antecedent: PastFormula, response: Response) -> None:
        self.antecedent = antecedent
        self.response = response

    def _compare(self, other: object) -> NoReturn:
        raise TypeError(f"an implication cannot be compared with {other!r}; {_PARENTHESES}")

    __lt__ = __le__ = __gt__ = __ge__ = _compare


def as_past(condition: TruthValue) -> PastFormula:
    """The formula of a condition. Raises TypeError for anything else, with advice."""
    if isinstance(condition, TruthValue):
        return condition.past
    raise TypeError(f"expected a condition, got {condition!r}; {_PARENTHESES}")


def as_term(quantity: NumberValue | float) -> Term:
    """The term of a number. Raises TypeError for anything else, ValueError for a number that is not finite."""
    if isinstance(quantity, NumberValue):
        return quantity.term
    if isinstance(quantity, int | float) and quantity < 0:
        return Negative(NumberTerm(as_number(-quantity, "a number")))
    return NumberTerm(as_number(quantity, "a number"))


def as_text(text: object) -> TextTerm:
    """The term of a text. Raises TypeError for anything else, ValueError for one that cannot be written."""
    if isinstance(text, NameValue | TextValue):
        return text.text
    if not isinstance(text, str):
        raise TypeError(f"expected a string or a name, got {text!r}; strings are compared with strings")
    if "\n" in text or ('"' in text and "'" in text):
        raise ValueError(f"{text!r}: a string is one line with at most one kind of quotation marks")
    return Text(text)


def as_number(value: float, description: str, *, allow_infinite: bool = False) -> float:
    """A float of at least 0; it may be infinite only with `allow_infinite`.

    Raises:
        TypeError: not a number.
        ValueError: negative, NaN, or infinite.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{description}: expected a number, got {value!r}")
    if not value >= 0 or (math.isinf(value) and not allow_infinite):
        raise ValueError(f"{description}: expected a finite number of at least 0, got {value}")
    if float(value) != value:
        raise ValueError(f"{description}: {value} has too many digits for a float, which is {value:.0f}")
    return float(value)
