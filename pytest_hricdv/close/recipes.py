"""What has come of disturbing interactions: which treatments lead to which bins, and how probably they will again.

A treatment that led to a bin is a recipe for it, also where something else is planned: how much this says is learned
for each planned coordinate, from how often the same treatment led to the same where only this coordinate differed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import NamedTuple

from pytest_hricdv.close.interactions import UNDISTURBED, Dose, Effect, Interaction, Treatment
from pytest_hricdv.coverage.cross_product import Bin

DOUBT = 0.5
"""So many tries weigh as much as what is expected of a treatment before it is tried."""

KINSHIP = 0.5
"""A try of the same disturbances with other parameters weighs so much."""

HEARSAY = 2.0
"""What was seen where other things are planned weighs no more than so many own tries."""

ALIKE = 0.5
"""From this likeness on, what is planned is near enough to try the same."""

USUAL = 0.3
"""What comes with this probability without any disturbance is no merit of one."""

HOPE = 0.25
"""The chance that a first try is expected to have as long as nothing is known."""

Kind = tuple[tuple[int, str], ...]
"""The disturbances of a treatment without their parameters."""


def apart(one: Effect, two: Effect) -> int:
    """How far two effects are apart: coordinates that differ; texts of one length differ by each of their characters,
    as patterns of bits do."""
    distance = 0
    for bin_one, bin_two in zip(one, two, strict=False):
        for left, right in zip(bin_one, bin_two, strict=False):
            if len(left) == len(right):
                distance += sum(a != b for a, b in zip(left, right, strict=True))
            else:
                distance += 1
    return distance + abs(len(one) - len(two))


def _kind(treatment: Treatment) -> Kind:
    return tuple((dose.place, dose.name) for dose in treatment)


def _together(one: Treatment, two: Treatment) -> Treatment:
    return tuple(sorted({*one, *two}))


class Recipe(NamedTuple):
    """A treatment with the chance that it leads to a certain bin."""

    treatment: Treatment
    chance: float


class Recipes:
    """What is known of the interactions of one cross product.

    Args:
        coordinates: how many of its coordinates are planned.
    """

    def __init__(self, coordinates: int) -> None:
        self.coordinates = coordinates
        self._results: dict[Treatment, dict[Bin, Counter[Bin]]] = {UNDISTURBED: {}}
        self._leading: dict[Bin, dict[Treatment, None]] = {}
        self._effects: dict[Bin, dict[Effect, Treatment]] = {}
        self._first: dict[int, dict[Bin, Counter[Bin]]] = {}
        self._potent: dict[Dose, None] = {}
        self._of_kind: dict[Kind, dict[Bin, Counter[Bin]]] = {}
        self._with: dict[Bin, Counter[Effect]] = {}
        self._same = [1.0] * coordinates
        self._compared = [2.0] * coordinates

    def learn(self, interactions: Iterable[Interaction]) -> None:
        """Learn from the interactions of a run."""
        for each in interactions:
            if each.hit is None:
                continue
            planned, rest = each.planned, each.hit[len(each.planned) :]
            results = self._results.setdefault(each.treatment, {})
            if not results and each.treatment:
                self._first.setdefault(min(len(each.treatment), 2), {}).setdefault(planned, Counter())[rest] += 1
            self._compare(results, planned, rest)
            results.setdefault(planned, Counter())[rest] += 1
            self._of_kind.setdefault(_kind(each.treatment), {}).setdefault(planned, Counter())[rest] += 1
            if each.treatment:
                self._leading.setdefault(rest, {})[each.treatment] = None
            self._with.setdefault(rest, Counter())[each.effect] += 1
            known = self._effects.setdefault(planned, {})
            if known.get(each.effect) != UNDISTURBED:
                self._potent |= dict.fromkeys(each.treatment)
            if each.effect not in known or len(each.treatment) < len(known[each.effect]):
                known[each.effect] = each.treatment

    def unions(self, planned: Bin, rest: Bin, commands: int) -> list[Treatment]:
        """Two treatments together that may lead to a bin, and were never tried together.

        One of the two has an effect that comes nearer to it than no disturbance does, or both if there are several
        such. How near an effect is, is measured from what was most often seen with the rest of the bin; where that was
        never seen, any two treatments with effects may lead there.
        """
        effects, counts = self._effects_of(planned), self._with.get(rest)
        some = others = [*effects.values()]
        if counts:
            wanted = max(counts, key=lambda effect: (counts[effect], effect))
            usual = (effect for effect, known in self._effects.get(planned, {}).items() if not known)
            limit = min((apart(effect, wanted) for effect in usual), default=0)
            some = [treatment for effect, treatment in effects.items() if apart(effect, wanted) < limit]
            others = some if len(some) > 1 else others
        unions = (_together(one, two) for one in some for two in others if one != two)
        return [
            union
            for union in dict.fromkeys(unions)
            if union not in self._results and all(1 <= dose.place <= commands for dose in union)
        ]

    def _effects_of(self, planned: Bin) -> dict[Effect, Treatment]:
        """One treatment for each different effect that was seen where this, or nearly this, is planned."""
        found: dict[Effect, Treatment] = {}
        for other, known in self._effects.items():
            if self._likeness(planned, other) >= ALIKE:
                for effect, treatment in known.items():
                    if effect not in found or len(treatment) < len(found[effect]):
                        found[effect] = treatment
        return {effect: treatment for effect, treatment in found.items() if treatment}

    def untried_doses(self, planned: Bin, commands: int) -> list[Dose]:
        """The doses that had an effect somewhere, and that were not tried alone where this, or the like, is planned."""
        return [
            dose
            for dose in self._potent
            if 1 <= dose.place <= commands
            and not any(self._likeness(planned, other) >= ALIKE for other in self._results.get((dose,), {}))
        ]

    def chance(self, planned: Bin, treatment: Treatment, rest: Bin) -> float:
        """The probability that the rest of the bin is this."""
        kin = self._of_kind.get(_kind(treatment), {}).get(planned) if treatment else None
        return self._estimate(self._results.get(treatment, {}), planned, rest, kin)

    def first_chance(self, planned: Bin, rest: Bin, size: int) -> float:
        """The same of a treatment that was never tried: of one dose (`size` 1), or of several (2)."""
        return self._estimate(self._first.get(size, {}), planned, rest)

    def best(self, planned: Bin, rest: Bin, commands: int) -> Recipe | None:
        """The treatment that most probably leads to a bin, among those, or parts of those, that led to such a one.

        Args:
            planned: the first coordinates of the bin.
            rest: its other coordinates.
            commands: of the interaction: a treatment has to fit in.
        """
        leading = [each for each in self._leading.get(rest, {}) if self._has_merit(each, rest)]
        parts = (part for each in leading if len(each) > 1 for part in combinations(each, len(each) - 1))
        known = (
            Recipe(each, self.chance(planned, each, rest))
            for each in dict.fromkeys((*leading, *parts))
            if all(1 <= dose.place <= commands for dose in each)
        )
        return max(known, key=lambda recipe: recipe.chance, default=None)

    def _has_merit(self, treatment: Treatment, rest: Bin) -> bool:
        """Whether a treatment led to something where that is unusual without it."""
        return any(
            counts[rest] and self.chance(planned, UNDISTURBED, rest) < USUAL
            for planned, counts in self._results[treatment].items()
        )

    def _estimate(
        self, results: Mapping[Bin, Counter[Bin]], planned: Bin, rest: Bin, kin: Counter[Bin] | None = None
    ) -> float:
        """What was seen of what is alike, and of the same doses with other parameters, is expected before tries."""
        led, tried = DOUBT * HOPE, DOUBT
        if kin:
            led += KINSHIP * kin[rest]
            tried += KINSHIP * kin.total()
        for other, counts in results.items():
            if other != planned:
                weight = self._likeness(planned, other)
                led += weight * counts[rest]
                tried += weight * counts.total()
        strength, own = min(tried, HEARSAY), results.get(planned, Counter())
        return (strength * led / tried + own[rest]) / (strength + own.total())

    def _likeness(self, planned: Bin, other: Bin) -> float:
        """How much what was seen where `other` is planned says of where `planned` is."""
        weight = 1.0
        for place, (one, two) in enumerate(zip(planned, other, strict=True)):
            if one != two:
                weight *= (self._same[place] / self._compared[place]) ** 2
        return weight

    def _compare(self, results: Mapping[Bin, Counter[Bin]], planned: Bin, rest: Bin) -> None:
        for other, counts in results.items():
            places = [place for place, (one, two) in enumerate(zip(planned, other, strict=True)) if one != two]
            if len(places) == 1:
                self._same[places[0]] += counts[rest] / counts.total()
                self._compared[places[0]] += 1.0
