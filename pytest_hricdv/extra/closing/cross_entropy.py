"""Adapted ranges: where the values of a parameter were drawn that led nearest to a point, more are drawn.

The cross-entropy method (R. Rubinstein, D. Kroese: The Cross-Entropy Method, 2004), for each parameter by itself: a
normal distribution is fitted to the elite's values, smoothed with the declared range, and cut to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from statistics import fmean, pstdev

from pytest_hricdv.generate.sampler import Chance, Range, Sampler

ELITE = 0.2
"""The share of runs, those that came nearest, whose values count. The literature has 1 to 10 % of many draws; of some
dozens of runs, as there are here, this would be less than `LEAST_ELITE`: chosen (0.1: no change, 0.4: -0.5 +- 1.0, for
runs near to a point only; see the package)."""

LEAST_ELITE = 4
"""Fewer runs say nothing: the declared range holds. Chosen: a deviation of three values or fewer is mostly chance; its
effect was not measured."""

SMOOTHING = 0.7
"""The weight of the elite; the rest is the declared range's, so that no value is ruled out early. 0.7 is a usual value
of the method's smoothing, there with the distribution before; its effect here was not measured."""

SWITCHED_ON = 0.5
"""What is declared to happen by chance is switched on on purpose with at least this probability. Chosen: in half of the
runs it is on, in half off; its effect was not measured."""


def adapted(sampler: Sampler, elite: Sequence[float], rng: Random) -> float:
    """A value of a parameter.

    Args:
        sampler: as it is declared.
        elite: its values in the runs that came nearest to the point.
        rng: of which only `random()` is used.
    """
    if isinstance(sampler, Chance):
        on = [value for value in elite if value]
        share = len(on) / len(elite) if len(elite) >= LEAST_ELITE else 0.0
        is_on = rng.random() < max(SWITCHED_ON, SMOOTHING * share)
        return adapted(sampler.then, on, rng) if is_on and sampler.probability else 0.0
    if not isinstance(sampler, Range) or len(elite) < LEAST_ELITE:
        return sampler.sample(rng)
    width = sampler.high - sampler.low
    mean = SMOOTHING * fmean(elite) + (1.0 - SMOOTHING) * (sampler.low + width / 2)
    # The declared range is uniform: its standard deviation is its width by the square root of 12.
    deviation = SMOOTHING * pstdev(elite) + (1.0 - SMOOTHING) * width / math.sqrt(12)
    return sampler.clipped(mean + deviation * _normal(rng))


def elite_size(runs: int) -> int:
    """How many of so many runs are the elite."""
    return math.ceil(ELITE * runs)


def _normal(rng: Random) -> float:
    """A standard normal number (Box and Muller), from `random()` alone: its sequence is the same in every Python."""
    return math.sqrt(-2.0 * math.log(1.0 - rng.random())) * math.cos(2.0 * math.pi * rng.random())
