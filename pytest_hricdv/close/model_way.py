"""The way of the model: scripts of beliefs that, by the survey of the model, lead to what is open.

Bins are reached by scripts that plan them, plans by beliefs that trigger them. Where a requirement was nearly
triggered, beliefs are drawn as often as the nearest runs have them (the cross-entropy method, on beliefs); where bins
are open of which it is unknown what plans them, scripts are tried that were not run yet.
"""

from __future__ import annotations

from collections import Counter
from random import Random

from pytest_hricdv.close.aiming import LEAST, Aiming, Option
from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.cross_entropy import elite_size
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import UNDISTURBED, Goal, Treatment, treated
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.rng import pick, shuffled

CLIMBING = 3
"""Of this many tests, one is to come nearer to a point that has a distance."""


class ModelWay:
    """Undisturbed scripts of the model.

    Args:
        scripts: of the model.
        experience: of all runs so far.
    """

    name = "model"

    def __init__(self, scripts: Scripts, experience: Experience) -> None:
        self._scripts = scripts
        self._experience = experience

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        if not self._scripts.runs:
            return []
        self._experience.learn(archive)
        aiming = Aiming(self._scripts, self._experience, archive, self._options)
        found: list[Proposal] = []
        for number in range(count):
            proposal = self._climbing(archive, rng) if number % CLIMBING == CLIMBING - 1 else None
            proposal = proposal or self._aimed(aiming, rng) or self._planned(archive, found, rng)
            proposal = proposal or self._climbing(archive, rng)
            if proposal is not None:
                found.append(proposal)
        if len(found) < count and self._experience.has_unplanned_bins(archive):
            found += UntriedWay(self._scripts).propose(archive, count - len(found), rng)
        return found

    def _options(self, slot: Slot, goals: dict[Goal, float]) -> list[Option]:
        recipes = self._experience.recipes[slot.product]
        found = [
            Option(recipes.chance(slot.planned, UNDISTURBED, goal) * left, (goal,), _nothing)
            for goal, left in goals.items()
        ]
        likely = (option for option in found if option.worth >= LEAST)
        return sorted(likely, key=lambda option: -option.worth)

    def _aimed(self, aiming: Aiming, rng: Random) -> Proposal | None:
        aimed = aiming.aim(rng)
        return None if aimed is None else Proposal(self._scripts.draft(aimed.script), self.name, aimed.aims)

    def _planned(self, archive: Archive, found: list[Proposal], rng: Random) -> Proposal | None:
        """A script for an open plan."""
        aimed = {aim for proposal in found for aim in proposal.aims}
        for point in archive.open:
            scripts = self._scripts.by_plan.get((point[1], point[2]), []) if point[0] == "plan" else []
            if scripts and point not in aimed:
                return Proposal(self._scripts.draft(pick(rng, scripts)), self.name, (point,))
        return None

    def _climbing(self, archive: Archive, rng: Random) -> Proposal | None:
        """A script of beliefs like those of the runs that came nearest to an open point."""
        near = {point: runs for point in archive.open if (runs := self._nearest(point, archive))}
        if not near:
            return None
        point = pick(rng, [*near])
        elite = near[point][: elite_size(len(near[point]))]
        shares = Counter(belief for test in elite for belief in test.beliefs)
        beliefs = self._scripts.drawn_beliefs({belief: count / len(elite) for belief, count in shares.items()}, rng)
        return Proposal(self._scripts.draft(self._scripts.of_beliefs(beliefs)), self.name, (point,))

    def _nearest(self, point: Point, archive: Archive) -> list[AbstractTest]:
        """The undisturbed tests that have a distance to a point, the nearest first; none where all are as far away."""
        found = [
            (distance, entry.number, entry.test)
            for entry in archive.entries
            for each, distance in entry.observation.distances
            if each == point and not treated(entry.test.lines)
        ]
        far = max((distance for distance, _, _ in found), default=0.0)
        return [test for distance, _, test in sorted(found, key=lambda each: each[:2]) if distance < far]


def _nothing(commands: int, is_first: bool) -> Treatment:
    return UNDISTURBED


class UntriedWay:
    """Scripts that were not run yet, of which nobody knows what they hit.

    Args:
        scripts: of the model.
    """

    name = "untried"

    def __init__(self, scripts: Scripts) -> None:
        self._scripts = scripts

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        tried = {entry.test.lines for entry in archive.entries}
        left = [number for number, run in enumerate(self._scripts.runs) if run.lines not in tried]
        return [Proposal(self._scripts.draft(number), self.name) for number in shuffled(rng, left)[:count]]
