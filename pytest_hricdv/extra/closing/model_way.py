"""The way of the model: scripts of beliefs that, by the survey of the model, lead to what is open.

Bins are reached by scripts that plan them, plans by beliefs that trigger them. Where a requirement was nearly
triggered, scripts are tried that may come nearer; where bins are open of which it is unknown what plans them, scripts
that were not run yet.
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.extra.closing.aiming import LEAST, Aiming, Option
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.climbing import Climbing
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Goal, Treatment
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.rng import pick, shuffled

CLIMBING = 0.5
"""So often a test is to come nearer to a point that has a distance, where there is one."""


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
        climbing = Climbing(self._scripts, self._experience, archive)
        found: list[Proposal] = []
        for _ in range(count):
            proposal = self._nearer(climbing, rng) if rng.random() < CLIMBING else None
            proposal = proposal or self._aimed(aiming, rng) or self._planned(archive, found, rng)
            proposal = proposal or self._nearer(climbing, rng)
            if proposal is not None:
                found.append(proposal)
        if len(found) < count and self._experience.has_unplanned_bins(archive):
            found += UntriedWay(self._scripts, self.name).propose(archive, count - len(found), rng)
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

    def _nearer(self, climbing: Climbing, rng: Random) -> Proposal | None:
        """A script that may come nearer to an open point that has a distance."""
        found = climbing.script(rng)
        return None if found is None else Proposal(self._scripts.draft(found[0]), self.name, (found[1],))


def _nothing(commands: int, is_first: bool) -> Treatment:
    return UNDISTURBED


class UntriedWay:
    """Scripts that were not run yet, of which nobody knows what they hit.

    Args:
        scripts: of the model.
        name: of the way that they are proposed for.
    """

    def __init__(self, scripts: Scripts, name: str = "untried") -> None:
        self._scripts = scripts
        self.name = name

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        tried = {entry.test.lines for entry in archive.entries}
        left = [number for number, run in enumerate(self._scripts.runs) if run.lines not in tried]
        return [Proposal(self._scripts.draft(number), self.name) for number in shuffled(rng, left)[:count]]
