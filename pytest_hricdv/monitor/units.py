"""Units of measurement in requirements, as in `0.25 rad/s`: their dimensions and scales, and numbers with units.

`unit_of` reads a `Unit`; `NumberParser` and `Vocabulary` use it. A `QuantityTerm` is a number or expression with its
unit. Sources of the scales: the SI Brochure (BIPM, 9th edition, 2019), tables 4 to 8.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from operator import add, mul, sub, truediv
from typing import Literal

from pytest_hricdv.monitor.node import Term
from pytest_hricdv.monitor.terms import ArithmeticTerm, Negative, NumberTerm

Dimension = tuple[tuple[str, int], ...]
"""Base units with their exponents, in the order of their names."""

_MILLI, _CENTI, _KILO, _MEGA = Fraction(1, 1000), Fraction(1, 100), Fraction(1000), Fraction(10**6)
_NEWTON = {"kg": 1, "m": 1, "s": -2}
_PASCAL = {"kg": 1, "m": -1, "s": -2}
_JOULE = {"kg": 1, "m": 2, "s": -2}
_WATT = {"kg": 1, "m": 2, "s": -3}
_KNOWN: dict[str, tuple[Fraction, dict[str, int]]] = {
    "m": (Fraction(1), {"m": 1}),
    "um": (_MILLI * _MILLI, {"m": 1}),
    "mm": (_MILLI, {"m": 1}),
    "cm": (_CENTI, {"m": 1}),
    "km": (_KILO, {"m": 1}),
    "s": (Fraction(1), {"s": 1}),
    "us": (_MILLI * _MILLI, {"s": 1}),
    "ms": (_MILLI, {"s": 1}),
    "min": (Fraction(60), {"s": 1}),
    "h": (Fraction(3600), {"s": 1}),
    "Hz": (Fraction(1), {"s": -1}),
    "kHz": (_KILO, {"s": -1}),
    "rad": (Fraction(1), {"rad": 1}),
    "mrad": (_MILLI, {"rad": 1}),
    "deg": (Fraction(math.pi) / 180, {"rad": 1}),  # of the float pi, as in math.radians
    "kg": (Fraction(1), {"kg": 1}),
    "g": (_MILLI, {"kg": 1}),
    "N": (Fraction(1), _NEWTON),
    "mN": (_MILLI, _NEWTON),
    "kN": (_KILO, _NEWTON),
    "Nm": (Fraction(1), _JOULE),
    "J": (Fraction(1), _JOULE),
    "mJ": (_MILLI, _JOULE),
    "W": (Fraction(1), _WATT),
    "kW": (_KILO, _WATT),
    "Pa": (Fraction(1), _PASCAL),
    "kPa": (_KILO, _PASCAL),
    "MPa": (_MEGA, _PASCAL),
    "V": (Fraction(1), {"V": 1}),
    "A": (Fraction(1), {"A": 1}),
    "K": (Fraction(1), {"K": 1}),
    "%": (Fraction(1), {"%": 1}),
}
_ARITHMETIC: dict[str, Callable[[Fraction, Fraction], Fraction]] = {"+": add, "-": sub, "*": mul, "/": truediv}
_FACTOR = re.compile(r"([*/]?)([A-Za-z%]+)(?:\^(-?\d)(?!\d))?")
_MAX_TEXT = 60
"""Longest text of a unit, in characters; with one digit an exponent, its scale stays a small number."""

MAX_TIME_S = 1e9
"""Longest time in a formula, in seconds: 30 years (chosen; who writes more has forgotten that times are in seconds).
Time inside the monitors is in whole nanoseconds."""


@dataclass(frozen=True)
class Unit:
    """A unit; an unknown name is a base unit of its own.

    Attributes:
        text: as written; of a product of units, an explanation.
        scale: how many of its base units it has.
        dimension: its base units.
        is_known: whether all names in it are known.
    """

    text: str
    scale: Fraction = Fraction(1)
    dimension: Dimension = ()
    is_known: bool = True

    @property
    def base(self) -> Unit:
        """The unit of the same dimension that is made of base units only."""
        text = " * ".join(base if power == 1 else f"{base}^{power}" for base, power in self.dimension)
        return Unit(text, Fraction(1), self.dimension, self.is_known)

    def times(self, other: Unit, exponent: Literal[1, -1]) -> Unit:
        """The product with, or the quotient by, another unit."""
        dimension = Counter(dict(self.dimension))
        for base, power in other.dimension:
            dimension[base] += exponent * power
        text = f"{self.text or '1'} {'*' if exponent > 0 else '/'} {other.text or '1'}"
        is_known = self.is_known and other.is_known
        return Unit(text, self.scale * other.scale**exponent, _dimension(dimension.items()), is_known)


NO_UNIT = Unit("")


def unit_of(text: str) -> Unit:
    """The unit that a text means: names of units with `*`, `/` and whole exponents, such as `rad/s` or `m/s^2`."""
    unit, place = NO_UNIT, 0
    if len(text) > _MAX_TEXT:
        return Unit(text, dimension=((text, 1),), is_known=False)
    while place < len(text):
        factor = _FACTOR.match(text, place)
        if factor is None or factor[2] not in _KNOWN or (factor[1] == "") != (place == 0):
            return Unit(text, dimension=((text, 1),), is_known=False)
        scale, bases = _KNOWN[factor[2]]
        power = int(factor[3] or 1)
        base = Unit(factor[2], scale**power, _dimension((name, exponent * power) for name, exponent in bases.items()))
        unit = unit.times(base, -1 if factor[1] == "/" else 1)
        place = factor.end()
    return Unit(text, unit.scale, unit.dimension)


def unit_names() -> list[str]:
    """The names that units are made of."""
    return [*_KNOWN]


@dataclass(frozen=True)
class QuantityTerm:
    """A term with its unit.

    Attributes:
        term: the numbers in it are in the unit.
        unit: None if it is not known: of a plain number, and of a name without a declared unit.
        origin: `number` of constants without a unit, `quantity` of those with one, `value` of what is measured.
        exact: False if a plain number is a factor of it, whose own unit was not written.
    """

    term: Term
    unit: Unit | None
    origin: Literal["number", "quantity", "value"]
    exact: bool = True

    def to_unit(self, unit: Unit) -> QuantityTerm:
        """A quantity in another unit of its dimension; the nearest float to the exact product. Raises OverflowError."""
        assert self.unit is not None
        return QuantityTerm(constant_term(constant(self.term) * self.unit.scale / unit.scale), unit, "quantity")


def constant(term: Term) -> Fraction:
    """The value of a term of numbers only, exactly as they are written. Raises ZeroDivisionError."""
    match term:
        case NumberTerm():
            return Fraction(repr(term.value))  # as written: 0.1 is a tenth, not the nearest float
        case Negative():
            return -constant(term.operand)
        case ArithmeticTerm():
            return _ARITHMETIC[term.operator](constant(term.left), constant(term.right))
        case _:
            raise TypeError(f"{term} is not a constant")


def constant_term(value: Fraction) -> Term:
    """The nearest float, as it is written: a negative one has a sign before it. Raises OverflowError."""
    return Negative(NumberTerm(float(-value))) if value < 0 else NumberTerm(float(value))


def _dimension(bases: Iterable[tuple[str, int]]) -> Dimension:
    return tuple(sorted((base, power) for base, power in bases if power))


SECOND = unit_of("s")
