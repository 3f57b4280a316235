"""The way of the model: scripts of beliefs that, by the survey of the model, lead to what is open.

Bins are reached by scripts that plan them, plans by beliefs that trigger them. Where a requirement was nearly
triggered, scripts are tried of which one belief differs from that of the nearest one. At last, scripts are tried of
which nothing is known.
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.close.aiming import Aiming, Option
from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import UNDISTURBED, Treatment
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.generate.rng import pick

CLIMBING = 4
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
        aiming = Aiming(self._scripts, self._experience, archive, self._options, _nothing)
        found: list[Proposal] = []
        for number in range(count):
            proposal = self._climbing(archive, rng) if number % CLIMBING == CLIMBING - 1 else None
            proposal = proposal or self._aimed(aiming, rng) or self._planned(archive, found, rng)
            proposal = proposal or self._climbing(archive, rng) or self._untried(archive, found, rng)
            if proposal is not None:
                found.append(proposal)
        return found

    def _options(self, slot: Slot, open_bins: dict[Bin, float]) -> list[Option]:
        recipes = self._experience.recipes[slot.product]
        found = [
            Option(recipes.chance(slot.planned, UNDISTURBED, rest) * left, (rest,), UNDISTURBED)
            for rest, left in open_bins.items()
        ]
        return sorted(found, key=lambda option: -option.worth)

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
        """A script beside the one that came nearest to an open point."""
        near: list[Point] = [point for point in archive.open if point in archive.nearest]
        if not near:
            return None
        point = pick(rng, near)
        beside = self._scripts.neighbours(archive.nearest[point][1].test.beliefs)
        return Proposal(self._scripts.draft(pick(rng, beside)), self.name, (point,)) if beside else None

    def _untried(self, archive: Archive, found: list[Proposal], rng: Random) -> Proposal | None:
        """A script that was not run yet: nobody knows what it hits."""
        tried = {entry.test.lines for entry in archive.entries} | {proposal.draft.lines for proposal in found}
        left = [number for number, run in enumerate(self._scripts.runs) if run.lines not in tried]
        return Proposal(self._scripts.draft(pick(rng, left)), self.name) if left else None


def _nothing(slot: Slot, commands: int, is_first: bool) -> Treatment:
    return UNDISTURBED
