"""The way of the model: scripts of beliefs that, by the survey of the model, lead to what is open.

Bins are reached by scripts that plan them, plans by beliefs that trigger them. Where a requirement was nearly
triggered, scripts are tried of which one belief differs from that of the nearest one.
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.close.aiming import LEAST, Aiming, Option
from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import UNDISTURBED, Treatment, commands_of
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.rng import pick, shuffled

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
        aiming = Aiming(self._scripts, self._experience, archive, self._options)
        found: list[Proposal] = []
        for number in range(count):
            proposal = self._climbing(archive, rng) if number % CLIMBING == CLIMBING - 1 else None
            proposal = proposal or self._aimed(aiming, rng) or self._planned(archive, found, rng)
            proposal = proposal or self._climbing(archive, rng)
            if proposal is not None:
                found.append(proposal)
        return found

    def _options(self, slot: Slot, open_bins: dict[Bin, float]) -> list[Option]:
        recipes = self._experience.recipes[slot.product]
        found = [
            Option(recipes.chance(slot.planned, UNDISTURBED, rest) * left, (rest,), _nothing)
            for rest, left in open_bins.items()
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
        """A script beside one of those that came nearest to an open point; a new one, if there is one."""
        near = self._nearest(archive)
        if not near:
            return None
        point = pick(rng, [*near])
        beside = self._scripts.neighbours(pick(rng, near[point]).beliefs)
        tried = {entry.test.lines for entry in archive.entries}
        beside = [number for number in beside if self._scripts.runs[number].lines not in tried] or beside
        return Proposal(self._scripts.draft(pick(rng, beside)), self.name, (point,)) if beside else None

    def _nearest(self, archive: Archive) -> dict[Point, list[AbstractTest]]:
        """Of each open point that has a distance, the undisturbed tests with the least one."""
        found: dict[Point, list[AbstractTest]] = {}
        least: dict[Point, float] = {}
        for entry in archive.entries:
            if commands_of(entry.test.lines) == entry.test.lines:
                for point, distance in entry.observation.distances:
                    if point in archive.open and distance <= least.get(point, distance):
                        same = found[point] if distance == least.get(point) else []
                        least[point], found[point] = distance, [*same, entry.test]
        return found


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
