"""Treatments that were never tried, put together from doses so that they may lead to a goal.

A treatment may make an interaction end as another one usually does; and against each letter or text that is lacking
then, there may be a dose that mended it elsewhere.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import combinations
from math import prod
from random import Random
from typing import TypeVar

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Dose, Effect, Goal, Treatment
from pytest_hricdv.extra.closing.lack import Lack, Letter, Whole, lacking
from pytest_hricdv.extra.closing.recipes import Recipe, Recipes, fitted
from pytest_hricdv.extra.closing.remedies import Change, Remedies, Shift
from pytest_hricdv.generate.rng import pick, shuffled, weighted

Drawn = TypeVar("Drawn", Dose, Shift)
Combined = dict[frozenset[str], list[tuple[Lack, ...]]]
"""Disturbances that were tried together -> what was lacking then, each time."""

MOST_DOSES = 5
"""An interaction is disturbed so often at most."""

CUT = 0.5
"""What has more doses than that loses some. Each that is left out may have been needed: it is expected so much less."""

SURE = 0.4
"""What leads to a goal with at least this chance is known to lead there."""

CHOICES = 4
"""Where several doses may do, one of so many is taken."""

PATIENCE = 2.0
"""After so many tries in vain, something is expected half as often."""

EAGERNESS = 3
"""It is drawn in proportion to this power of its chance."""


class Compositions:
    """Puts treatments together.

    Args:
        recipes: what is known; nothing more is learned while this is used.
    """

    def __init__(self, recipes: Recipes) -> None:
        self._recipes = recipes
        self._remedies = Remedies(recipes)
        self._vain: dict[tuple[Effect, Goal, int], Counter[Effect]] = {}

    def drawn(self, planned: Bin, goal: Goal, commands: int, rng: Random) -> Recipe | None:
        """A treatment that may lead to a goal where this is planned, in an interaction of so many commands.

        Its chance is what is expected before it is tried. None where something is lacking that no dose has mended.
        """
        wanted, usual = self._wanted(planned, goal), self._recipes.usual(planned)
        if wanted is None or usual is None:
            return None
        shifts = [Shift(UNDISTURBED, usual, 1.0), *self._fitting(usual, commands)]
        vain = self._vain.get((usual, goal, commands))
        if vain is None:
            vain = self._vain[usual, goal, commands] = self._in_vain(usual, goal, wanted, commands)
        chances = {shift: chance for shift in shifts if (chance := self._chance(shift, wanted, vain, commands)) > 0.0}
        if not chances:
            return None
        shift = _drawn(chances, rng)
        doses = {_drawn(self._remedies.against(lack, commands), rng) for lack in lacking(shift.effect, wanted)}
        kept = shuffled(rng, [*shift.treatment])[: MOST_DOSES - len(doses)]
        treatment = fitted(tuple({*kept, *doses}), commands)
        if not treatment:
            return None
        return Recipe(treatment, self._recipes.chance(planned, treatment, goal, expected=chances[shift]))

    def _fitting(self, usual: Effect, commands: int) -> Iterator[Shift]:
        """The known shifts; one of a longer interaction, of which doses have to be moved, until this was tried."""
        for shift in self._remedies.shifts(usual):
            treatment = fitted(shift.treatment, commands)
            if treatment == shift.treatment or treatment not in self._recipes.results:
                yield shift

    def reduced(self, planned: Bin, commands: int, rng: Random) -> Treatment | None:
        """A treatment that made something else of what is usual, without one of its doses; it was never tried.

        What comes then says which doses it takes. None where no such treatment is known.
        """
        usual = self._recipes.usual(planned)
        shifts = () if usual is None else tuple(self._fitting(usual, commands))
        parts = dict.fromkeys(
            fitted(part, commands)
            for shift in shifts
            if len(shift.treatment) > 1
            for part in combinations(shift.treatment, len(shift.treatment) - 1)
        )
        untried = [part for part in parts if part not in self._recipes.results]
        return pick(rng, untried) if untried else None

    def masked(self, planned: Bin, commands: int, rng: Random) -> Treatment | None:
        """A dose that probably changes how the interaction ends, with doses of other disturbances that may hide this.

        What seems as usual and is not leads to checks in the code that are beyond the first ones. Of several, it is
        rather one whose disturbances were rarely combined. None where no way to hide a change is known.
        """
        usual = self._recipes.usual(planned)
        changes = {} if usual is None else self._changes(usual)
        if usual is None or not changes:
            return None
        combined = self._combined(usual, usual)
        drawn = [self._hidden((), weighted(rng, changes), combined, commands, rng) for _ in range(CHOICES)]
        found = {_names(each): each for each in drawn if len(each) > 1}
        rare = {each: 1.0 / (1 + len(combined.get(names, ()))) for names, each in found.items()}
        return weighted(rng, rare) if rare else None

    def beside(self, planned: Bin, goal: Goal, commands: int, rng: Random) -> Treatment | None:
        """What is known to lead to a goal, and a dose that changes how interactions end which usually end so.

        What hides the person's state from the code may hide such a change as well: where all sensors are wrong, a leg
        that is pulled out changes nothing that they say. None where nothing leads there, or no such dose is known.
        """
        recipe, wanted = self._recipes.best(planned, goal, commands), self._wanted(planned, goal)
        usual = self._recipes.usual(planned)
        if recipe is None or wanted is None or usual is None or recipe.chance < SURE:
            return None
        names = _names(recipe.treatment)
        changes = {
            each: chance
            for each, chance in self._changes(wanted).items()
            if each.dose.name not in names and not any(isinstance(lack, Whole) for lack in each.lacks)
        }
        if not changes or len(recipe.treatment) >= MOST_DOSES:
            return None
        change = weighted(rng, changes)._replace(lacks=())
        return self._hidden(recipe.treatment, change, self._combined(usual, wanted), commands, rng)

    def _changes(self, usual: Effect) -> dict[Change, float]:
        """Doses that change this -> how often to choose them: by how probably their disturbance does anything, but the
        less, the more often it was hidden and nothing else came of it."""
        known, shares = self._remedies.changes(usual), dict[str, float]()
        for each in known:
            shares[each.dose.name] = shares.get(each.dose.name, 0.0) + each.chance
        hidden = Counter(
            name
            for each in self._recipes.seen
            if len(each.treatment) > 1 and each.effect == usual
            for name in _names(each.treatment)
        )
        often = {name: self._remedies.disturbing(name, usual) / (1 + hidden[name]) for name in shares}
        return {each: often[each.dose.name] * each.chance / shares[each.dose.name] for each in known}

    def _hidden(
        self, treatment: Treatment, change: Change, combined: Combined, commands: int, rng: Random
    ) -> Treatment:
        """A treatment and a change, with doses against what is lacking then.

        Where these disturbances were combined before, what was still lacking is mended as well: a leg that is pulled
        out sooner lies elsewhere, where other sensors miss it.
        """
        treatment = fitted((*treatment, change.dose), commands)
        lacks = change.lacks or combined.get(_names(treatment), [()])[-1]
        while lacks:
            others = [self._others(lack, _names(treatment), commands) for lack in lacks]
            if not all(others) or len(treatment) + len(others) > MOST_DOSES:
                break
            treatment = fitted((*treatment, *dict.fromkeys(_drawn(each, rng) for each in others)), commands)
            lacks = combined.get(_names(treatment), [()])[-1]
        return treatment

    def _others(self, lack: Lack, names: frozenset[str], commands: int) -> dict[Dose, float]:
        against = self._remedies.against(lack, commands)
        return {dose: chance for dose, chance in against.items() if dose.name not in names}

    def _combined(self, usual: Effect, wanted: Effect) -> Combined:
        """Where this usually comes: disturbances that were tried together, not for a goal, with what was lacking each
        time.

        Where something came that differs in more than letters, something else went wrong: it was not tried.
        """
        found: Combined = {}
        for each in self._recipes.seen:
            if len(each.treatment) > 1 and not each.aims and self._recipes.usual(each.planned) == usual:
                lacks = lacking(each.effect, wanted)
                if not any(isinstance(lack, Whole) for lack in lacks):
                    found.setdefault(_names(each.treatment), []).append(lacks)
        return found

    def promise(self, names: Collection[str], planned: Bin, goal: Goal, commands: int) -> dict[str, float]:
        """Disturbance -> how many of the letters that are lacking where this is planned its doses probably change, of
        which no dose is known that mends them.

        Empty where no letter is lacking: that something else comes does not promise that it is nearer.
        """
        wanted, usual = self._wanted(planned, goal), self._recipes.usual(planned)
        found: dict[str, float] = {}
        if wanted is not None and usual is not None:
            for lack in (each for each in lacking(usual, wanted) if isinstance(each, Letter)):
                need = 1.0 - max(self._remedies.against(lack, commands).values(), default=0.0)
                for name, share in self._remedies.promise(names, lack).items():
                    found[name] = found.get(name, 0.0) + need * share
        return found

    def _wanted(self, planned: Bin, goal: Goal) -> Effect | None:
        """The effect that a goal was most often part of; if it was never seen, it is part of what is usual."""
        counts, usual = self._recipes.seen_with.get(goal), self._recipes.usual(planned)
        if counts:
            return max(counts, key=lambda effect: (counts[effect], effect))
        return tuple(goal if each[0] == goal[0] else each for each in usual) if usual else None

    def _chance(self, shift: Shift, wanted: Effect, vain: Mapping[Effect, int], commands: int) -> float:
        """How probably the shift comes, and what is lacking then can be mended: less, the more often it was in vain."""
        lacks = [self._remedies.against(lack, commands) for lack in lacking(shift.effect, wanted)]
        if len(lacks) > MOST_DOSES:
            return 0.0
        chance = shift.chance * prod(max(each.values(), default=0.0) for each in lacks)
        chance *= CUT ** max(0, len(shift.treatment) + len(lacks) - MOST_DOSES)
        return chance * PATIENCE / (PATIENCE + vain.get(shift.effect, 0))

    def _in_vain(self, usual: Effect, goal: Goal, wanted: Effect, commands: int) -> Counter[Effect]:
        """The effect of a shift -> how often what is lacking then was mended by good doses, but has not led to a goal.

        What is lacking may not be what it seems: who is given nothing because there is nothing to give lacks more than
        a good sensor.
        """
        shifted = {frozenset(shift.treatment): shift.effect for shift in self._remedies.shifts(usual)}
        vain: Counter[Effect] = Counter()
        for each in self._recipes.seen:
            is_in_vain = len(each.treatment) > 1 and goal in each.aims and goal not in each.effect
            if is_in_vain and self._recipes.usual(each.planned) == usual:
                effects = {shifted[part] for part in _parts(each.treatment) if part in shifted} or {usual}
                names = _names(each.treatment)
                vain.update(effect for effect in effects if self._is_mended(effect, wanted, names, commands))
        return vain

    def _is_mended(self, effect: Effect, wanted: Effect, names: frozenset[str], commands: int) -> bool:
        """Whether there is a good dose against each letter or text that is lacking: half as good as the best one."""
        return all(self._good(lack, commands) & names for lack in lacking(effect, wanted))

    def _good(self, lack: Lack, commands: int) -> frozenset[str]:
        chances = self._remedies.against(lack, commands)
        best = max(chances.values(), default=0.0)
        return frozenset(dose.name for dose, chance in chances.items() if chance >= best / 2)


def _parts(treatment: Treatment) -> Iterator[frozenset[Dose]]:
    """What may have been added to, to make a treatment."""
    return (frozenset(part) for size in range(1, len(treatment)) for part in combinations(treatment, size))


def _names(treatment: Treatment) -> frozenset[str]:
    return frozenset(dose.name for dose in treatment)


def _drawn(chances: Mapping[Drawn, float], rng: Random) -> Drawn:
    best = sorted(chances, key=lambda each: (-chances[each], each))[:CHOICES]
    return weighted(rng, {each: chances[each] ** EAGERNESS for each in best})
