"""Effects of single interventions: how probably each one brings about a condition that an effect lacks.

The effect on one of several characters, as in a pattern of sensors, is taken to be independent of the others. Bayes'
theorem tells it from chance, as sensors err.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import chain
from math import exp, lgamma, log, log1p
from typing import NamedTuple

from pytest_hricdv.extra.closing.experience import (
    CharacterCondition,
    EffectCondition,
    MissingCondition,
    are_comparable,
    character,
    effect_distance,
    find_missing,
    is_changed,
    is_met,
    is_missing,
)
from pytest_hricdv.extra.closing.outcome_model import INDIRECT_WEIGHT, PRIOR_TRIES, OutcomeModel, fit_combination
from pytest_hricdv.extra.closing.pool import Combination, Effect, Intervention

ERROR_RATE, ERROR_PRIOR_TRIES = 0.05, 20.0
"""Rate at which a missing condition is met by chance, and the tries that this prior weighs; see the package."""

PRIOR_EFFECTIVE = 0.1
"""Probability that a disturbance brings about a condition, before it was tried: few do; see the package."""


class Deviation(NamedTuple):
    """A combination whose most frequent effect is not the nominal one, this effect, and how probable it is."""

    combination: Combination
    effect: Effect
    chance: float


class EffectChange(NamedTuple):
    """An intervention that changed an effect, the conditions that it made missing, and how often its disturbance does
    so."""

    intervention: Intervention
    conditions: tuple[MissingCondition, ...]
    chance: float


class Trial(NamedTuple):
    """A try of an intervention.

    Args:
        intervention: that was tried.
        before: what would probably have come without it: effects of the others alone, or the nominal one.
        after: the effect that came.
        weight: how much this counts.
    """

    intervention: Intervention
    before: tuple[Effect, ...]
    after: Effect
    weight: float


class InterventionEffects:
    """The effects of interventions, as tries of them have shown.

    Args:
        model: what is known; nothing more is learned while this is used.
    """

    def __init__(self, model: OutcomeModel) -> None:
        self._model = model
        self._singles: list[Trial] = []
        self._undisturbed: list[tuple[Effect, Effect]] = []
        """The nominal effect, and the one that came without disturbances."""
        for planned, combination, effect, is_isolated, *_ in model.interactions:
            nominal = model.nominal(planned)
            if nominal is not None and are_comparable(nominal, effect):
                if len(combination) == 1:
                    weight = 1.0 if is_isolated else INDIRECT_WEIGHT
                    self._singles.append(Trial(combination[0], (nominal,), effect, weight))
                elif not combination and is_isolated:
                    self._undisturbed.append((nominal, effect))
        self._deviations: dict[Effect, list[Deviation]] = {}
        self._changes: dict[Effect, list[EffectChange]] = {}
        self._effects_alone: dict[Effect, dict[Intervention, Effect]] = {}
        self._chances: dict[tuple[MissingCondition, int], dict[Intervention, float]] = {}
        self._combined = [*self._with_others()]

    def chances(self, condition: MissingCondition, commands: int) -> dict[Intervention, float]:
        """Intervention -> the probability that it brings about a missing condition; without those that never did.

        An intervention that inverted a character probably inverts it both ways, as a fault of a sensor does. Tries in
        combinations count for interventions that did it alone. Effects that chance may explain, as sensors err, count
        less.

        Args:
            condition: that is missing.
            commands: of the interaction: interventions come within it.
        """
        chances = self._chances.get((condition, commands))
        if chances is None:
            tries: dict[Intervention | str, float] = defaultdict(float)
            met: dict[Intervention | str, float] = defaultdict(float)
            # After all single tries it is known which tries in combinations count.
            combined = (trial for trial in self._combined if met[trial.intervention.name])
            for trial in chain(self._singles, combined):
                weight, weight_met = _weigh(trial, condition)
                keys: tuple[Intervention | str, ...] = (
                    *fit_combination((trial.intervention,), commands),
                    trial.intervention.name,
                )
                for key in keys:
                    tries[key] += weight
                    met[key] += weight_met
            significances = self._significances(condition)
            chances = self._chances[condition, commands] = {
                key: significances[key.name]
                * (met[key] + PRIOR_TRIES * met[key.name] / (tries[key.name] + PRIOR_TRIES))
                / (tries[key] + PRIOR_TRIES)
                for key in met
                if isinstance(key, Intervention) and met[key]
            }
        return chances

    def _significances(self, condition: MissingCondition) -> dict[str, float]:
        """Disturbance -> the probability that it is what brought about a missing condition, and not chance.

        By single tries: in a combination, another intervention may have done it. A condition is met by chance as often
        as without disturbances and with the other ones: most do nothing to it, and some make sensors err more often.
        """
        tried, met = dict[str, float](), dict[str, float]()
        for trial in self._singles:
            name, (weight, weight_met) = trial.intervention.name, _weigh(trial, condition)
            tried[name] = tried.get(name, 0.0) + weight
            met[name] = met.get(name, 0.0) + weight_met
        undisturbed = [
            is_met(effect, condition) for nominal, effect in self._undisturbed if is_missing(nominal, condition)
        ]
        tries, came = len(undisturbed) + sum(tried.values()), sum(undisturbed) + sum(met.values())
        return {
            name: significance(met[name], tried[name], _rate_by_chance(came - met[name], tries - tried[name]))
            for name in tried
        }

    def deviations(self, nominal: Effect) -> list[Deviation]:
        """The combinations that made something else of a nominal effect; of each other one, the most certain."""
        deviations = self._deviations.get(nominal)
        if deviations is None:
            best: dict[Effect, Deviation] = {}
            for deviation in self._all_deviations(nominal):
                likeliest = best.setdefault(deviation.effect, deviation)
                if deviation.chance > likeliest.chance:
                    best[deviation.effect] = deviation
            deviations = self._deviations[nominal] = [*best.values()]
        return deviations

    def changes(self, nominal: Effect) -> list[EffectChange]:
        """The interventions that changed something that is so in a nominal effect.

        Where it was seen, another effect may have been nominal, if it has the same characters where these were changed.
        """
        changes = self._changes.get(nominal)
        if changes is None:
            conditions = {trial.intervention: find_missing(trial.after, trial.before[0]) for trial in self._singles}
            changes = self._changes[nominal] = [
                EffectChange(intervention, changed, chance)
                for intervention, changed in conditions.items()
                if changed and (chance := self._change_chance(intervention.name, changed, nominal))
            ]
        return changes

    def _change_chance(self, name: str, conditions: tuple[MissingCondition, ...], nominal: Effect) -> float:
        """The rate at which a disturbance removes these conditions where they are met; 0 if they never were.

        Effects that chance may explain, as sensors err, count less.
        """

        def is_alike(before: Effect) -> bool:
            met = (
                isinstance(condition, CharacterCondition) and is_met(before, condition) and is_met(nominal, condition)
                for condition in conditions
            )
            return before == nominal or all(met)

        alike = [trial for trial in self._singles if trial.intervention.name == name and is_alike(trial.before[0])]
        tries = sum(trial.weight for trial in alike)
        came = sum(trial.weight for trial in alike if find_missing(trial.after, trial.before[0]) == conditions)
        by_chance = [
            find_missing(effect, before) == conditions for before, effect in self._undisturbed if is_alike(before)
        ]
        rate = _rate_by_chance(sum(by_chance), len(by_chance))
        return significance(came, tries, rate) * came / (tries + PRIOR_TRIES)

    def chance_of_any(self, name: str, nominal: Effect) -> float:
        """The probability that a disturbance has any effect beyond chance where this effect is nominal."""
        trials = [
            (trial.weight, trial.after != nominal)
            for trial in self._singles
            if (trial.intervention.name, trial.before[0]) == (name, nominal)
        ]
        by_chance = [effect != nominal for before, effect in self._undisturbed if before == nominal]
        tries, changed = sum(weight for weight, _ in trials), sum(weight for weight, differs in trials if differs)
        rate = _rate_by_chance(sum(by_chance), len(by_chance))
        return significance(changed, tries, rate) * (changed + PRIOR_TRIES) / (tries + PRIOR_TRIES)

    def _all_deviations(self, nominal: Effect) -> Iterator[Deviation]:
        effects: dict[Combination, dict[Effect, float]] = {}
        for planned, combination, effect, is_isolated, *_ in self._model.interactions:
            if combination and self._model.nominal(planned) == nominal and are_comparable(nominal, effect):
                weights = effects.setdefault(combination, {})
                weights[effect] = weights.get(effect, 0.0) + (1.0 if is_isolated else INDIRECT_WEIGHT)
        for combination, weights in effects.items():
            effect = max(weights, key=lambda effect: (weights[effect], effect))
            if effect != nominal:
                chance = weights[effect] / (sum(weights.values()) + PRIOR_TRIES)
                yield Deviation(combination, effect, chance)

    def _with_others(self) -> Iterator[Trial]:
        """The interventions of combinations of several, each with the effects that the others have alone."""
        for planned, combination, effect, is_isolated, *_ in self._model.interactions:
            nominal = self._model.nominal(planned)
            if len(combination) > 1 and nominal is not None and are_comparable(nominal, effect):
                alone = self._alone(nominal)
                for intervention in combination:
                    others = [alone[other] for other in combination if other in alone and other != intervention]
                    weight = 1.0 if is_isolated else INDIRECT_WEIGHT
                    yield Trial(intervention, (*others, nominal), effect, weight)

    def _alone(self, nominal: Effect) -> dict[Intervention, Effect]:
        """Intervention -> the effect, other than the nominal one, that it most often has alone."""
        if nominal not in self._effects_alone:
            self._effects_alone[nominal] = {
                deviation.combination[0]: deviation.effect
                for deviation in self._all_deviations(nominal)
                if len(deviation.combination) == 1
            }
        return self._effects_alone[nominal]

    def chances_of_change(self, names: Iterable[str], condition: CharacterCondition) -> dict[str, float]:
        """Disturbance -> how often it probably changes a character, whatever it becomes.

        Of two tries before all, one is taken to have done so: what was hardly tried is promising. Where nothing
        comparable came, as where there was no reading, a try says nothing of it.
        """
        # Laplace's rule of succession
        tries, changed = dict.fromkeys(names, 2.0), dict.fromkeys(names, 1.0)
        for intervention, (before,), after, weight in self._singles:
            if intervention.name in tries and character(before, condition) and character(after, condition):
                tries[intervention.name] += weight
                changed[intervention.name] += weight * is_changed(before, after, condition)
        return {name: changed[name] / tries[name] for name in tries}


def significance(came: float, tries: float, by_chance: float) -> float:
    """The probability that something has its own effect, given the number of tries with the wanted result.

    By Bayes' theorem of two hypotheses: it has no effect, and results come by chance; or it has one, whose rate is not
    known (uniform from 0 to 1). A result of one try says little where sensors err, and less after a try in vain.

    Args:
        came: the tries with the result; they may be weighted.
        tries: all tries.
        by_chance: the rate of the result without it, above 0 and below 1.
    """
    vain = tries - came
    effect = lgamma(came + 1.0) + lgamma(vain + 1.0) - lgamma(tries + 2.0)
    chance = came * log(by_chance) + vain * log1p(-by_chance)
    # exp() overflows above 709.78, the logarithm of the greatest float.
    odds = PRIOR_EFFECTIVE / (1.0 - PRIOR_EFFECTIVE) * exp(min(effect - chance, 700.0))
    return odds / (1.0 + odds)


def _rate_by_chance(came: float, tries: float) -> float:
    return (came + ERROR_RATE * ERROR_PRIOR_TRIES) / (tries + ERROR_PRIOR_TRIES)


def _share_before(trial: Trial, condition: EffectCondition) -> float:
    """The similarity of the effect before a try to the one to be changed; 0 without one."""
    return max([0.0, *(1.0 - effect_distance(before, condition.present) for before in trial.before)])


def _weigh(trial: Trial, condition: MissingCondition) -> tuple[float, float]:
    """The weight of a try of which a condition was missing before, and of this, how much that it was met then."""
    if isinstance(condition, EffectCondition):
        weight = trial.weight * _share_before(trial, condition)
        return weight, weight * is_met(trial.after, condition)
    before = next((effect for effect in trial.before if character(effect, condition)), None)
    if before is None:
        return 0.0, 0.0
    if not is_met(before, condition):
        return trial.weight, trial.weight * is_met(trial.after, condition)
    return INDIRECT_WEIGHT * trial.weight, INDIRECT_WEIGHT * trial.weight * is_changed(before, trial.after, condition)
