"""Numbers, strings and variables, and the text of numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass


class Number(float):
    """A number; like Jason's, always a double, printed without a fraction when it has none."""

    __slots__ = ()

    def __str__(self) -> str:
        return number_text(float(self))

    def __repr__(self) -> str:
        return f"Number({number_text(float(self))})"


class Variable(str):
    """A logical variable, identified by its name."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Variable({self!s})"


@dataclass(frozen=True, slots=True)
class String:
    """A quoted text."""

    value: str

    def __str__(self) -> str:
        text = self.value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + text.replace("\n", "\\n").replace("\t", "\\t").replace("\r", "\\r") + '"'


def number_text(value: float) -> str:
    """A double as Jason prints it: whole numbers without a fraction, others as Java does."""
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if math.isnan(value):
        return "NaN"
    if value == math.floor(value) and abs(value) <= 2.0**63:
        # Jason casts to a Java long, whose greatest value is one less than 2**63.
        return str(min(int(value), 2**63 - 1))
    if 1e-3 <= abs(value) < 1e7:
        return repr(value)
    mantissa, exponent = _scientific(value)
    return f"{mantissa}E{exponent}"


def _scientific(value: float) -> tuple[str, int]:
    """Shortest mantissa with at least one decimal, and the exponent, as Java writes them."""
    for digits in range(17):
        text = f"{value:.{digits}e}"
        if float(text) == value:
            break
    mantissa, exponent = text.split("e")
    return (mantissa if "." in mantissa else mantissa + ".0"), int(exponent)
