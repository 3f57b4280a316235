"""Samplers: the declared ranges that concrete parameters are drawn from."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from .error import GenerateError
from .stream import pick


class Sampler(ABC):
    """Draws one parameter's value from a private stream."""

    unit: str = ""

    @abstractmethod
    def sample(self, random: Random) -> float:
        """A value. The stream is this parameter's own and used for nothing else."""

    def corners(self) -> tuple[float, ...]:
        """The extreme values; none for a sampler that knows none."""
        return ()

    def shown(self, value: float) -> str:
        """A value with its unit, for people."""
        return f"{value:.6g} {self.unit}".rstrip()


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

    def corners(self) -> tuple[float, ...]:
        """The value."""
        return (float(self.value),)


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

    def corners(self) -> tuple[float, ...]:
        """Both ends; of a half-open range, the greatest number below its high end."""
        return (float(self.low), self.clipped(self.high))

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

    def corners(self) -> tuple[float, ...]:
        """That it does not happen, and where it does, the extreme values."""
        return (0.0, *self.then.corners()) if self.probability > 0.0 else (0.0,)

    def shown(self, value: float) -> str:
        """As `then` shows it."""
        return self.then.shown(value)


#: How parameters are drawn: a function of the sampler and of the parameter's own stream.
Sampling = Callable[[Sampler, Random], float]

_AT_A_CORNER = 0.5


def uniform(sampler: Sampler, random: Random) -> float:
    """As the range is declared."""
    return sampler.sample(random)


def corners(sampler: Sampler, random: Random) -> float:
    """Half of the time an extreme value, each as likely as the others; otherwise as the range is declared.

    Faults live where several parameters are extreme at once, and uniform drawing hardly ever gets there. What is
    declared to be rare comes often.
    """
    extremes = sampler.corners()
    if extremes and random.random() < _AT_A_CORNER:
        return pick(random, extremes)
    return sampler.sample(random)


SAMPLINGS: Mapping[str, Sampling] = {"uniform": uniform, "corners": corners}


def _check_finite(what: str, value: float) -> None:
    if not math.isfinite(value):
        raise GenerateError(f"{what} with {value!r}: expected a finite number")
