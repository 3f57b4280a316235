"""Statistics of samples: confidence intervals of means, and rank correlation. Shares: see `results.proportion`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import fmean

from pytest_hricdv.generate.rng import make_rng, random_index
from pytest_hricdv.results.proportion import CONFIDENCE, Interval

RESAMPLES = 2000  # Efron and Tibshirani, An introduction to the bootstrap (1993), want 1,000 and more for intervals


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
    # The mean itself is always in it: of very few values, resamples may all be on one side.
    return Interval(value, min(drawn[beyond], value), max(drawn[-1 - beyond], value))


def ranks(values: Sequence[float]) -> list[float]:
    """The rank of each value, from 1; equal values share the mean of their ranks."""
    order = sorted(range(len(values)), key=values.__getitem__)
    ranked = [0.0] * len(values)
    first = 0
    while first < len(order):
        last = first
        while last + 1 < len(order) and values[order[last + 1]] == values[order[first]]:
            last += 1
        for place in order[first : last + 1]:
            ranked[place] = (first + last) / 2 + 1
        first = last + 1
    return ranked


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
