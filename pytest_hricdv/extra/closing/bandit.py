"""A multi-armed bandit that chooses among the ways: for each kind of points, by what has lately hit such points.

What pays off at the beginning does not at the end, so earlier rewards are discounted (Garivier, Moulines: On
Upper-Confidence Bound Policies for Non-Stationary Bandit Problems, arXiv 0805.3415). Ways are drawn in proportion to
their rate of success.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import NamedTuple

from pytest_hricdv.generate.rng import weighted

DISCOUNT = 0.9
"""After each generation that hit new points of a kind, what was before counts so much less for this kind: what pays off
at the beginning does not at the end. As long as nothing pays off, nothing is forgotten. A discount is that of Garivier
and Moulines (On Upper-Confidence Bound Policies for Non-Stationary Bandit Problems, arXiv 0805.3415); its value is
chosen: some ten such generations count (0.8: -0.7 +- 0.5, 0.95: -4.4 +- 4.9; see the package)."""


class Reward(NamedTuple):
    """What a test has brought.

    Args:
        way: that proposed it.
        hit: the kinds of its new points.
        targeted: the kinds of its targets.
    """

    way: str
    hit: frozenset[str] = frozenset()
    targeted: frozenset[str] = frozenset()


class Bandit:
    """Chooses ways, as a bandit with discounted rewards does.

    Args:
        names: of the ways.
        kinds: of points.
    """

    def __init__(self, names: Iterable[str], kinds: Iterable[str]) -> None:
        self._ways = tuple(names)
        self._tests = {kind: dict.fromkeys(self._ways, 0.0) for kind in kinds}
        self._hits = {kind: dict.fromkeys(self._ways, 0.0) for kind in self._tests}

    def weight(self, name: str, kind: str) -> float:
        """The share of the way's tests that hit a new point of a kind, by Jeffreys' prior (half of one test)."""
        return (self._hits[kind][name] + 0.5) / (self._tests[kind][name] + 1.0)

    def shares(self, names: Sequence[str], count: int, kinds: Mapping[str, int], rng: Random) -> dict[str, int]:
        """How many of `count` tests each of these ways may propose.

        For each test a kind is drawn in proportion to its open points, and for this kind a way.

        Args:
            names: of the ways.
            count: of tests.
            kinds: kind -> how many points are open.
            rng: of which only `random()` is used.
        """
        shares = dict.fromkeys(names, 0)
        for _ in range(count if names and kinds else 0):
            kind = weighted(rng, kinds)
            shares[weighted(rng, {name: self.weight(name, kind) for name in names})] += 1
        return shares

    def learn(self, rewards: Iterable[Reward]) -> None:
        """Learn from a generation: a test says something of the kinds of its targets; without targets, of all. Tests of
        other ways do not count."""
        own = [reward for reward in rewards if reward.way in self._ways]
        for kind, tests in self._tests.items():
            hits = self._hits[kind]
            telling = [reward for reward in own if not reward.targeted or kind in reward.targeted]
            if any(kind in reward.hit for reward in telling):
                for name in tests:
                    tests[name] *= DISCOUNT
                    hits[name] *= DISCOUNT
            for reward in telling:
                tests[reward.way] += 1.0
                hits[reward.way] += kind in reward.hit
