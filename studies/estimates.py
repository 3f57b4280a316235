"""Statistics of samples: confidence intervals of shares and means, and rank correlation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist, fmean

from pytest_hricdv.generate.rng import make_rng, random_index

CONFIDENCE = 0.95
RESAMPLES = 2000


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


def mean(values: Sequence[float]) -> Interval:
    """The mean with its percentile bootstrap interval (Efron 1979), from a fixed random stream: always the same.

    Raises:
        ValueError: no values.
    """
    if not values:
        raise ValueError("no values: expected at least one")
    rng = make_rng("bootstrap of a mean", len(values))
    drawn = sorted(fmean(values[random_index(rng, len(values))] for _ in values) for _ in range(RESAMPLES))
    beyond = round((1 - CONFIDENCE) / 2 * RESAMPLES)
    value = fmean(values)
    return Interval(value, min(drawn[beyond], value), max(drawn[-1 - beyond], value))


def ranks(values: Sequence[float]) -> list[float]:
    """The rank of each value, from 1; equal values share the mean of their ranks."""
    order = sorted(range(len(values)), key=values.__getitem__)
    found = [0.0] * len(values)
    first = 0
    while first < len(order):
        last = first
        while last + 1 < len(order) and values[order[last + 1]] == values[order[first]]:
            last += 1
        for place in order[first : last + 1]:
            found[place] = (first + last) / 2 + 1
        first = last + 1
    return found


def spearman(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Spearman's rank correlation, -1 to 1: Pearson's of the ranks, which is right with ties, too.

    None where it is not defined: fewer than two pairs, or all values of one side equal.

    Raises:
        ValueError: sequences of different lengths.
    """
    if len(first) != len(second):
        raise ValueError(f"{len(first)} and {len(second)} values: expected pairs")
    a, b = ranks(first), ranks(second)
    if len(set(a)) < 2 or len(set(b)) < 2:
        return None
    middle = (len(a) + 1) / 2
    both = math.fsum((x - middle) * (y - middle) for x, y in zip(a, b, strict=True))
    return both / math.sqrt(math.fsum((x - middle) ** 2 for x in a) * math.fsum((y - middle) ** 2 for y in b))
