"""The way of disturbances: interactions are disturbed so that probably they end as no run has ended yet.

What has led to a bin is done again where it may lead to an open one. Beside that, single disturbances that were rarely
tried, and two treatments together that each had an effect of their own: which of these is done is decided by how often
each has led to something.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from random import Random

from pytest_hricdv.close.aiming import LEAST, Aiming, Option
from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import Dose, Treatment
from pytest_hricdv.close.recipes import Recipes
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.generate.abstract import Draft
from pytest_hricdv.generate.rng import pick
from pytest_hricdv.generate.sampler import Sampler

MOST_DOSES = 5
"""An interaction is disturbed so often at most."""

KNOWN = 0.5
"""How often a dose is tried that had an effect where something else was planned, instead of a new one."""

LIKELY = 0.05
"""What has led to a bin is done again, where it may lead to another one, with at least this chance."""


class DisturbanceWay:
    """Scripts of the model with disturbances.

    Args:
        scripts: of the model.
        experience: of all runs so far.
        disturbances: name -> the ranges of its parameters.
    """

    name = "disturbances"

    def __init__(
        self, scripts: Scripts, experience: Experience, disturbances: Mapping[str, Mapping[str, Sampler]]
    ) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        if not self._disturbances or not self._scripts.runs:
            return []
        self._experience.learn(archive)
        making_up = _MakingUp(self._scripts, self._experience, self._disturbances, rng)
        aiming = Aiming(self._scripts, self._experience, archive, making_up.options)
        found = []
        for _ in range(count):
            aimed = aiming.aim(rng)
            if aimed is None:
                found.append(Proposal(self._rarely_tried(making_up, rng), self.name))
            else:
                draft = self._scripts.draft(aimed.script, aimed.product, aimed.treatments)
                found.append(Proposal(draft, self.name, aimed.aims))
        return found

    def _rarely_tried(self, making_up: _MakingUp, rng: Random) -> Draft:
        """Any script with a disturbance that was rarely tried: for what is open beside the bins."""
        script = self._scripts.any(rng)
        product = pick(rng, [*self._scripts.planned]) if self._scripts.planned else ""
        first = self._scripts.first(script, product)
        ends = (*first[1:], len(self._scripts.runs[script].lines))
        treatments = [making_up.single(end - begin, begin == first[0]) for begin, end in zip(first, ends, strict=True)]
        return self._scripts.draft(script, product, treatments)


class _MakingUp:
    """Treatments of a generation."""

    def __init__(
        self,
        scripts: Scripts,
        experience: Experience,
        disturbances: Mapping[str, Mapping[str, Sampler]],
        rng: Random,
    ) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances
        self._rng = rng
        self._doses = experience.doses.copy()
        self._taken: set[Treatment] = set()

    def options(self, slot: Slot, open_bins: dict[Bin, float]) -> list[Option]:
        """See `aiming.Options`."""
        recipes, commands = self._experience.recipes[slot.product], self._scripts.commands(slot)
        found: list[Option] = []
        first = 0.0
        for rest, left in open_bins.items():
            recipe = recipes.best(slot.planned, rest, commands)
            if recipe is not None and recipe.chance >= LIKELY:
                found.append(Option(recipe.chance * left, (rest,), partial(_again, recipe.treatment)))
            if unions := self._unions(recipes, slot.planned, rest, commands):
                chance = max(recipes.first_chance(slot.planned, rest, 2), LEAST)
                found.append(Option(chance * left, (rest,), partial(self._union, unions)))
            first += max(recipes.first_chance(slot.planned, rest, 1), LEAST) * left
        doses = recipes.untried_doses(slot.planned, commands)
        found.append(Option(first, tuple(open_bins), partial(self._single_or_known, doses)))
        return sorted(found, key=lambda option: -option.worth)

    def single(self, commands: int, is_first: bool) -> Treatment:
        """A disturbance at a place where it was tried as rarely as any."""
        places = range(0 if is_first else 1, commands + 1)
        rarest = min(self._doses[name, place] for name in self._disturbances for place in places)
        choices = [
            (name, place) for name in self._disturbances for place in places if self._doses[name, place] == rarest
        ]
        name, place = pick(self._rng, choices)
        self._doses[name, place] += 1
        values = ((each, sampler.sample(self._rng)) for each, sampler in sorted(self._disturbances[name].items()))
        return (Dose(place, name, tuple(values)),)

    def _single_or_known(self, doses: Sequence[Dose], commands: int, is_first: bool) -> Treatment:
        """Every second time a dose that had an effect elsewhere, where there is one."""
        return (pick(self._rng, doses),) if doses and self._rng.random() < KNOWN else self.single(commands, is_first)

    def _unions(self, recipes: Recipes, planned: Bin, rest: Bin, commands: int) -> list[Treatment]:
        unions = recipes.unions(planned, rest, commands)
        return [union for union in unions if len(union) <= MOST_DOSES and union not in self._taken]

    def _union(self, unions: Sequence[Treatment], commands: int, is_first: bool) -> Treatment:
        union = pick(self._rng, unions)
        self._taken.add(union)
        return union


def _again(treatment: Treatment, commands: int, is_first: bool) -> Treatment:
    return treatment
