"""Samplers: the declared ranges that concrete parameters are drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

from .error import GenerateError


class Sampler:
    """Draws one parameter's value from a private stream."""

    def sample(self, random: Random) -> float:
        """A value. The stream is this parameter's own and used for nothing else."""
        raise NotImplementedError


@dataclass(frozen=True)
class Constant(Sampler):
    """Always the same value, in `unit`."""

    value: float
    unit: str = ""

    def __post_init__(self) -> None:
        _check_finite("constant", self.value)

    def sample(self, random: Random) -> float:
        """The value."""
        return float(self.value)


@dataclass(frozen=True)
class Range(Sampler):
    """Uniform over [low, high], or over [low, high) with `open_high`, in `unit`.

    Raises:
        GenerateError: a bound is not finite, the range is upside down, or it is half-open and empty.
    """

    low: float
    high: float
    unit: str = ""
    open_high: bool = False

    def __post_init__(self) -> None:
        _check_finite("range", self.low)
        _check_finite("range", self.high)
        if self.low > self.high:
            raise GenerateError(f"{self} is upside down; expected low <= high")
        if self.open_high and self.low == self.high:
            raise GenerateError(f"{self} is empty; expected low < high")

    def __str__(self) -> str:
        return f"range [{self.low:g}, {self.high:g}{')' if self.open_high else ']'} {self.unit}".rstrip()

    def sample(self, random: Random) -> float:
        """A value in the range; rounding never carries it over the high end."""
        share = random.random()
        return self.clipped(self.low * (1.0 - share) + self.high * share)

    def clipped(self, value: float) -> float:
        """The value in the range that is nearest to this one."""
        highest = math.nextafter(self.high, -math.inf) if self.open_high else float(self.high)
        return min(max(value, float(self.low)), highest)

    def contains(self, value: float) -> bool:
        """Whether a value is in the range."""
        return self.low <= value <= self.high and not (self.open_high and value == self.high)


@dataclass(frozen=True)
class Chance(Sampler):
    """With `probability` a value of `then`, otherwise 0.0.

    Raises:
        GenerateError: the probability is not in [0, 1].
    """

    probability: float
    then: Range | Constant

    def __post_init__(self) -> None:
        if not 0.0 <= self.probability <= 1.0:
            raise GenerateError(f"a chance of {self.probability!r}: expected a probability from 0 to 1")

    def sample(self, random: Random) -> float:
        """A value of `then`, or 0.0."""
        return self.then.sample(random) if random.random() < self.probability else 0.0


def _check_finite(what: str, value: float) -> None:
    if not math.isfinite(value):
        raise GenerateError(f"{what} with {value!r}: expected a finite number")
