"""Treatments that were never tried, put together from known ones so that they may lead to a goal.

Steps: what has come nearest to the goal, with one more dose that has come nearer to it elsewhere. Bridges: where a
treatment makes an interaction end as another one usually does, what leads from there to the goal may do so from here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

from pytest_hricdv.close.interactions import UNDISTURBED, Dose, Effect, Goal, Treatment
from pytest_hricdv.close.recipes import ALIKE, Recipes, fitted
from pytest_hricdv.coverage.cross_product import Bin

MOST_DOSES = 5
"""An interaction is disturbed so often at most."""

MOST_HELPFUL = 12
"""So many doses are tried to come nearer to a goal: those that most often have."""

NAMESAKES = 2.0
"""What doses of the same disturbance have done counts as so many tries of a dose."""


def apart(one: Effect, two: Effect) -> float:
    """How far two effects are apart: 1 for each text that differs, but for texts of one length, as patterns of bits
    are, the share of their characters that differ."""
    texts = zip(chain(*one), chain(*two), strict=False)
    return sum(_differing(left, right) for left, right in texts)


def _differing(left: str, right: str) -> float:
    if left == right or len(left) != len(right):
        return float(left != right)
    return sum(a != b for a, b in zip(left, right, strict=True)) / len(left)


class _Help(NamedTuple):
    """The doses that most probably come nearer to a goal, and the share that did of each disturbance."""

    doses: tuple[Dose, ...]
    names: dict[str, float]


class Compositions:
    """Puts treatments together.

    Args:
        recipes: what is known; nothing more is learned while this is used.
    """

    def __init__(self, recipes: Recipes) -> None:
        self._recipes = recipes
        self._helpful: dict[Goal, _Help] = {}

    def of(self, planned: Bin, goal: Goal, commands: int) -> list[Treatment]:
        """The treatments that may lead to a goal where this is planned, in an interaction of so many commands."""
        composed = (fitted(each, commands) for each in (*self._bridges(planned, goal), *self._steps(planned, goal)))
        return [
            each
            for each in dict.fromkeys(composed)
            if len(each) <= MOST_DOSES and not self._recipes.is_tried(each, planned)
        ]

    def helpful_names(self, goal: Goal) -> dict[str, float]:
        """Disturbance -> the share of its doses that alone came nearer to a goal than no disturbance does."""
        return self._help(goal).names

    def _steps(self, planned: Bin, goal: Goal) -> Iterator[Treatment]:
        wanted = self._wanted(goal)
        if wanted is None:
            return
        known = [(apart(effect, wanted), treatment) for effect, treatment in self._known(planned)]
        least = min((distance for distance, _ in known), default=0)
        for base in dict.fromkeys([treatment for distance, treatment in known if distance == least] + [UNDISTURBED]):
            yield from (_together(base, (dose,)) for dose in self._help(goal).doses if dose not in base)

    def _bridges(self, planned: Bin, goal: Goal) -> Iterator[Treatment]:
        recipes = self._recipes
        for effect, treatment in self._known(planned):
            for other in recipes.effects if treatment else ():
                if recipes.usual(other) == effect:
                    for further in recipes.leading.get(goal, {}):
                        tally = recipes.results[further].get(other)
                        if tally is not None and tally.came[goal]:
                            yield _together(treatment, further)

    def _known(self, planned: Bin) -> list[tuple[Effect, Treatment]]:
        """The effects of treatments that were seen where this, or the like, is planned, and what is usual there."""
        found: dict[Effect, Treatment] = {}
        for other, effects in self._recipes.effects.items():
            if self._recipes.likeness(planned, other) >= ALIKE:
                for effect, treatment in effects.items():
                    if treatment:
                        found.setdefault(effect, treatment)
        usual = self._recipes.usual(planned)
        if usual is not None:
            found[usual] = UNDISTURBED
        return [*found.items()]

    def _wanted(self, goal: Goal) -> Effect | None:
        """The effect that a goal was most often part of; None if it was never seen."""
        counts = self._recipes.seen_with.get(goal)
        return max(counts, key=lambda effect: (counts[effect], effect)) if counts else None

    def _help(self, goal: Goal) -> _Help:
        """What alone came nearer to a goal than no disturbance does."""
        found = self._helpful.get(goal)
        if found is None:
            wanted = self._wanted(goal)
            found = self._helpful[goal] = _Help((), {}) if wanted is None else self._helping(wanted)
        return found

    def _helping(self, wanted: Effect) -> _Help:
        tries: Counter[Dose | str] = Counter()
        nearer: Counter[Dose | str] = Counter()
        limits = {planned: apart(self._recipes.usual(planned) or wanted, wanted) for planned in self._recipes.effects}
        for planned, dose, effect in self._recipes.singles:
            if limits[planned]:
                tries.update((dose, dose.name))
                nearer.update((dose, dose.name) if apart(effect, wanted) < limits[planned] else ())
        names = {name: nearer[name] / (tries[name] + 1) for name in tries if isinstance(name, str)}
        shares = {
            dose: (nearer[dose] + NAMESAKES * names[dose.name]) / (tries[dose] + NAMESAKES)
            for dose in tries
            if isinstance(dose, Dose)
        }
        doses = sorted(shares, key=lambda dose: (-shares[dose], dose))
        return _Help(tuple(doses[:MOST_HELPFUL]), names)


def _together(one: Treatment, two: Treatment) -> Treatment:
    return tuple(sorted({*one, *two}))
