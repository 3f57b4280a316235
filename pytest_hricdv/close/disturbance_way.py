"""The way of disturbances: interactions are disturbed so that probably they end as no run has ended yet.

What has led to a goal is done again where it may lead to an open bin. Beside that, what is put together from treatments
that each had an effect of their own, and single disturbances that were rarely tried: which of these is done is decided
by how often each has led to something.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from random import Random

from pytest_hricdv.close.aiming import LEAST, Aiming, Option
from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.compositions import Compositions
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import Dose, Goal, Treatment
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.generate.abstract import Draft
from pytest_hricdv.generate.rng import pick, random_index, weighted
from pytest_hricdv.generate.sampler import Sampler

LIKELY = 0.1
"""What has led to a goal is done again with at least this chance."""

COMPOSED = 0.1
"""What is put together from known treatments is expected to lead to a goal at least with this chance: it may also come
nearer to it."""

HELPFUL = 0.5
"""How often a new dose is one of a disturbance that helped elsewhere, instead of one that was rarely tried."""

Disturbances = Mapping[str, Mapping[str, Sampler]]
"""Name -> the ranges of its parameters."""


class DisturbanceWay:
    """Scripts of the model with disturbances.

    Args:
        scripts: of the model.
        experience: of all runs so far.
        disturbances: of the testbench.
    """

    name = "disturbances"

    def __init__(self, scripts: Scripts, experience: Experience, disturbances: Disturbances) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        if not self._disturbances or not self._scripts.runs:
            return []
        self._experience.learn(archive)
        treatments = _Treatments(self._scripts, self._experience, self._disturbances, rng)
        aiming = Aiming(self._scripts, self._experience, archive, treatments.options)
        found = []
        for _ in range(count):
            aimed = aiming.aim(rng)
            if aimed is None:
                found.append(Proposal(self._rarely_tried(treatments, rng), self.name))
            else:
                draft = self._scripts.draft(aimed.script, aimed.product, aimed.treatments)
                found.append(Proposal(draft, self.name, aimed.aims))
        return found

    def _rarely_tried(self, treatments: _Treatments, rng: Random) -> Draft:
        """Any script with a disturbance that was rarely tried: for what is open beside the bins."""
        script = self._scripts.any(rng)
        product = pick(rng, [*self._scripts.planned]) if self._scripts.planned else ""
        first = self._scripts.first(script, product)
        ends = (*first[1:], len(self._scripts.runs[script].lines))
        chosen = [treatments.single(end - begin, begin == first[0]) for begin, end in zip(first, ends, strict=True)]
        return self._scripts.draft(script, product, chosen)


class _Treatments:
    """The treatments of a generation."""

    def __init__(self, scripts: Scripts, experience: Experience, disturbances: Disturbances, rng: Random) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances
        self._rng = rng
        self._doses = experience.doses.copy()
        self._compositions = {name: Compositions(recipes) for name, recipes in experience.recipes.items()}
        self._taken: set[Treatment] = set()

    def options(self, slot: Slot, goals: dict[Goal, float]) -> list[Option]:
        """See `aiming.Options`."""
        recipes, commands = self._experience.recipes[slot.product], self._scripts.commands(slot)
        found: list[Option] = []
        first = 0.0
        for goal, left in goals.items():
            recipe = recipes.best(slot.planned, goal, commands)
            if recipe is not None and recipe.chance >= LIKELY:
                found.append(Option(recipe.chance * left, (goal,), partial(_again, recipe.treatment)))
            composed = self._compositions[slot.product].of(slot.planned, goal, commands)
            if new := [each for each in composed if each not in self._taken]:
                chance = max(recipes.first_chance(slot.planned, goal, 2), COMPOSED)
                found.append(Option(chance * left, (goal,), partial(self._any, new)))
            first += max(recipes.first_chance(slot.planned, goal, 1), LEAST) * left
        found.append(Option(first, tuple(goals), partial(self._new, slot.product, tuple(goals))))
        return sorted(found, key=lambda option: -option.worth)

    def single(self, commands: int, is_first: bool) -> Treatment:
        """A disturbance at a place where it was tried as rarely as any."""
        places = range(0 if is_first else 1, commands + 1)
        choices = [(name, place) for name in self._disturbances for place in places]
        rarest = min(self._doses[choice] for choice in choices)
        name, place = pick(self._rng, [choice for choice in choices if self._doses[choice] == rarest])
        self._doses[name, place] += 1
        return (self._dose(name, place),)

    def _new(self, product: str, goals: Sequence[Goal], commands: int, is_first: bool) -> Treatment:
        """A new dose: every second time of a disturbance that helped to come nearer to one of the goals."""
        shares = self._compositions[product].helpful_names(pick(self._rng, goals))
        if self._rng.random() >= HELPFUL or not sum(shares.values()):
            return self.single(commands, is_first)
        name = weighted(self._rng, shares)
        return (self._dose(name, 1 + random_index(self._rng, commands)),)

    def _dose(self, name: str, place: int) -> Dose:
        values = ((each, sampler.sample(self._rng)) for each, sampler in sorted(self._disturbances[name].items()))
        return Dose(place, name, tuple(values))

    def _any(self, treatments: Sequence[Treatment], commands: int, is_first: bool) -> Treatment:
        """One of them, that no other test of the generation has."""
        treatment = pick(self._rng, treatments)
        self._taken.add(treatment)
        return treatment


def _again(treatment: Treatment, commands: int, is_first: bool) -> Treatment:
    return treatment
