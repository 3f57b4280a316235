"""Samplers: the ranges that testbenches declare for the parameters of actions, and from which values are drawn.

`Constant`, `Uniform` and `Sometimes` are samplers. `concretize` draws values with `uniform` or, for
`--hri-sampling=corners`, with `corners`; shrinking and searches use the other methods of a `Sampler`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.rng import pick


class Sampler(ABC):
    """Draws the values of one parameter."""

    unit: str = ""

    @abstractmethod
    def sample(self, rng: Random) -> float:
        """A value, drawn from the parameter's own random stream."""

    def corners(self) -> tuple[float, ...]:
        """The extreme values; empty if the sampler has none."""
        return ()

    def simple_values(self) -> tuple[float, ...]:
        """Values that are easy to read, the simplest first; empty if the sampler has none."""
        return ()

    def contains(self, value: float) -> bool:
        """Whether a value can be chosen; any finite one if the sampler has no bounds."""
        return math.isfinite(value)

    def format(self, value: float) -> str:
        """A value with its unit, for people."""
        return f"{value:.6g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Constant(Sampler):
    """Always the same value, in `unit`."""

    value: float
    unit: str = ""

    def __post_init__(self) -> None:
        _check_finite("constant", self.value)

    def __str__(self) -> str:
        return self.format(self.value)

    def sample(self, rng: Random) -> float:
        """The value."""
        return float(self.value)

    def corners(self) -> tuple[float, ...]:
        """The value."""
        return (float(self.value),)

    def simple_values(self) -> tuple[float, ...]:
        """The value."""
        return (float(self.value),)

    def contains(self, value: float) -> bool:
        """Whether it is the value."""
        return value == self.value


@dataclass(frozen=True)
class Uniform(Sampler):
    """Uniform over [low, high], or over [low, high) with `open_high`, in `unit`.

    Raises:
        GenerateError: a bound is not finite, the range is reversed, or it is half-open and empty.
    """

    low: float
    high: float
    unit: str = ""
    open_high: bool = False

    def __post_init__(self) -> None:
        _check_finite("range", self.low)
        _check_finite("range", self.high)
        if self.low > self.high:
            raise GenerateError(f"{self} is reversed; expected low <= high")
        if self.open_high and self.low == self.high:
            raise GenerateError(f"{self} is empty; expected low < high")

    def __str__(self) -> str:
        return f"range [{self.low:g}, {self.high:g}{')' if self.open_high else ']'} {self.unit}".rstrip()

    def sample(self, rng: Random) -> float:
        """A value in the range; rounding never takes it above the high end."""
        share = rng.random()
        # Not low + share * (high - low): the difference of two finite bounds can be infinite.
        return self.clip(self.low * (1.0 - share) + self.high * share)

    def corners(self) -> tuple[float, ...]:
        """Both ends; of a half-open range, the greatest number below its high end."""
        return (float(self.low), self.clip(self.high))

    def simple_values(self) -> tuple[float, ...]:
        """The middle, then the ends that are in the range."""
        middle = self.low + (self.high - self.low) / 2
        rounded = float(f"{middle:.6g}")  # 0.3 instead of 0.30000000000000004
        ends = (self.low,) if self.open_high else (self.low, self.high)
        return (rounded if self.contains(rounded) else middle, *map(float, ends))

    def clip(self, value: float) -> float:
        """The value in the range that is nearest to this one."""
        highest = math.nextafter(self.high, -math.inf) if self.open_high else float(self.high)
        return min(max(value, float(self.low)), highest)

    def contains(self, value: float) -> bool:
        """Whether a value is in the range."""
        return self.low <= value <= self.high and not (self.open_high and value == self.high)


@dataclass(frozen=True)
class Sometimes(Sampler):
    """A sampler that draws from `then` with `probability`, and otherwise gives 0.0.

    Raises:
        GenerateError: the probability is not in [0, 1].
    """

    probability: float
    then: Uniform | Constant

    def __post_init__(self) -> None:
        if not 0.0 <= self.probability <= 1.0:
            raise GenerateError(f"a chance of {self.probability!r}: expected a probability from 0 to 1")

    def __str__(self) -> str:
        return f"0 or {self.then}"

    def sample(self, rng: Random) -> float:
        """A value of `then`, or 0.0."""
        return self.then.sample(rng) if rng.random() < self.probability else 0.0

    def corners(self) -> tuple[float, ...]:
        """0.0, and the extreme values of `then` if it can occur."""
        return (0.0, *self.then.corners()) if self.probability > 0.0 else (0.0,)

    def simple_values(self) -> tuple[float, ...]:
        """0.0, then those of `then`."""
        return (0.0, *self.then.simple_values())

    def contains(self, value: float) -> bool:
        """Whether it is 0.0 or a value of `then`, however rare that is."""
        return value == 0.0 or self.then.contains(value)

    def format(self, value: float) -> str:
        """Format a value as `then` does."""
        return self.then.format(value)


#: How parameters are drawn: a function of the sampler and of the parameter's own random stream.
Sampling = Callable[[Sampler, Random], float]

_AT_A_CORNER = 0.5  # of three parameters, all are extreme in one draw of eight, and none in another


def uniform(sampler: Sampler, rng: Random) -> float:
    """A value as the sampler declares it."""
    return sampler.sample(rng)


def corners(sampler: Sampler, rng: Random) -> float:
    """With probability 0.5 an extreme value, each equally likely; otherwise a value as the sampler declares it.

    Bugs often need several extreme parameters at once to show, which uniform sampling almost never gives. A value that
    is declared to be rare occurs often.
    """
    extremes = sampler.corners()
    if extremes and rng.random() < _AT_A_CORNER:
        return pick(rng, extremes)
    return sampler.sample(rng)


SAMPLINGS: Mapping[str, Sampling] = {"uniform": uniform, "corners": corners}


def _check_finite(subject: str, value: float) -> None:
    if isinstance(value, bool) or not math.isfinite(value):
        raise GenerateError(f"{subject} with {value!r}: expected a finite number")
