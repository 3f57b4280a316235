"""The choice among the ways to reach points: for each kind of open points, by what has hit such points lately."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import NamedTuple

from pytest_hricdv.generate.rng import weighted

FADING = 0.9
"""After each generation that hit new points of a kind, what was before counts so much less for this kind: what pays off
at the beginning does not at the end. As long as nothing pays off, nothing is forgotten."""

LEAST = 0.004
"""No way gets a smaller weight, so that one that pays off later is found."""

FIRST = 0.1
"""The share of tests of a way that are expected to hit a new point of a kind, as long as nothing is known of it."""

TRIES = 4.0
"""This weighs as much as so many tests."""

EAGERNESS = 2
"""Shares are in proportion to this power of the weights."""


class Result(NamedTuple):
    """What a test has brought.

    Args:
        way: that proposed it.
        hit: the kinds of its new points.
        aimed: the kinds of points that it was aimed at.
    """

    way: str
    hit: frozenset[str] = frozenset()
    aimed: frozenset[str] = frozenset()


class Bandit:
    """Chooses ways, as a bandit with fading memory does.

    Args:
        names: of the ways.
        kinds: of points.
    """

    def __init__(self, names: Iterable[str], kinds: Iterable[str]) -> None:
        self._ways = tuple(names)
        self._tests = {kind: dict.fromkeys(self._ways, 0.0) for kind in kinds}
        self._paid = {kind: dict.fromkeys(self._ways, 0.0) for kind in self._tests}

    def weight(self, name: str, kind: str) -> float:
        """The share of the way's tests that hit a new point of a kind, as if it had been `FIRST` in `TRIES` before."""
        return max(LEAST, (self._paid[kind][name] + FIRST * TRIES) / (self._tests[kind][name] + TRIES))

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
            shares[weighted(rng, {name: self.weight(name, kind) ** EAGERNESS for name in names})] += 1
        return shares

    def learn(self, results: Iterable[Result]) -> None:
        """Learn from a generation: a test says something of the kinds of points that it was aimed at; without aims, of
        all. Tests of other ways do not count."""
        found = [each for each in results if each.way in self._ways]
        for kind, tests in self._tests.items():
            paid = self._paid[kind]
            telling = [each for each in found if not each.aimed or kind in each.aimed]
            if any(kind in each.hit for each in telling):
                for name in tests:
                    tests[name] *= FADING
                    paid[name] *= FADING
            for each in telling:
                tests[each.way] += 1.0
                paid[each.way] += kind in each.hit
