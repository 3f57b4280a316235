"""What is simpler: the values that a parameter may be given, the simplest first, by the range it was drawn from."""

from __future__ import annotations

from collections.abc import Iterator
from math import floor, log10

from pytest_hricdv.generate.sampler import Chance, Constant, Range, Sampler

_DIGITS = (1, 2, 3)


def simpler(value: float, sampler: Sampler) -> tuple[float, ...]:
    """The values to try instead of this one, the simplest first; none if there is nothing simpler.

    Of a chance: that it does not happen; of a range: its middle, its ends, then the value itself with one, two or
    three significant digits. Each is in the range, and the simpler ones of a value that was taken from here come before
    it in the list, so that simplifying ends.
    """
    found: list[float] = []
    for candidate in (*landmarks(sampler), *_rounded(value, sampler)):
        if candidate == value:
            break
        if candidate not in found:
            found.append(candidate)
    return tuple(found)


def landmarks(sampler: Sampler) -> tuple[float, ...]:
    """The values that stand out, the simplest first: that a chance does not happen; a range's middle and its ends."""
    if isinstance(sampler, Chance):
        return (0.0, *landmarks(sampler.then))
    if isinstance(sampler, Constant):
        return (float(sampler.value),)
    if isinstance(sampler, Range):
        ends = (sampler.low,) if sampler.open_high else (sampler.low, sampler.high)
        return (_middle(sampler), *map(float, ends))
    return ()


def _middle(sampler: Range) -> float:
    """The middle, without the dust of binary fractions where a short number is as good."""
    exact = sampler.low + (sampler.high - sampler.low) / 2
    short = float(f"{exact:.6g}")
    return short if sampler.contains(short) else exact


def _rounded(value: float, sampler: Sampler) -> Iterator[float]:
    inside = sampler.then if isinstance(sampler, Chance) else sampler
    if not isinstance(inside, Range) or value == 0.0:
        return
    place = floor(log10(abs(value)))
    for digits in _DIGITS:
        short = round(value, digits - 1 - place)
        if inside.contains(short):
            yield short
