"""Climbing: scripts that may come nearer to a point that has a distance than any run has.

By interactions: how much nearer runs are for each interaction that ends in a certain way is learned, and scripts are
tried whose interactions will probably end so. By beliefs: they are drawn as often as the nearest runs have them, by the
cross-entropy method.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from random import Random
from statistics import median

from pytest_hricdv.close.archive import Archive, Entry
from pytest_hricdv.close.cross_entropy import elite_size
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import UNDISTURBED, Goal, treated
from pytest_hricdv.close.regression import regression
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.generate.rng import pick, weighted

BEST = 4
"""One of so many scripts is tried that will probably come nearest, each half as often as the one before."""

LEAST_RUNS = 8
"""Fewer runs say nothing."""

PATIENCE = 8.0
"""After so many runs of a script in vain, it is expected to come half as near."""

BY_INTERACTIONS = 0.75
"""So often scripts are chosen by how interactions end, where that makes a difference; otherwise by beliefs."""


class Climbing:
    """Finds scripts.

    Args:
        scripts: of the model.
        experience: of all runs so far.
        archive: of all runs so far.
    """

    def __init__(self, scripts: Scripts, experience: Experience, archive: Archive) -> None:
        self._scripts = scripts
        self._experience = experience
        self._near: dict[Point, list[tuple[float, Entry]]] = {}
        for entry in archive.entries:
            for point, distance in entry.observation.distances:
                if point in archive.open:
                    self._near.setdefault(point, []).append((distance, entry))
        self._best: dict[Point, list[int]] = {}

    def script(self, rng: Random) -> tuple[int, Point] | None:
        """A script, and the point that it is to come nearer to; None where no open point has a distance."""
        if not self._near:
            return None
        point = pick(rng, [*self._near])
        if point not in self._best:
            self._best[point] = self._by_interactions(self._near[point])
        best = self._best[point]
        if best and rng.random() < BY_INTERACTIONS:
            return weighted(rng, {script: 0.5**rank for rank, script in enumerate(best)}), point
        script = self._by_beliefs(self._near[point], rng)
        return None if script is None else (script, point)

    def _by_interactions(self, near: Sequence[tuple[float, Entry]]) -> list[int]:
        """The scripts whose interactions will probably end so that the run is nearest.

        Of a script, as many interactions count as any run had: a run may end before its script. One that was run
        in vain is expected to come less near, and an interaction that was rarely tried is expected to end better than
        it did: what is better may have failed once by chance, and would never be tried again.
        """
        chances: dict[Slot, float] = {}
        for product, recipes in self._experience.recipes.items():
            drawing = self._drawing(product, near)
            for slot in (each for each in self._scripts.by_slot if each.product == product):
                nearer = sum(recipes.chance(slot.planned, UNDISTURBED, goal) * each for goal, each in drawing.items())
                tries = recipes.weight_of_tries(slot.planned, UNDISTURBED)
                chances[slot] = (nearer * tries + max(drawing.values(), default=0.0)) / (tries + 1.0)
        if not any(chance > 0.0 for chance in chances.values()):
            return []
        most = max((len(hits) for _, entry in near for hits in entry.observation.hits.values()), default=0)
        vain = Counter(entry.test.lines for _, entry in near)
        worth = []
        for number, run in enumerate(self._scripts.runs):
            nearer = sum(chances[slot] for slot in self._scripts.slots(number)[:most])
            worth.append((-nearer * PATIENCE / (PATIENCE + vain[run.lines] * (nearer > 0.0)), number))
        return [number for _, number in sorted(worth)[:BEST]]

    def _drawing(self, product: str, near: Sequence[tuple[float, Entry]]) -> dict[Goal, float]:
        """How much nearer a run is for each interaction that ends so, other things being equal (linear regression).

        Of the nearer runs if they differ: what keeps the others far away may be something else.
        """
        nearer = _nearer(near)
        size = self._experience.recipes[product].coordinates
        counts = [
            Counter((product, *hit[size:]) for hit in entry.observation.hits.get(product, ())) for _, entry in nearer
        ]
        goals = sorted({goal for each in counts for goal in each})
        rows = [[float(each[goal]) for goal in goals] for each in counts]
        slopes = regression(rows, [distance for distance, _ in nearer])
        return {goal: -slope for goal, slope in zip(goals, slopes, strict=True)}

    def _by_beliefs(self, near: Sequence[tuple[float, Entry]], rng: Random) -> int | None:
        """A script of beliefs like those of the undisturbed runs that came nearest; None where all are as far away."""
        far = max(distance for distance, _ in near)
        runs = [(distance, entry.number, entry.test) for distance, entry in near if not treated(entry.test.lines)]
        nearer = sorted((each for each in runs if each[0] < far), key=lambda each: each[:2])
        elite = [test for _, _, test in nearer[: elite_size(len(nearer))]]
        if not elite:
            return None
        counts = Counter(belief for test in elite for belief in test.beliefs)
        shares = {belief: count / len(elite) for belief, count in counts.items()}
        return self._scripts.of_beliefs(self._scripts.drawn_beliefs(shares, rng))


def _nearer(near: Sequence[tuple[float, Entry]]) -> Sequence[tuple[float, Entry]]:
    """The runs that are nearer than the median, or at least as near, or all: the first that say something."""
    middle = median(distance for distance, _ in near)
    for found in ([each for each in near if each[0] < middle], [each for each in near if each[0] <= middle]):
        if len(found) >= LEAST_RUNS and len({distance for distance, _ in found}) > 1:
            return found
    return near
