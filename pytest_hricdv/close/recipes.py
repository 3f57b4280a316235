"""What has come of disturbing interactions: which treatments lead to which bins, and how probably they will again.

A treatment that led to a bin is a recipe for it, also where something else is planned: how much this says is learned
for each planned coordinate, from how often the same treatment led to the same where only this coordinate differed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pytest_hricdv.close.interactions import UNDISTURBED, Interaction, Treatment
from pytest_hricdv.coverage.cross_product import Bin

DOUBT = 0.5
"""So many tries weigh as much as what is expected of a treatment before it is tried."""

ALIKE = 0.5
"""From this likeness on, what is planned is near enough to try the same."""

HOPE = 0.25
"""The chance that a first try is expected to have as long as nothing is known."""


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
        self._effects: dict[Bin, dict[tuple[Bin, ...], Treatment]] = {}
        self._first: dict[int, dict[Bin, Counter[Bin]]] = {}
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
            self._leading.setdefault(rest, {})[each.treatment] = None
            known = self._effects.setdefault(planned, {})
            if each.effect not in known or len(each.treatment) < len(known[each.effect]):
                known[each.effect] = each.treatment

    def effects(self, planned: Bin) -> list[Treatment]:
        """One treatment for each different effect that was seen where this, or nearly this, is planned."""
        found: dict[tuple[Bin, ...], Treatment] = {}
        for other, known in self._effects.items():
            if self._likeness(planned, other) >= ALIKE:
                for effect, treatment in known.items():
                    if effect not in found or len(treatment) < len(found[effect]):
                        found[effect] = treatment
        return [treatment for treatment in found.values() if treatment]

    def is_tried(self, treatment: Treatment) -> bool:
        """Whether a run had this treatment."""
        return treatment in self._results

    def chance(self, planned: Bin, treatment: Treatment, rest: Bin) -> float:
        """The probability that the rest of the bin is this."""
        return self._estimate(self._results.get(treatment, {}), planned, rest)

    def first_chance(self, planned: Bin, rest: Bin, size: int) -> float:
        """The same of a treatment that was never tried: of one dose (`size` 1), or of several (2)."""
        return self._estimate(self._first.get(size, {}), planned, rest)

    def best(self, planned: Bin, rest: Bin, *, treated: bool = True) -> Recipe:
        """The treatment that most probably leads to a bin, among those that have led to such a one.

        Args:
            planned: the first coordinates of the bin.
            rest: its other coordinates.
            treated: with disturbances, too.
        """
        known = self._leading.get(rest, {}) if treated else {}
        best = Recipe(UNDISTURBED, self.chance(planned, UNDISTURBED, rest))
        for treatment in known:
            chance = self.chance(planned, treatment, rest)
            if chance > best.chance:
                best = Recipe(treatment, chance)
        return best

    def _estimate(self, results: Mapping[Bin, Counter[Bin]], planned: Bin, rest: Bin) -> float:
        led, tried = DOUBT * HOPE, DOUBT
        for other, counts in results.items():
            weight = self._likeness(planned, other)
            led += weight * counts[rest]
            tried += weight * counts.total()
        return led / tried

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
