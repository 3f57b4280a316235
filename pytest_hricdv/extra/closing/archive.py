"""The archive of all runs: the targets that are still open, and the best test for each point."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.generate.abstract import AbstractTest

GIVEN = "given"
"""Stands for the strategy of tests from a suite that existed before the loop."""


@dataclass(frozen=True)
class ArchivedRun:
    """A run in the archive.

    Args:
        number: from 0, in the order of proposals.
        test: that was run.
        observation: what it yielded.
        strategy: that proposed it.
        targets: the points that it was to hit.
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
