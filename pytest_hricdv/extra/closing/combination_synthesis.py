"""`CombinationSynthesis`: makes combinations of interventions that were never tried, for the strategy `disturbances`.

It starts from a combination whose effect is known, and adds an intervention for each condition that this effect misses:
one that brought the condition about elsewhere, when it was tried alone. The effect on one of several characters, as in
a pattern of sensors, is taken to be independent of the others.

Without synthesis, none of four loops of `tests/extra/closing/test_strategies.py` closes within 400 runs; with it, all
do.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from math import prod
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.experience import (
    EffectCondition,
    MissingCondition,
    are_comparable,
    character,
    effect_distance,
    find_missing,
)
from pytest_hricdv.extra.closing.outcome_model import (
    INDIRECT_WEIGHT,
    PRIOR_TRIES,
    CombinationCandidate,
    OutcomeModel,
    fit_combination,
)
from pytest_hricdv.extra.closing.pool import UNDISTURBED, Combination, Effect, Intervention, Outcome
from pytest_hricdv.extra.closing.strategy import draw_good

MAX_INTERVENTIONS = 5
"""Maximum number of interventions in an interaction; for its choice see the package."""


class Deviation(NamedTuple):
    """A combination whose most frequent effect is not the nominal one, that effect, and its probability."""

    combination: Combination
    effect: Effect
    chance: float


class Trial(NamedTuple):
    """A try of an intervention alone: the probable effect without it, the effect with it, and the weight of the try."""

    intervention: Intervention
    before: Effect
    after: Effect
    weight: float


class CombinationSynthesis:
    """Synthesizes combinations of interventions from a model that learns nothing more while this is used."""

    def __init__(self, model: OutcomeModel) -> None:
        self._model = model
        self._trials: list[Trial] = []
        for planned, combination, effect, is_isolated in model.interactions:
            nominal = model.nominal(planned)
            if len(combination) == 1 and nominal is not None and are_comparable(nominal, effect):
                self._trials.append(Trial(combination[0], nominal, effect, 1.0 if is_isolated else INDIRECT_WEIGHT))
        self._deviations: dict[Effect, list[Deviation]] = {}
        self._chances: dict[tuple[MissingCondition, int], dict[Intervention, float]] = {}

    def synthesize(self, planned: Bin, outcome: Outcome, commands: int, rng: Random) -> CombinationCandidate | None:
        """A combination that may lead to an outcome in an interaction with this number of commands.

        Its chance is what is expected before it is tried. None if a condition is missing that no intervention has
        brought about.
        """
        wanted, nominal = self._target_effect(planned, outcome), self._model.nominal(planned)
        if wanted is None or nominal is None:
            return None
        deviations = [Deviation(UNDISTURBED, nominal, 1.0), *self._find_deviations(nominal, commands)]
        chances = {
            deviation: chance for deviation in deviations if (chance := self._chance(deviation, wanted, commands)) > 0.0
        }
        if not chances:
            return None
        deviation = draw_good(rng, chances)
        added = {
            draw_good(rng, self.chances(condition, commands)) for condition in find_missing(deviation.effect, wanted)
        }
        combination = fit_combination(tuple({*deviation.combination, *added}), commands)
        if not combination or len(combination) > MAX_INTERVENTIONS:
            return None
        chance = self._model.chance(planned, combination, outcome, expected=chances[deviation])
        return CombinationCandidate(combination, chance)

    def _target_effect(self, planned: Bin, outcome: Outcome) -> Effect | None:
        """The effect that an outcome was most often part of; if it was never seen, it is part of the nominal one."""
        counts, nominal = self._model.effects_with.get(outcome), self._model.nominal(planned)
        if counts:
            return max(counts, key=lambda effect: (counts[effect], effect))
        if not nominal:
            return None
        return tuple(outcome if present[0] == outcome[0] else present for present in nominal)

    def _chance(self, deviation: Deviation, wanted: Effect, commands: int) -> float:
        """The probability that a deviation comes, and that the missing conditions then come about."""
        conditions = find_missing(deviation.effect, wanted)
        if len(conditions) > MAX_INTERVENTIONS:
            return 0.0
        best = (max(self.chances(condition, commands).values(), default=0.0) for condition in conditions)
        return deviation.chance * prod(best)

    def _find_deviations(self, nominal: Effect, commands: int) -> Iterator[Deviation]:
        """The known deviations; one of a longer interaction, of which interventions have to be moved, until this was
        tried."""
        for deviation in self.deviations(nominal):
            combination = fit_combination(deviation.combination, commands)
            if combination == deviation.combination or combination not in self._model.results:
                yield deviation

    def deviations(self, nominal: Effect) -> list[Deviation]:
        """The combinations that made something else of a nominal effect; of each other one, the most certain."""
        if nominal not in self._deviations:
            best: dict[Effect, Deviation] = {}
            for deviation in self._all_deviations(nominal):
                likeliest = best.setdefault(deviation.effect, deviation)
                if deviation.chance > likeliest.chance:
                    best[deviation.effect] = deviation
            self._deviations[nominal] = [*best.values()]
        return self._deviations[nominal]

    def _all_deviations(self, nominal: Effect) -> Iterator[Deviation]:
        effects: dict[Combination, Counter[Effect]] = {}
        for planned, combination, effect, _ in self._model.interactions:
            if combination and self._model.nominal(planned) == nominal and are_comparable(nominal, effect):
                effects.setdefault(combination, Counter())[effect] += 1
        for combination, counts in effects.items():
            effect = max(counts, key=lambda effect: (counts[effect], effect))
            if effect != nominal:
                yield Deviation(combination, effect, counts[effect] / (counts.total() + PRIOR_TRIES))

    def chances(self, condition: MissingCondition, commands: int) -> dict[Intervention, float]:
        """Intervention -> the probability that it brings about a missing condition; without those that never did.

        Args:
            condition: the condition that is missing.
            commands: number of commands of the interaction, within which interventions come.
        """
        key = condition, commands
        if key not in self._chances:
            tried, met = defaultdict[Intervention, float](float), defaultdict[Intervention, float](float)
            names_tried, names_met = defaultdict[str, float](float), defaultdict[str, float](float)
            for trial in self._trials:
                weight, weight_met = _weigh(trial, condition)
                [fitting] = fit_combination((trial.intervention,), commands)
                tried[fitting] += weight
                names_tried[fitting.name] += weight
                met[fitting] += weight_met
                names_met[fitting.name] += weight_met
            shares = {name: names_met[name] / (names_tried[name] + PRIOR_TRIES) for name in names_met}
            self._chances[key] = {
                each: (met[each] + PRIOR_TRIES * shares[each.name]) / (tried[each] + PRIOR_TRIES)
                for each in met
                if met[each]
            }
        return self._chances[key]


def _weigh(trial: Trial, condition: MissingCondition) -> tuple[float, float]:
    """The weight of a try that lacked a condition before, and how much of it counts as meeting the condition.

    An intervention that inverted a character probably inverts it both ways, as a fault of a sensor does.
    """
    _, before, after, weight = trial
    if isinstance(condition, EffectCondition):
        weight *= max(0.0, 1.0 - effect_distance(before, condition.present))
        return weight, weight * (after == condition.wanted)
    old, new = character(before, condition), character(after, condition)
    if not old:
        return 0.0, 0.0
    if old != condition.wanted:
        return weight, weight * (new == condition.wanted)
    return INDIRECT_WEIGHT * weight, INDIRECT_WEIGHT * weight * (new not in ("", old))
