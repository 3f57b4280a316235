"""Numbers as text."""

from __future__ import annotations

import math


def number_text(value: float) -> str:
    """Jason prints a double as Java does: integral values plainly, else the shortest digits that read back."""
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if math.isnan(value):
        return "NaN"
    if value == math.floor(value) and abs(value) <= 2.0**63:
        # As the long integers of Java, the greatest of which is one less than that.
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
