"""Numbers and arithmetic of AgentSpeak: doubles, computed and printed as in Jason, which is written in Java.

The module `terms` uses both: a `Number` is a term, and `OPERATIONS` evaluates expressions such as `X + 1`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable


class Number(float):
    """A number: always a double, as in Jason; a whole number is printed without a fraction."""

    __slots__ = ()

    def __str__(self) -> str:
        return number_text(float(self))

    def __repr__(self) -> str:
        return f"Number({number_text(float(self))})"


def number_text(value: float) -> str:
    """A double as Jason prints it: whole numbers without a fraction, others as Java does."""
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if math.isnan(value):
        return "NaN"
    if value == math.floor(value) and abs(value) <= 2.0**63:
        # Jason casts to a Java long, whose greatest value is one less than 2**63.
        return str(min(int(value), 2**63 - 1))
    if 1e-3 <= abs(value) < 1e7:  # java.lang.Double.toString has no exponent in this range
        return repr(value)
    mantissa, exponent = _scientific(value)
    return f"{mantissa}E{exponent}"


def _scientific(value: float) -> tuple[str, int]:
    """Shortest mantissa with at least one decimal, and the exponent, as Java writes them."""
    # The shortest text that is read back as the same double; 17 significant digits always are (IEEE 754).
    for digits in range(17):
        text = f"{value:.{digits}e}"
        if float(text) == value:
            break
    mantissa, exponent = text.split("e")
    return (mantissa if "." in mantissa else mantissa + ".0"), int(exponent)


def _divide(x: float, y: float) -> float:
    if y == 0.0:
        return math.nan if x == 0.0 else math.copysign(math.inf, x)
    return x / y


def _remainder(x: float, y: float) -> float:
    return math.nan if y == 0.0 or math.isinf(x) else math.fmod(x, y)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except OverflowError:
        # Python raises where Java has an infinity; only an odd power of a negative number is a negative one.
        return -math.inf if x < 0.0 and y % 2.0 == 1.0 else math.inf
    except ValueError:
        # 0 to a negative power, or a root of a negative number.
        return math.inf if x == 0.0 else math.nan


# Integer division and remainder truncate towards zero, as on the Java numbers Jason computes with.
OPERATIONS: dict[str, Callable[..., float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _divide,
    "div": lambda x, y: float(math.trunc(math.trunc(x) / math.trunc(y))),
    "mod": _remainder,
    "**": _power,
}
