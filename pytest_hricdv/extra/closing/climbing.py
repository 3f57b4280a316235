"""Climbing: scripts that may come nearer to a point that has a distance than any run has.

By interactions: how much nearer runs are for each interaction that ends in a certain way is learned, and scripts are
tried that will probably come nearer than any run has. By beliefs: these are drawn as often as the nearest runs have
them, by the cross-entropy method.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from statistics import median

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.extra.closing.cross_entropy import elite_size
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Goal, treated
from pytest_hricdv.extra.closing.regression import regression
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.generate.rng import pick, weighted

BEST = 4
"""Of so many scripts that most probably come nearer, one is tried."""

EAGERNESS = 3
"""It is drawn in proportion to this power of its chance."""

LEAST_RUNS = 8
"""Fewer runs say nothing."""

TRUST = 0.9
"""What is learned says rightly, with this probability before it is tried, how probably a script comes nearer."""

BY_INTERACTIONS = 0.75
"""So often scripts are chosen by how interactions end, where that makes a difference; otherwise by beliefs."""

DIGITS = 6
"""Distances that differ in further decimal places are the same."""

Ends = tuple[tuple[float, float], ...]
"""How an interaction may end: how much nearer a run is then, and how probable this is."""


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
        self._best: dict[Point, dict[int, float]] = {}

    def script(self, rng: Random) -> tuple[int, Point] | None:
        """A script, and the point that it is to come nearer to; None where no open point has a distance."""
        if not self._near:
            return None
        point = pick(rng, [*self._near])
        if point not in self._best:
            self._best[point] = self._by_interactions(self._near[point])
        best = self._best[point]
        if best and rng.random() < BY_INTERACTIONS:
            return weighted(rng, {script: chance**EAGERNESS for script, chance in best.items()}), point
        script = self._by_beliefs(self._near[point], rng)
        return None if script is None else (script, point)

    def _by_interactions(self, near: Sequence[tuple[float, Entry]]) -> dict[int, float]:
        """The scripts that will most probably come nearer than any run has, and how probably, by how interactions end.

        Of a script, as many interactions count as any run had: a run may end before its script. What is learned of
        one that was run in vain is trusted less, by Bayes' theorem: the more probable a success was, the more a failure
        says that it was expected wrongly.
        """
        drawing = {product: self._drawing(product, near) for product in self._experience.recipes}
        ends = {slot: self._ends(slot, drawing[slot.product]) for slot in self._scripts.by_slot}
        nearest = max(self._nearness(entry, drawing) for _, entry in near)
        most = max((len(hits) for _, entry in near for hits in entry.observation.hits.values()), default=0)
        vain = Counter(entry.test.lines for _, entry in near)
        chances: dict[tuple[Slot, ...], float] = {}
        found: list[tuple[float, int]] = []
        for number, run in enumerate(self._scripts.runs):
            slots = tuple(sorted(self._scripts.slots(number)[:most]))
            if slots not in chances:
                chances[slots] = _chance_beyond(nearest, [ends[slot] for slot in slots])
            chance = chances[slots]
            failures = TRUST * (1.0 - chance) ** vain[run.lines]
            trust = failures / (failures + 1.0 - TRUST)
            found.append((chance * trust, number))
        best = sorted(found, key=lambda each: (-each[0], each[1]))[:BEST]
        return {number: chance for chance, number in best if chance > 0.0}

    def _ends(self, slot: Slot, drawing: Mapping[Goal, float]) -> Ends:
        """How an interaction may end: how much nearer that is, and how probable.

        As if one more try had ended best: what failed once by chance would otherwise never be tried again.
        """
        recipes = self._experience.recipes[slot.product]
        chances = {goal: recipes.chance(slot.planned, UNDISTURBED, goal) for goal in drawing}
        tries, every = recipes.weight_of_tries(slot.planned, UNDISTURBED), max(1.0, sum(chances.values()))
        ends = [(drawing[goal], chance / every * tries / (tries + 1.0)) for goal, chance in chances.items()]
        return (*ends, (max(drawing.values(), default=0.0), 1.0 / (tries + 1.0)))

    def _nearness(self, entry: Entry, drawing: Mapping[str, Mapping[Goal, float]]) -> float:
        """How much nearer a run is than one without interactions, by how they ended."""
        found = 0.0
        for product, nearer in drawing.items():
            size = self._experience.recipes[product].coordinates
            found += sum(nearer.get((product, *hit[size:]), 0.0) for hit in entry.observation.hits.get(product, ()))
        return found

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


def _chance_beyond(nearest: float, interactions: Iterable[Ends]) -> float:
    """How probably interactions, which end independently, bring a run nearer than this."""
    sums = {0.0: 1.0}
    for ends in interactions:
        following: dict[float, float] = {}
        for nearer, chance in ends:
            for before, of_this in sums.items():
                reached = round(before + nearer, DIGITS)
                following[reached] = following.get(reached, 0.0) + chance * of_this
        sums = following
    return sum(chance for reached, chance in sums.items() if reached > nearest + 10.0**-DIGITS)


def _nearer(near: Sequence[tuple[float, Entry]]) -> Sequence[tuple[float, Entry]]:
    """The runs that are nearer than the median, or at least as near, or all: the first that say something."""
    middle = median(distance for distance, _ in near)
    for found in ([each for each in near if each[0] < middle], [each for each in near if each[0] <= middle]):
        if len(found) >= LEAST_RUNS and len({distance for distance, _ in found}) > 1:
            return found
    return near
