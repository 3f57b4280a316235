"""`share`: a share of independent trials with its confidence `Interval`, for campaigns, diagnoses and studies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

CONFIDENCE = 0.95
"""Confidence level of the intervals: the usual one in the literature, so that others' intervals can be compared."""


@dataclass(frozen=True)
class Interval:
    """An estimate with its 95 % confidence interval."""

    value: float
    low: float
    high: float


def share(part: float, whole: int) -> Interval | None:
    """A share of independent trials, 0 to 1, with Wilson's score interval; None of no trials.

    Wilson, E. B. (1927): Probable inference, the law of succession, and statistical inference. Unlike the usual
    p +- z s it stays within 0 and 1, and has a useful width for no success in n trials. Where trials count by a part
    of 1, `part` is their sum, and the interval is at least as wide as it has to be.

    Raises:
        ValueError: not 0 <= part <= whole.
    """
    if not 0 <= part <= whole:
        raise ValueError(f"{part} of {whole}: expected a part of a whole")
    if whole == 0:
        return None
    z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)
    value = part / whole
    centre = (value + z * z / (2 * whole)) / (1 + z * z / whole)
    half = z / (1 + z * z / whole) * math.sqrt(value * (1 - value) / whole + z * z / (4 * whole * whole))
    low = 0.0 if part == 0 else max(0.0, centre - half)
    high = 1.0 if part == whole else min(1.0, centre + half)
    return Interval(value, min(low, value), max(high, value))
