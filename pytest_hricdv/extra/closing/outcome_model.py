"""A surrogate model of interactions: the probability with which a combination of interventions leads to an outcome.

`Experience` has an `OutcomeModel` for each cross product, and lets it learn from all runs. What a combination did in
interactions with other planned coordinates is evidence as well. How much it counts is learned for each planned
coordinate, from how often the same combination had the same effect where only this coordinate differed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.pool import (
    UNDISTURBED,
    Combination,
    Effect,
    Interaction,
    Outcome,
)

PRIOR_TRIES = 1.0
"""Number of tries that weigh as much as the expectation before any try. For the choice of constants see the package."""

PRIOR_CHANCE = 0.25
"""Expected chance that a first try leads to an outcome, while nothing is known."""

INDIRECT_WEIGHT = 0.5
"""Weight of a similar try: of the same disturbances with other parameters, or after an earlier disturbance in the run
whose effects may last."""

MAX_BORROWED_TRIES = 2.0
"""Number of own tries that weigh as much as all tries where other coordinates are planned."""

PRIOR_SAME, PRIOR_COMPARED = 1.0, 2.0
"""Assumed comparisons with the same effect, and all comparisons, before the first one: Laplace's rule of succession."""

MIN_SIMILARITY = (PRIOR_SAME / PRIOR_COMPARED) ** 2
"""Smallest similarity of coordinates at which a nominal effect is taken over: that of coordinates never compared."""


@dataclass
class Trials:
    """A number of tries of combinations, and how many of them ended with each outcome."""

    tries: int = 0
    outcomes: Counter[Outcome] = field(default_factory=Counter)

    def add(self, effect: Effect) -> None:
        """Count one more try."""
        self.tries += 1
        self.outcomes.update(effect)


TrialsByPlan = dict[Bin, Trials]
"""The planned coordinates -> the tries there."""


class CombinationCandidate(NamedTuple):
    """A combination, with the chance that it leads to a certain outcome."""

    combination: Combination
    chance: float


class OutcomeModel:
    """A model of the interactions of one cross product.

    Args:
        coordinates: how many of its coordinates are planned.
    """

    def __init__(self, coordinates: int) -> None:
        self.coordinates = coordinates
        self.results: dict[Combination, TrialsByPlan] = {UNDISTURBED: {}}
        self.leading: dict[Outcome, dict[Combination, None]] = {}
        """Outcome -> the combinations that led to it, in order; used as ordered sets."""
        self.effects: dict[Bin, dict[Effect, None]] = {}
        """The planned coordinates -> the effects there; used as ordered sets."""
        self.effects_with: dict[Outcome, Counter[Effect]] = {}
        """Outcome -> how often it was part of which effect."""
        self.interactions: list[Interaction] = []
        """All interactions, in order."""
        self._undisturbed: dict[Bin, Counter[Effect]] = {}
        self._nominal: dict[Bin, Effect] = {}
        self._assumed: dict[Bin, Effect | None] = {}
        self._same = [PRIOR_SAME] * coordinates
        self._compared = [PRIOR_COMPARED] * coordinates

    def learn(self, interactions: Iterable[Interaction]) -> None:
        """Learn from the interactions of a run."""
        for interaction in interactions:
            planned, combination, effect, is_isolated = interaction
            if combination or is_isolated:  # a disturbance that lasts from before is no result of doing nothing
                self._add_result(interaction)
            for outcome in effect:
                self.effects_with.setdefault(outcome, Counter())[effect] += 1
                if combination:
                    self.leading.setdefault(outcome, {})[combination] = None
            self.interactions.append(interaction)
            if is_isolated and not combination:
                counts = self._undisturbed.setdefault(planned, Counter())
                counts[effect] += 1
                self._nominal[planned] = max(counts, key=lambda effect: (counts[effect], effect))
            self.effects.setdefault(planned, {})[effect] = None
        self._assumed.clear()

    def _add_result(self, interaction: Interaction) -> None:
        results = self.results.setdefault(interaction.combination, {})
        self._compare(results, interaction.planned, interaction.effect)
        results.setdefault(interaction.planned, Trials()).add(interaction.effect)

    def nominal(self, planned: Bin) -> Effect | None:
        """The nominal effect: the most frequent one without disturbances where these coordinates are planned.

        Where they were never run so, it is the one of the most similar coordinates; None if none are similar.
        """
        if planned in self._nominal:
            return self._nominal[planned]
        if planned not in self._assumed:
            similarity = {other: self.similarity(planned, other) for other in sorted(self._nominal)}
            nearest = max(similarity, key=lambda other: similarity[other], default=planned)
            is_similar = similarity.get(nearest, 0.0) >= MIN_SIMILARITY
            self._assumed[planned] = self._nominal[nearest] if is_similar else None
        return self._assumed[planned]

    def similarity(self, planned: Bin, other: Bin) -> float:
        """The relevance, from 0 to 1, of effects where `other` is planned for those where `planned` is.

        For each coordinate that differs, the square of the share of comparisons with the same effect.
        """
        weight = 1.0
        for place, (left, right) in enumerate(zip(planned, other, strict=True)):
            if left != right:
                weight *= (self._same[place] / self._compared[place]) ** 2
        return weight

    def chance(
        self,
        planned: Bin,
        combination: Combination,
        outcome: Outcome,
        like: Combination | None = None,
        expected: float = PRIOR_CHANCE,
    ) -> float:
        """The probability that a combination leads to an outcome where these coordinates are planned.

        Own tries count; before them, what was seen where similar coordinates are planned.

        Args:
            planned: the coordinates.
            combination: the interaction's combination.
            outcome: the outcome that it may lead to.
            like: the combination of longer interactions that it was made from, which counts until it was tried itself;
                None if it was not.
            expected: the probability before anything was seen of it.
        """
        results = self.results.get(combination) or self.results.get(like or combination, {})
        led, tried = PRIOR_TRIES * expected, PRIOR_TRIES
        for other, trials in results.items():
            if other != planned:
                weight = self.similarity(planned, other)
                led += weight * trials.outcomes[outcome]
                tried += weight * trials.tries
        borrowed, own = min(tried, MAX_BORROWED_TRIES), results.get(planned, Trials())
        return (borrowed * led / tried + own.outcomes[outcome]) / (borrowed + own.tries)

    def best(self, planned: Bin, outcome: Outcome, commands: int) -> CombinationCandidate | None:
        """The combination that most probably leads to an outcome, among those that once did.

        Args:
            planned: the coordinates of the interaction.
            outcome: the outcome that it is to lead to.
            commands: number of commands of the interaction, into which a combination has to fit.
        """
        best: CombinationCandidate | None = None
        for like in self.leading.get(outcome, {}):
            combination = fit_combination(like, commands)
            chance = self.chance(planned, combination, outcome, like=like)
            if best is None or chance > best.chance:
                best = CombinationCandidate(combination, chance)
        return best

    def _compare(self, results: Mapping[Bin, Trials], planned: Bin, effect: Effect) -> None:
        for other, trials in results.items():
            places = [place for place, (left, right) in enumerate(zip(planned, other, strict=True)) if left != right]
            if len(places) == 1:
                shares = [trials.outcomes[outcome] / trials.tries for outcome in effect]
                self._same[places[0]] += sum(shares) / len(shares) if shares else 0.0
                self._compared[places[0]] += 1.0


def fit_combination(combination: Combination, commands: int) -> Combination:
    """The combination for an interaction of this many commands: interventions come within it, after the first one."""
    return tuple(
        sorted(intervention._replace(place=min(max(intervention.place, 1), commands)) for intervention in combination)
    )
