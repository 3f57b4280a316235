"""Guidance by distance (fitness): abstract tests that may come nearer to an open point than any run has.

By interactions: a linear regression says how much nearer runs are for each interaction that ends with a certain
outcome, and tests are tried that will probably come nearer than any run has. By beliefs: these are drawn as often as
the nearest runs have them, by the cross-entropy method.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from statistics import fmean, median

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.extra.closing.distance import elite_size
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Outcome, PlannedInteraction, is_disturbed
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.strategy import favoured
from pytest_hricdv.generate.rng import pick

MIN_RUNS = 8
"""Fewer runs say nothing. Chosen (4: no change, 16: no change; see the package). Guidance without this and
`PRIOR_TRUST` changed the share of open targets by +0.1 +- 0.1 points, within chance (ten scenes)."""

PRIOR_TRUST = 0.9
"""How probably a test comes nearer is learned rightly with this probability, before it is tried. Chosen (0.8: no
change, 0.95: no change; see the package); measured with `MIN_RUNS`, too."""

BY_INTERACTIONS = 0.75
"""So often tests are chosen by how interactions end, where that makes a difference; otherwise by beliefs. Chosen (0.5:
+0.1 +- 0.4, 0.9: -2.3 +- 3.5; see the package)."""

DIGITS = 6
"""Distances that differ in further decimal places are the same. Chosen: sums of slopes in another order differ from
about the 15th place on (4: no change, 9: -1.7 +- 3.4; see the package)."""

RIDGE = 1.0
"""Keeps slopes small of which the data say nothing: as if each variable had varied by 1 once, without an effect. Ridge
regression is that of Hoerl and Kennard (Technometrics 12, 1970). Chosen (0.5: no change, 2: no change; see the
package)."""

Ends = tuple[tuple[float, float], ...]
"""How an interaction may end: how much nearer a run is then, and how probable this is."""

Near = Sequence[tuple[float, Entry]]
"""Runs with their distances from a point."""


class Guidance:
    """Finds tests.

    Args:
        pool: of abstract tests.
        experience: of all runs so far.
        archive: of all runs so far.
    """

    def __init__(self, pool: Pool, experience: Experience, archive: Archive) -> None:
        self._pool = pool
        self._experience = experience
        self._near: dict[Point, list[tuple[float, Entry]]] = {}
        for entry in archive.entries:
            for point, distance in entry.observation.distances:
                if point in archive.open:
                    self._near.setdefault(point, []).append((distance, entry))
        self._best: dict[Point, dict[int, float]] = {}

    def test(self, rng: Random) -> tuple[int, Point] | None:
        """A test, and the point that it is to come nearer to; None where no open point has a distance."""
        if not self._near:
            return None
        point = pick(rng, [*self._near])
        if point not in self._best:
            self._best[point] = self._by_interactions(self._near[point])
        best = self._best[point]
        if best and rng.random() < BY_INTERACTIONS:
            return favoured(rng, best), point
        number = self._by_beliefs(self._near[point], rng)
        return None if number is None else (number, point)

    def _by_interactions(self, near: Near) -> dict[int, float]:
        """The tests that will most probably come nearer than any run has, and how probably, by how interactions end.

        Of a test, as many interactions count as any run had: a run may end before its test. What is learned of one
        that was run in vain is trusted less, by Bayes' theorem: the more probable a success was, the more a failure
        says that it was expected wrongly.
        """
        gains = {product: self._gains(product, near) for product in self._experience.models}
        ends = {
            interaction: self._ends(interaction, gains[interaction.product])
            for interaction in self._pool.by_interaction
        }
        nearest = max(self._gain(entry, gains) for _, entry in near)
        most = max((len(hits) for _, entry in near for hits in entry.observation.hits.values()), default=0)
        vain = Counter(entry.test.lines for _, entry in near)
        chances: dict[tuple[PlannedInteraction, ...], float] = {}
        trusted: list[tuple[float, int]] = []
        for number, test in enumerate(self._pool.tests):
            interactions = tuple(sorted(self._pool.interactions(number)[:most]))
            if interactions not in chances:
                chances[interactions] = _chance_beyond(nearest, [ends[interaction] for interaction in interactions])
            chance = chances[interactions]
            failures = PRIOR_TRUST * (1.0 - chance) ** vain[test.lines]
            trust = failures / (failures + 1.0 - PRIOR_TRUST)
            trusted.append((chance * trust, number))
        return {number: chance for chance, number in trusted if chance > 0.0}

    def _ends(self, interaction: PlannedInteraction, gains: Mapping[Outcome, float]) -> Ends:
        """How an interaction may end: how much nearer that is, and how probable.

        As if one more try had ended best: what failed once by chance would otherwise never be tried again.
        """
        model = self._experience.models[interaction.product]
        chances = {outcome: model.chance(interaction.planned, UNDISTURBED, outcome) for outcome in gains}
        tries, total = model.weight_of_tries(interaction.planned, UNDISTURBED), max(1.0, sum(chances.values()))
        ends = [(gains[outcome], chance / total * tries / (tries + 1.0)) for outcome, chance in chances.items()]
        return (*ends, (max(gains.values(), default=0.0), 1.0 / (tries + 1.0)))

    def _gain(self, entry: Entry, gains: Mapping[str, Mapping[Outcome, float]]) -> float:
        """How much nearer a run is than one without interactions, by how they ended."""
        gain = 0.0
        for product, nearer in gains.items():
            size = self._experience.models[product].coordinates
            gain += sum(nearer.get((product, *hit[size:]), 0.0) for hit in entry.observation.hits.get(product, ()))
        return gain

    def _gains(self, product: str, near: Near) -> dict[Outcome, float]:
        """How much nearer a run is for each interaction with an outcome, other things being equal (linear regression).

        Of the nearer runs if they differ: what keeps the others far away may be something else.
        """
        nearer = _nearer(near)
        size = self._experience.models[product].coordinates
        counts = [
            Counter((product, *hit[size:]) for hit in entry.observation.hits.get(product, ())) for _, entry in nearer
        ]
        outcomes = sorted({outcome for count in counts for outcome in count})
        rows = [[float(count[outcome]) for outcome in outcomes] for count in counts]
        slopes = regression(rows, [distance for distance, _ in nearer])
        return {outcome: -slope for outcome, slope in zip(outcomes, slopes, strict=True)}

    def _by_beliefs(self, near: Near, rng: Random) -> int | None:
        """A test of beliefs like those of the undisturbed runs that came nearest; None where all are as far away."""
        far = max(distance for distance, _ in near)
        runs = [(distance, entry.number, entry.test) for distance, entry in near if not is_disturbed(entry.test.lines)]
        nearer = sorted((run for run in runs if run[0] < far), key=lambda run: run[:2])
        elite = [test for _, _, test in nearer[: elite_size(len(nearer))]]
        if not elite:
            return None
        counts = Counter(belief for test in elite for belief in test.beliefs)
        shares = {belief: count / len(elite) for belief, count in counts.items()}
        return self._pool.of_beliefs(self._pool.drawn_beliefs(shares, rng))


def _chance_beyond(nearest: float, interactions: Iterable[Ends]) -> float:
    """How probably interactions, which end independently, bring a run nearer than this."""
    sums = {0.0: 1.0}
    for ends in interactions:
        following: dict[float, float] = {}
        for nearer, chance in ends:
            for before, chance_before in sums.items():
                reached = round(before + nearer, DIGITS)
                following[reached] = following.get(reached, 0.0) + chance * chance_before
        sums = following
    return sum(chance for reached, chance in sums.items() if reached > nearest + 10.0**-DIGITS)


def _nearer(near: Near) -> Near:
    """The runs that are nearer than the median, or at least as near, or all: the first that say something."""
    middle = median(distance for distance, _ in near)
    for nearer in ([run for run in near if run[0] < middle], [run for run in near if run[0] <= middle]):
        if len(nearer) >= MIN_RUNS and len({distance for distance, _ in nearer}) > 1:
            return nearer
    return near


def regression(rows: Sequence[Sequence[float]], values: Sequence[float]) -> list[float]:
    """The slope of a value along each variable, by least squares (ridge regression).

    Args:
        rows: the variables of each observation.
        values: of the observations.
    """
    if not rows or not rows[0]:
        return []
    size, means = len(rows[0]), [fmean(column) for column in zip(*rows, strict=True)]
    centred = [[value - mean for value, mean in zip(row, means, strict=True)] for row in rows]
    mean = fmean(values)
    matrix = [
        [sum(row[i] * row[j] for row in centred) + RIDGE * (i == j) for j in range(size)]
        + [sum(row[i] * (value - mean) for row, value in zip(centred, values, strict=True))]
        for i in range(size)
    ]
    for i in range(size):  # Gauss and Jordan; no pivot is 0, for the ridge makes the matrix positive definite
        pivot = matrix[i][i]
        matrix[i] = [value / pivot for value in matrix[i]]
        for j in range(size):
            if j != i:
                matrix[j] = [a - matrix[j][i] * b for a, b in zip(matrix[j], matrix[i], strict=True)]
    return [row[size] for row in matrix]
