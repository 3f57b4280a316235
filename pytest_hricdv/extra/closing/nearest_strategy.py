"""The strategy `nearest`: varies the runs that came nearest to open points.

`NearestStrategy.propose`, called by the closing loop, varies such a run in two ways. If some runs came nearer than
others, as to a count, it repeats an interaction of the nearest run throughout a test. To any nearest run, it adds a
disturbance next to each one in the run, until each was tried: a point may need two at one place.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.disturbance_strategy import Disturbances, draw_intervention
from pytest_hricdv.extra.closing.pool import (
    UNDISTURBED,
    Combination,
    PlannedInteraction,
    Pool,
    combinations_of,
    commands_of,
    interactions_of,
)
from pytest_hricdv.extra.closing.strategy import Archive, ArchivedRun, Proposal
from pytest_hricdv.extra.closing.targets import closest_runs
from pytest_hricdv.generate.rng import pick, shuffle

REPEATING = 0.5
"""Share of tests that repeat an interaction instead of adding a disturbance, if both are possible."""


class NearestStrategy:
    """Varies the runs that came nearest to open points."""

    name = "nearest"

    def __init__(self, pool: Pool, disturbances: Disturbances) -> None:
        self._pool = pool
        self._disturbances = disturbances

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        nearest = _Nearest(self._pool, self._disturbances, archive, rng)
        proposals = (nearest.propose() for _ in range(count))
        return [proposal for proposal in proposals if proposal is not None]


class _Nearest:
    """The runs of the archive that came nearest to open points, for one generation."""

    def __init__(self, pool: Pool, disturbances: Disturbances, archive: Archive, rng: Random) -> None:
        self._pool = pool
        self._disturbances = disturbances
        self._rng = rng
        self._run_lines = {entry.test.lines for entry in archive.entries}
        self._advanced: dict[tuple[int, ...], list[Point]] = {}
        """Numbers of runs -> the open points to which these came nearer than all others."""
        self._disturbed: dict[int, list[Point]] = {}
        """The nearest run of those with disturbances -> the points; of equally near ones, it has the fewest."""
        self._entries = archive.entries
        for point in archive.open:
            near = closest_runs(point, archive) if point[0] != "bin" else []
            if near and near[0][0] < near[-1][0]:
                numbers = tuple(entry.number for distance, entry in near if distance == near[0][0])
                self._advanced.setdefault(numbers, []).append(point)
            disturbed = [
                (distance, count, entry.number)
                for distance, entry in near
                if (count := len(entry.test.lines) - len(commands_of(entry.test.lines)))
                and commands_of(entry.test.lines) in pool.by_commands
            ]
            if disturbed:
                self._disturbed.setdefault(min(disturbed)[2], []).append(point)

    def propose(self) -> Proposal | None:
        """A test of either kind; None if there is none."""
        if self._rng.random() < REPEATING:
            return self._repeat() or self._add()
        return self._add() or self._repeat()

    def _repeat(self) -> Proposal | None:
        """A test with an interaction of a nearest run as often as any test has it, each with the same disturbances."""
        for numbers in shuffle(self._rng, [*self._advanced]):
            entry = self._entries[pick(self._rng, numbers)]
            interactions = [*self._interactions_of(entry)]
            if interactions:
                planned, combination = pick(self._rng, interactions)
                test = self._fullest(planned)
                combinations = [
                    combination if other == planned else UNDISTURBED
                    for other in self._pool.interactions_of(test, planned.product)
                ]
                draft = self._pool.draft(test, planned.product, combinations)
                return Proposal(draft, NearestStrategy.name, tuple(self._advanced[numbers]))
        return None

    def _interactions_of(self, entry: ArchivedRun) -> Iterator[tuple[PlannedInteraction, Combination]]:
        """The interactions of a run that tests of the pool have, too, with their disturbances."""
        test = entry.test
        for product, planned in self._pool.planned.items():
            for interaction in interactions_of(test.lines, test.values, entry.observation.hits, product, planned):
                place = PlannedInteraction(product, interaction.planned)
                if place in self._pool.by_interaction:
                    yield place, interaction.combination

    def _fullest(self, planned: PlannedInteraction) -> int:
        """A test that has an interaction as often as any."""
        tests: dict[int, list[int]] = {}
        for number in self._pool.by_interaction[planned]:
            tests.setdefault(self._pool.interactions(number).count(planned), []).append(number)
        return pick(self._rng, tests[max(tests)])

    def _add(self) -> Proposal | None:
        """The test of a nearest run with one more disturbance next to each of its own, until each was tried."""
        for number in shuffle(self._rng, [*self._disturbed]):
            lines, values = self._entries[number].test.lines, self._entries[number].test.values
            test, product = self._pool.by_commands[commands_of(lines)], next(iter(self._pool.planned), "")
            own = combinations_of(lines, values, self._pool.starts(test, product))
            for name in shuffle(self._rng, [*self._disturbances]):
                draft = self._pool.draft(test, product, [self._beside(name, combination) for combination in own])
                if draft.lines not in self._run_lines:
                    self._run_lines.add(draft.lines)
                    return Proposal(draft, NearestStrategy.name, tuple(self._disturbed[number]))
        return None

    def _beside(self, name: str, combination: Combination) -> Combination:
        places = dict.fromkeys(intervention.place for intervention in combination)
        added = (draw_intervention(self._disturbances, name, place, self._rng) for place in places)
        return (*combination, *added)
