"""The choice among the ways to reach points: each gets tests in proportion to what its tests have paid off lately."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from random import Random

from pytest_hricdv.generate.rng import weighted

FADING = 0.9
"""After each generation, what was before counts so much less: what pays off at the beginning does not at the end."""

LEAST = 0.07
"""No way gets a smaller weight, so that one that pays off later is found."""


EAGERNESS = 2
"""Shares are in proportion to this power of the weights."""


class Bandit:
    """Chooses ways, as a bandit with fading memory does.

    Args:
        names: of the ways.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._tests = dict.fromkeys(names, 0.0)
        self._paid = dict.fromkeys(self._tests, 0.0)

    def weight(self, name: str) -> float:
        """The share of the way's tests that hit something new, estimated with one success in two tests before all."""
        return max(LEAST, (self._paid[name] + 1.0) / (self._tests[name] + 2.0))

    def shares(self, names: Sequence[str], count: int, rng: Random) -> dict[str, int]:
        """How many of `count` tests each of these ways may propose: drawn in proportion to the weights."""
        shares, weights = dict.fromkeys(names, 0), {name: self.weight(name) ** EAGERNESS for name in names}
        for _ in range(count if names else 0):
            shares[weighted(rng, weights)] += 1
        return shares

    def learn(self, results: Iterable[tuple[str, bool]]) -> None:
        """Learn from a generation: for each test, its way and whether it hit something new. Others do not count."""
        for name in self._tests:
            self._tests[name] *= FADING
            self._paid[name] *= FADING
        for name, paid in results:
            if name in self._tests:
                self._tests[name] += 1.0
                self._paid[name] += paid
