"""The axes of a chart: a range, where its ticks are, and which share of the way a value is."""

import math
import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """A labelled range with ticks (value, text); on a logarithmic one both ends are positive."""

    label: str
    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    logarithmic: bool = False

    def place(self, value: float) -> float:
        """Where a value is: 0 at the low end, 1 at the high end; what lies beyond is put onto the end."""
        inside = min(max(value, self.low), self.high)
        if self.logarithmic:
            return math.log(inside / self.low) / math.log(self.high / self.low)
        return (inside - self.low) / (self.high - self.low)


def linear(label: str, low: float, high: float, whole: bool = False) -> Axis:
    """An axis with four to eight ticks at round values, from `low` to `high`.

    Args:
        label: what is measured, with its unit.
        low: the low end.
        high: the high end; moved up where the two are (nearly) equal.
        whole: ticks at whole numbers only, for counts.
    """
    high = high if high - low > 1e-9 * max(abs(low), 1.0) else low + 1
    step = _round_step((high - low) / 7)
    step = max(step, 1.0) if whole else step
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return Axis(label, low, high, tuple((n * step, f"{n * step:.6g}") for n in range(first, last + 1)))


def logarithmic(label: str, low: float, high: float) -> Axis:
    """An axis over whole decades that holds both values, which are positive."""
    bottom = math.floor(math.log10(low) + 1e-9)
    top = min(max(math.ceil(math.log10(high) - 1e-9), bottom + 1), sys.float_info.max_10_exp)
    every = math.ceil((top - bottom) / 7)
    ticks = tuple((10.0**n, _decade(n)) for n in range(bottom, top + 1, every))
    return Axis(label, 10.0**bottom, 10.0**top, ticks, logarithmic=True)


def _round_step(rough: float) -> float:
    """The least of 1, 2, 5, 10 times a power of ten that is at least `rough`."""
    power: float = 10.0 ** math.floor(math.log10(rough))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * (1 - 1e-9))


def _decade(exponent: int) -> str:
    return f"{10.0**exponent:g}" if -2 <= exponent <= 3 else f"1e{exponent}"
