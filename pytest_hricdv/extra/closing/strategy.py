"""The interface of search strategies (`Strategy`), and the archive of all runs (`Archive`).

The `Loop` adds each run to the archive as an `ArchivedRun`, and calls `propose` of the strategies for each generation.
They make `Proposal`s from the archive alone: from the targets that are still open, and the best run for each point.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Protocol, TypeVar

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest
from pytest_hricdv.generate.rng import pick_weighted

GIVEN = "given"
"""The name, in place of a strategy, for tests from suites that existed before the loop."""


@dataclass(frozen=True)
class ArchivedRun:
    """A run in the archive.

    Args:
        number: from 0, in the order of proposals.
        strategy: the strategy that proposed the test.
        targets: the points that the test was to hit.
        new: the targets of the loop that it hit and that no earlier run had hit.
    """

    number: int
    test: AbstractTest
    observation: RunObservation
    strategy: str = GIVEN
    targets: tuple[Point, ...] = ()
    new: tuple[Point, ...] = ()


class Archive:
    """The archive of all runs so far.

    Args:
        targets: the points that are to be hit, in the order in which they are listed.
    """

    def __init__(self, targets: Iterable[Point]) -> None:
        self.targets = tuple(dict.fromkeys(targets))
        self.entries: list[ArchivedRun] = []
        self.open: dict[Point, None] = dict.fromkeys(self.targets)
        """The targets that no run has hit, in order; used as an ordered set."""
        self.best: dict[Point, ArchivedRun] = {}
        """The run that hits a point in the shortest simulated time; of equal ones the first."""
        self.hit_by: dict[Point, list[int]] = {}
        """The numbers of the runs that hit a point, in order."""
        self.tries: Counter[Point] = Counter()
        """Point -> number of runs that had it as a target while it was open."""
        self.sim_s = 0.0
        """Simulated time of all runs (s)."""

    def add(self, observation: RunObservation, strategy: str = GIVEN, targets: tuple[Point, ...] = ()) -> ArchivedRun:
        """Keep a run. Runs have to be added in the order in which they were proposed."""
        test = AbstractTest.from_data(observation.test)
        self.tries.update(point for point in targets if point in self.open)
        new = tuple(point for point in observation.points if point in self.open)
        entry = ArchivedRun(len(self.entries), test, observation, strategy, targets, new)
        self.entries.append(entry)
        self.sim_s += observation.sim_s
        for point in observation.points:
            self.open.pop(point, None)
            self.hit_by.setdefault(point, []).append(entry.number)
            best = self.best.get(point)
            if best is None or observation.sim_s < best.observation.sim_s:
                self.best[point] = entry
        return entry


T = TypeVar("T")

CHOICES, PRESSURE = 4, 3
"""Number of best choices among which one is drawn, in proportion to this power of how good it is; see the package."""


@dataclass(frozen=True)
class Proposal:
    """A test that a strategy proposes to run.

    Args:
        draft: the test, with the values that are chosen for it.
        strategy: the name of the strategy that proposes it.
        targets: the points that it is to hit.
        is_online: whether the person decides during the run. The test is then what it became.
    """

    draft: AbstractDraft
    strategy: str
    targets: tuple[Point, ...] = ()
    is_online: bool = False


class Strategy(Protocol):
    """One search strategy."""

    @property
    def name(self) -> str:
        """The name in progress lines, reports and the choice among strategies."""

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """Propose at most `count` tests to run next; fewer, or none, if this strategy has nothing else to try.

        The result depends only on the archive and the random stream, not on earlier proposals. Only `rng.random()` is
        used (see `pytest_hricdv.generate.rng`).
        """


def draw_good(rng: Random, worth: Mapping[T, float]) -> T:
    """One of the best, drawn in favour of the better ones; among equal ones, the first are kept."""
    best = sorted(worth, key=lambda choice: -worth[choice])[:CHOICES]
    return pick_weighted(rng, {choice: worth[choice] ** PRESSURE for choice in best})
