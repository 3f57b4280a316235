"""Remedies: doses that change what an interaction lacks to come to a goal.

What a dose does to one of several letters, as those of a pattern of sensors, it does whatever the others say.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import NamedTuple

from pytest_hricdv.extra.closing.interactions import Dose, Effect, Treatment
from pytest_hricdv.extra.closing.lack import (
    Lack,
    Letter,
    Whole,
    apart,
    are_comparable,
    has,
    is_changed,
    is_without,
    lacking,
    letter_of,
)
from pytest_hricdv.extra.closing.recipes import Recipes, fitted
from pytest_hricdv.extra.closing.significance import significance

BLURRED = 0.3
"""What comes after an earlier interaction was disturbed counts so much: disturbances may last."""

CONTRARY = 0.3
"""That a dose changed a letter to another one counts so much for changing it back."""

MOST_SHIFTS = 3
"""Of the treatments with the same effect, so many are known."""

LEAN = 0.7
"""Of these, each dose more has to make the effect more certain by this factor."""

SURPRISE = 2.0
"""As if a treatment had been tried so often more in vain: what came may have come by chance."""

DOUBT = 1.0
"""What other doses of the same disturbance did weighs as much as so many tries of a dose."""

BY_CHANCE, UNDISTURBED_TRIES = 0.05, 20.0
"""What is lacking comes by chance, without disturbances, at this rate: as if so many interactions had shown it."""


class Shift(NamedTuple):
    """What most often came of a treatment instead of what is usual, and how probably."""

    treatment: Treatment
    effect: Effect
    chance: float


class Change(NamedTuple):
    """A dose that changed something, what is lacking then to be as before, and how often its disturbance does so."""

    dose: Dose
    lacks: tuple[Lack, ...]
    chance: float


class Tried(NamedTuple):
    """A dose that was tried.

    Args:
        dose: that was tried.
        before: what would probably have come without it: what other doses make of what is usual, or this itself.
        after: what came.
        weight: how much this counts.
    """

    dose: Dose
    before: tuple[Effect, ...]
    after: Effect
    weight: float


class Remedies:
    """What doses have done.

    Args:
        recipes: what is known; nothing more is learned while this is used.
    """

    def __init__(self, recipes: Recipes) -> None:
        self._recipes = recipes
        self._singles: list[Tried] = []
        self._undisturbed: list[tuple[Effect, Effect]] = []
        """What is usual, and what came without disturbances."""
        for planned, treatment, effect, is_clean, *_ in recipes.seen:
            usual = recipes.usual(planned)
            if usual is not None and are_comparable(usual, effect):
                if len(treatment) == 1:
                    self._singles.append(Tried(treatment[0], (usual,), effect, 1.0 if is_clean else BLURRED))
                elif not treatment and is_clean:
                    self._undisturbed.append((usual, effect))
        self._shifts: dict[Effect, list[Shift]] = {}
        self._changes: dict[Effect, list[Change]] = {}
        self._made: dict[Effect, dict[Dose, Effect]] = {}
        self._known: dict[tuple[Lack, int], dict[Dose, float]] = {}
        self._together = [*self._with_others()]

    def against(self, lack: Lack, commands: int) -> dict[Dose, float]:
        """Dose -> how probably it mends what is lacking. Those that never have, nor the contrary, are left out.

        What makes the contrary of a letter probably does both, as what inverts a sensor does. With other doses, those
        count that have mended it alone. What may have come by chance, as sensors err, is expected less.

        Args:
            lack: what is lacking.
            commands: of the interaction: doses come within it.
        """
        found = self._known.get((lack, commands))
        if found is None:
            tries: dict[Dose | str, float] = defaultdict(float)
            came: dict[Dose | str, float] = defaultdict(float)
            mending_alone = (each for each in self._together if came[each.dose.name])  # known after all single tries
            for each in chain(self._singles, mending_alone):
                tried, mended = _mended(each, lack)
                keys: tuple[Dose | str, ...] = (*fitted((each.dose,), commands), each.dose.name)
                for key in keys:
                    tries[key] += tried
                    came[key] += mended
            effects = self._effects(lack)
            found = self._known[lack, commands] = {
                dose: effects[dose.name]
                * (came[dose] + DOUBT * came[dose.name] / (tries[dose.name] + DOUBT))
                / (tries[dose] + DOUBT)
                for dose in came
                if isinstance(dose, Dose) and came[dose]
            }
        return found

    def _effects(self, lack: Lack) -> dict[str, float]:
        """Disturbance -> how probably it mends what is lacking, and this did not come by chance when it was tried.

        By tries of it alone: beside others, it may have been one of these. It comes by chance as often as without
        disturbances and with the other ones: most do nothing to what is lacking, and some make sensors err more often.
        """
        tried, mended = dict[str, float](), dict[str, float]()
        for each in self._singles:
            one, of_this = _mended(each, lack)
            tried[each.dose.name] = tried.get(each.dose.name, 0.0) + one
            mended[each.dose.name] = mended.get(each.dose.name, 0.0) + of_this
        undisturbed = [has(effect, lack) for usual, effect in self._undisturbed if is_without(usual, lack)]
        tries, came = len(undisturbed) + sum(tried.values()), sum(undisturbed) + sum(mended.values())
        return {
            name: significance(mended[name], tried[name], _rate_by_chance(came - mended[name], tries - tried[name]))
            for name in tried
        }

    def shifts(self, usual: Effect) -> list[Shift]:
        """The treatments that made something else of what is usual; of each effect, the most certain ones."""
        found = self._shifts.get(usual)
        if found is None:
            by_effect: dict[Effect, list[Shift]] = {}
            for shift in self._all_shifts(usual):
                by_effect.setdefault(shift.effect, []).append(shift)
            found = self._shifts[usual] = [
                shift
                for shifts in by_effect.values()
                for shift in sorted(shifts, key=lambda each: -each.chance * LEAN ** len(each.treatment))[:MOST_SHIFTS]
            ]
        return found

    def single_shifts(self, usual: Effect) -> list[Shift]:
        """Those of one dose, all of them."""
        return [shift for shift in self._all_shifts(usual) if len(shift.treatment) == 1]

    def changes(self, usual: Effect) -> list[Change]:
        """The doses that changed something that is so in what is usual.

        Where it was seen, something else may have been usual, if it has the same letters where these were changed.
        """
        found = self._changes.get(usual)
        if found is None:
            lacks = {each.dose: lacking(each.after, each.before[0]) for each in self._singles}
            found = self._changes[usual] = [
                Change(dose, each, chance)
                for dose, each in lacks.items()
                if each and (chance := self._change_chance(dose.name, each, usual))
            ]
        return found

    def _change_chance(self, name: str, lacks: tuple[Lack, ...], usual: Effect) -> float:
        """How often a disturbance changed what is so in what is usual, in the same way; 0 where it was never so.

        What may have come by chance, as sensors err, is expected less.
        """

        def is_alike(before: Effect) -> bool:
            letters = (isinstance(lack, Letter) and has(before, lack) and has(usual, lack) for lack in lacks)
            return before == usual or all(letters)

        alike = [each for each in self._singles if each.dose.name == name and is_alike(each.before[0])]
        tries = sum(each.weight for each in alike)
        came = sum(each.weight for each in alike if lacking(each.after, each.before[0]) == lacks)
        chance = [lacking(effect, before) == lacks for before, effect in self._undisturbed if is_alike(before)]
        return significance(came, tries, _rate_by_chance(sum(chance), len(chance))) * came / (tries + DOUBT)

    def disturbing(self, name: str, usual: Effect) -> float:
        """How probably a disturbance does anything where this is usual; more than comes by chance, as sensors err."""
        came = [
            (each.weight, each.after != usual)
            for each in self._singles
            if (each.dose.name, each.before[0]) == (name, usual)
        ]
        chance = [effect != usual for before, effect in self._undisturbed if before == usual]
        tries, changed = sum(weight for weight, _ in came), sum(weight for weight, is_changed in came if is_changed)
        return (
            significance(changed, tries, _rate_by_chance(sum(chance), len(chance)))
            * (changed + DOUBT)
            / (tries + DOUBT)
        )

    def _all_shifts(self, usual: Effect) -> Iterator[Shift]:
        came: dict[Treatment, dict[Effect, float]] = {}
        for planned, treatment, effect, is_clean, *_ in self._recipes.seen:
            if treatment and self._recipes.usual(planned) == usual and are_comparable(usual, effect):
                shares = came.setdefault(treatment, {})
                shares[effect] = shares.get(effect, 0.0) + (1.0 if is_clean else BLURRED)
        for treatment, counts in came.items():
            effect = max(counts, key=lambda each: (counts[each], each))
            if effect != usual:
                yield Shift(treatment, effect, counts[effect] / (sum(counts.values()) + SURPRISE))

    def _with_others(self) -> Iterator[Tried]:
        """The doses of treatments with several, each with what may have come of the others."""
        for planned, treatment, effect, is_clean, *_ in self._recipes.seen:
            usual = self._recipes.usual(planned)
            if len(treatment) > 1 and usual is not None and are_comparable(usual, effect):
                made = self._made_by(usual)
                for dose in treatment:
                    others = [made[each] for each in treatment if each in made and each != dose]
                    yield Tried(dose, (*others, usual), effect, 1.0 if is_clean else BLURRED)

    def _made_by(self, usual: Effect) -> dict[Dose, Effect]:
        if usual not in self._made:
            self._made[usual] = {shift.treatment[0]: shift.effect for shift in self.single_shifts(usual)}
        return self._made[usual]

    def promise(self, names: Iterable[str], letter: Letter) -> dict[str, float]:
        """Disturbance -> how often its doses probably change a letter, whatever it becomes.

        Of two tries before all, one is taken to have done so: what was hardly tried is promising. Where nothing like
        the letter was there afterwards, as where it never came to a reading, the try says nothing of it.
        """
        tries, changed = dict.fromkeys(names, 2.0), dict.fromkeys(names, 1.0)
        for dose, (before,), after, weight in self._singles:
            if dose.name in tries and letter_of(before, letter) and letter_of(after, letter):
                tries[dose.name] += weight
                changed[dose.name] += weight * is_changed(before, after, letter)
        return {name: changed[name] / tries[name] for name in tries}


def _rate_by_chance(came: float, tries: float) -> float:
    return (came + BY_CHANCE * UNDISTURBED_TRIES) / (tries + UNDISTURBED_TRIES)


def _mended(each: Tried, lack: Lack) -> tuple[float, float]:
    """How much a try says of what is lacking, and of this, how much that it was mended."""
    if isinstance(lack, Whole):
        tried = each.weight * max(0.0, *(1.0 - apart(before, lack.present) for before in each.before))
        return tried, tried * has(each.after, lack)
    before = next((before for before in each.before if letter_of(before, lack)), None)
    if before is None:
        return 0.0, 0.0
    if not has(before, lack):
        return each.weight, each.weight * has(each.after, lack)
    return CONTRARY * each.weight, CONTRARY * each.weight * is_changed(before, each.after, lack)
