"""What has come of disturbing interactions: which treatments lead to which goals, and how probably they will again.

A treatment that led to a goal is a recipe for it, also where something else is planned: how much this says is learned
for each planned coordinate, from how often the same treatment led to the same where only this coordinate differed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Dose, Effect, Goal, Interaction, RunValues, Treatment

DOUBT = 0.5
"""So many tries weigh as much as what is expected of a treatment before it is tried."""

HOPE = 0.25
"""The chance that a first try is expected to have as long as nothing is known."""

KINSHIP = 0.5
"""A try of the same disturbances with other parameters weighs so much."""

HEARSAY = 2.0
"""What was seen where other things are planned weighs no more than so many own tries."""

TRUST = 0.3
"""As if so many foreign treatments had been tried where something usually comes, and had led to each goal."""

USUAL = 0.3
"""What comes with this probability without any disturbance is no merit of one."""

ALIKE = 0.25
"""What usually comes is taken from where something else is planned, if this says at least so much."""

Kind = tuple[tuple[int, str], ...]
"""The disturbances of a treatment without their parameters."""


@dataclass
class Tally:
    """What came of a number of tries: how often each goal did."""

    tries: int = 0
    came: Counter[Goal] = field(default_factory=Counter)

    def add(self, effect: Effect) -> None:
        """One more try."""
        self.tries += 1
        self.came.update(effect)


Tallies = dict[Bin, Tally]
"""What was planned -> what came of it."""


class Recipe(NamedTuple):
    """A treatment with the chance that it leads to a certain goal."""

    treatment: Treatment
    chance: float


class Recipes:
    """What is known of the interactions of one cross product.

    Args:
        coordinates: how many of its coordinates are planned.
    """

    def __init__(self, coordinates: int) -> None:
        self.coordinates = coordinates
        self.results: dict[Treatment, Tallies] = {UNDISTURBED: {}}
        self.leading: dict[Goal, dict[Treatment, None]] = {}
        """Goal -> the treatments that led to it, in order; used as ordered sets."""
        self.effects: dict[Bin, dict[Effect, None]] = {}
        """What was planned -> what came of it; used as ordered sets."""
        self.seen_with: dict[Goal, Counter[Effect]] = {}
        """Goal -> how often it was part of which effect."""
        self.run_values: dict[tuple[Dose, Goal], RunValues] = {}
        """A dose and a goal that was reached with it -> the parameters of the first such run: it may owe to them."""
        self.seen: list[Interaction] = []
        """All interactions, in order."""
        self._undisturbed: dict[Bin, Counter[Effect]] = {}
        self._usual: dict[Bin, Effect] = {}
        self._assumed: dict[Bin, Effect | None] = {}
        self._first: Tallies = {}
        self._of_kind: dict[Kind, Tallies] = {}
        self._foreign: dict[tuple[Effect, Goal], Tally] = {}
        """What usually comes, and a goal -> first tries of foreign treatments that were to lead to it."""
        self._same = [1.0] * coordinates
        self._compared = [2.0] * coordinates

    def learn(self, interactions: Iterable[Interaction]) -> None:
        """Learn from the interactions of a run."""
        for each in interactions:
            planned, treatment, effect, is_clean, _, run_values = each
            if treatment or is_clean:  # what lasts from before is no result of doing nothing
                self._add_result(each)
            for goal in effect:
                self.seen_with.setdefault(goal, Counter())[effect] += 1
                for dose in treatment:
                    self.run_values.setdefault((dose, goal), run_values)
                if treatment:
                    self.leading.setdefault(goal, {})[treatment] = None
            self.seen.append(each)
            if is_clean and not treatment:
                counts = self._undisturbed.setdefault(planned, Counter())
                counts[effect] += 1
                self._usual[planned] = max(counts, key=lambda effect: (counts[effect], effect))
            self.effects.setdefault(planned, {})[effect] = None
        self._assumed.clear()

    def _add_result(self, interaction: Interaction) -> None:
        planned, treatment, effect, _, aims, _ = interaction
        results = self.results.setdefault(treatment, {})
        if treatment and not results:
            self._first.setdefault(planned, Tally()).add(effect)
        elif treatment and self._is_foreign(results, planned):
            for goal in aims:
                self._foreign.setdefault((self.usual(planned) or (), goal), Tally()).add(effect)
        self._compare(results, planned, effect)
        results.setdefault(planned, Tally()).add(effect)
        self._of_kind.setdefault(_kind(treatment), {}).setdefault(planned, Tally()).add(effect)

    def usual(self, planned: Bin) -> Effect | None:
        """What most often comes without disturbances where this is planned.

        Where it was never run so, it is what comes where something alike is planned; None where nothing alike is known.
        """
        if planned in self._usual:
            return self._usual[planned]
        if planned not in self._assumed:
            likeness = {other: self.likeness(planned, other) for other in sorted(self._usual)}
            alike = max(likeness, key=lambda other: likeness[other], default=planned)
            self._assumed[planned] = self._usual[alike] if likeness.get(alike, 0.0) >= ALIKE else None
        return self._assumed[planned]

    def likeness(self, planned: Bin, other: Bin) -> float:
        """How much what was seen where `other` is planned says of where `planned` is, from 0 to 1."""
        weight = 1.0
        for place, (one, two) in enumerate(zip(planned, other, strict=True)):
            if one != two:
                weight *= (self._same[place] / self._compared[place]) ** 2
        return weight

    def chance(
        self, planned: Bin, treatment: Treatment, goal: Goal, like: Treatment | None = None, expected: float = HOPE
    ) -> float:
        """The probability that a treatment leads to a goal where this is planned.

        Args:
            planned: in the interaction.
            treatment: of it.
            goal: that it may lead to.
            like: the treatment of longer interactions that it was made from, which counts until it was tried itself;
                None where it was not.
            expected: the probability before anything was seen of it.
        """
        kin = self._of_kind.get(_kind(treatment), {}).get(planned) if treatment else None
        results = self.results.get(treatment) or self.results.get(like or treatment, {})
        return self._estimate(results, planned, goal, kin, expected)

    def weight_of_tries(self, planned: Bin, treatment: Treatment) -> float:
        """How many tries the chance of a treatment where this is planned rests on; hearsay counts as some."""
        return HEARSAY + self.results.get(treatment, {}).get(planned, Tally()).tries

    def first_chance(self, planned: Bin, goal: Goal) -> float:
        """The same of a treatment that was never tried."""
        return self._estimate(self._first, planned, goal)

    def best(self, planned: Bin, goal: Goal, commands: int) -> Recipe | None:
        """The treatment that most probably leads to a goal, among those, or parts of those, that led to it elsewhere.

        Args:
            planned: in the interaction.
            goal: that it is to lead to.
            commands: of the interaction: a treatment has to fit in.
        """
        leading = [each for each in self.leading.get(goal, {}) if self._has_merit(each, goal)]
        parts = (part for each in leading if len(each) > 1 for part in combinations(each, len(each) - 1))
        best: Recipe | None = None
        expected = HOPE * self._trust(planned, goal)
        for each in dict.fromkeys((*leading, *parts)):
            treatment = fitted(each, commands)
            chance = self.chance(planned, treatment, goal, like=each, expected=expected)
            if best is None or chance > best.chance:
                best = Recipe(treatment, chance)
        return best

    def _has_merit(self, treatment: Treatment, goal: Goal) -> bool:
        """Whether a treatment led to something where that is unusual without it."""
        return any(
            tally.came[goal] and self.chance(planned, UNDISTURBED, goal) < USUAL
            for planned, tally in self.results[treatment].items()
        )

    def _is_foreign(self, results: Tallies, planned: Bin) -> bool:
        """Whether all that is known of a treatment was seen where something else usually comes."""
        usual = self.usual(planned)
        return all(other != planned and self.usual(other) != usual for other in results)

    def _trust(self, planned: Bin, goal: Goal) -> float:
        """How often foreign treatments have led to a goal where the same usually comes as where this is planned."""
        tally = self._foreign.get((self.usual(planned) or (), goal), Tally())
        return (TRUST + tally.came[goal]) / (TRUST + tally.tries)

    def _estimate(
        self,
        results: Mapping[Bin, Tally],
        planned: Bin,
        goal: Goal,
        kin: Tally | None = None,
        expected: float = HOPE,
    ) -> float:
        """What was seen of what is alike, and of the same doses with other parameters, is expected before own tries."""
        led, tried = DOUBT * expected, DOUBT
        if kin:
            led += KINSHIP * kin.came[goal]
            tried += KINSHIP * kin.tries
        usual, trust = self.usual(planned), self._trust(planned, goal)
        for other, tally in results.items():
            if other != planned:
                weight = self.likeness(planned, other)
                led += weight * tally.came[goal] * (1.0 if self.usual(other) == usual else trust)
                tried += weight * tally.tries
        strength, own = min(tried, HEARSAY), results.get(planned, Tally())
        return (strength * led / tried + own.came[goal]) / (strength + own.tries)

    def _compare(self, results: Mapping[Bin, Tally], planned: Bin, effect: Effect) -> None:
        for other, tally in results.items():
            places = [place for place, (one, two) in enumerate(zip(planned, other, strict=True)) if one != two]
            if len(places) == 1:
                shares = [tally.came[goal] / tally.tries for goal in effect]
                self._same[places[0]] += sum(shares) / len(shares) if shares else 0.0
                self._compared[places[0]] += 1.0


def fitted(treatment: Treatment, commands: int) -> Treatment:
    """The treatment for an interaction of so many commands: doses come within it, after its first command."""
    return tuple(sorted(dose._replace(place=min(max(dose.place, 1), commands)) for dose in treatment))


def _kind(treatment: Treatment) -> Kind:
    return tuple((dose.place, dose.name) for dose in treatment)
