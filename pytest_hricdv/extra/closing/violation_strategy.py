"""The strategy `violations`: varies the parameters of the runs that came nearest to violating a requirement.

The closing loop asks `ViolationStrategy` for proposals while it stalls and after it has ended. The search is that of
`pytest_hricdv.experiments`, a (1+1) evolution strategy with the 1/5 success rule, on all runs of the loop, a generation
at a time. It aims at the requirements that are not violated, those with the smallest margins first, and at alternatives
of a response that never were decisive (`vacuous_alternatives`). For these no distance is known: it varies widely.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.experiments.evolution_strategy import FIRST_WIDTH, PATIENCE, mutate, next_width
from pytest_hricdv.extra.closing.observation import KNOWN, NEW
from pytest_hricdv.extra.closing.strategy import Archive, ArchivedRun, Proposal
from pytest_hricdv.generate.abstract import AbstractDraft
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, concretize, values_of

NAME = "violations"

STARTS = 5
"""Number of runs that are varied for a requirement, one after the other, as in `extra.search`."""

WIDE = 0.5
"""Step of a parameter, as a share of its range, if no distance is known."""


@dataclass(frozen=True)
class Aim:
    """A search goal: a violation of a requirement, or a run in which a part of it decides.

    Args:
        target: the point that proposals for it aim at.
        starts: the runs that are varied, the nearest first.
        margin: the least one of these runs; None if nothing is compared. spread: the spread of the margins of all runs.
    """

    target: Point
    starts: Sequence[ArchivedRun]
    margin: float | None = None
    spread: float = 0.0

    @property
    def share(self) -> float:
        """The margin in proportion to the spread; 1 without a margin, infinite if all are the same."""
        if self.margin is None:
            return 1.0
        return max(self.margin, 0.0) / self.spread if self.spread > 0.0 else math.inf


class ViolationStrategy:
    """Varies the parameters of the runs that came nearest to a violation.

    Args:
        requirements: their ids, in order.
        space: the ranges of all parameters.
    """

    name = NAME

    def __init__(self, requirements: Sequence[str], space: Concretization) -> None:
        self._requirements = tuple(requirements)
        self._space = space
        self._drawn: dict[int, ConcreteTest] = {}

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        violating = _violations_by_requirement(archive)
        aims = [*self._aims(archive, violating)]
        failures, widths = {}, {}
        for aim in aims:
            failures[aim.target], widths[aim.target] = _progress(archive, aim, violating.get(aim.target[1], ()))
        proposals: list[Proposal] = []
        used = Counter[Point]()
        while aims and len(proposals) < count:
            # The nearest first, until it has not come nearer for a while; two of a generation for one aim.
            aim = min(aims, key=lambda aim: (used[aim.target] // 2, failures[aim.target] // PATIENCE, aim.share))
            start = aim.starts[(failures[aim.target] // PATIENCE) % len(aim.starts)]
            draft = self._vary(start, widths[aim.target], rng)
            if draft is None:
                aims.remove(aim)  # none of its parameters can have another value
                continue
            used[aim.target] += 1
            proposals.append(Proposal(draft, NAME, (aim.target,)))
        return proposals

    def _concrete(self, entry: ArchivedRun) -> ConcreteTest:
        """The test of a run with its parameters, which is drawn once."""
        if entry.number not in self._drawn:
            self._drawn[entry.number] = concretize(entry.test, self._space)
        return self._drawn[entry.number]

    def _vary(self, start: ArchivedRun, width: float, rng: Random) -> AbstractDraft | None:
        test, before = start.test, self._concrete(start)
        after = mutate(before, self._space, width, rng)
        if after == before:
            return None
        values = values_of(after)
        return AbstractDraft(
            test.target, test.beliefs, test.lines, test.plans, values=values, seed=test.seed, after=test.after
        )

    def _aims(self, archive: Archive, violating: Mapping[str, Container[int]]) -> Iterator[Aim]:
        violated = {point[1] for point in archive.hit_by if point[0] == NEW}
        for name in self._requirements:
            others = violating.get(name, ())
            triggered = [entry for entry in archive.entries if name in entry.observation.unused]
            runs = [entry for entry in triggered if entry.number not in others]
            if name in violated or not runs:
                continue
            margins = {entry.number: entry.observation.margins.get(name, math.inf) for entry in runs}
            nearest = sorted(runs, key=lambda entry: (margins[entry.number], -entry.number))
            finite = [margin for margin in margins.values() if margin < math.inf]
            spread = max(finite) - min(finite) if finite else 0.0
            yield Aim((NEW, name), nearest[:STARTS], min(finite, default=None), spread)
            for part in vacuous_alternatives(archive, name):
                yield Aim(("part", name, part), nearest[:STARTS])


def _violations_by_requirement(archive: Archive) -> dict[str, set[int]]:
    """Requirement -> the runs that violate it, even if only as known: no run is closer to a new violation."""
    runs: dict[str, set[int]] = {}
    for point, numbers in archive.hit_by.items():
        if point[0] in (NEW, KNOWN):
            runs.setdefault(point[1], set()).update(numbers)
    return runs


def vacuous_alternatives(archive: Archive, requirement: str) -> tuple[str, ...]:
    """The alternatives of a requirement's response by which it never held, in any run that triggered it."""
    unused = [
        entry.observation.unused[requirement] for entry in archive.entries if requirement in entry.observation.unused
    ]
    first, *others = unused or [()]
    return tuple(part for part in first if all(part in parts for parts in others))


def _progress(archive: Archive, aim: Aim, violating: Container[int]) -> tuple[int, float]:
    """Number of recent runs for a target that came no closer, and how far the next one varies."""
    name, least = aim.target[1], math.inf
    failures, width = 0, WIDE if aim.margin is None else FIRST_WIDTH
    for entry in archive.entries:
        margin = math.inf if entry.number in violating else entry.observation.margins.get(name, math.inf)
        if entry.strategy == NAME and aim.target in entry.targets:
            improved = margin < least
            failures = 0 if improved else failures + 1
            width = WIDE if aim.margin is None else next_width(width, improved=improved)
        least = min(least, margin)
    return failures, width
