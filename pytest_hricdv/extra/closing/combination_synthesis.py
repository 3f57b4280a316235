"""Synthesis of combinations that were never tried, from interventions whose effects are known.

A known combination may make an interaction end as another one nominally does; and for each condition that is missing
then, there may be an intervention that brought it about elsewhere.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import combinations
from math import prod
from random import Random

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Combination, Effect, Intervention, Outcome
from pytest_hricdv.extra.closing.intervention_effects import Change, Deviation, InterventionEffects
from pytest_hricdv.extra.closing.missing_conditions import (
    CharacterCondition,
    EffectCondition,
    MissingCondition,
    missing_conditions,
)
from pytest_hricdv.extra.closing.outcome_model import PRIOR_TRIES, Candidate, OutcomeModel, fitted
from pytest_hricdv.extra.closing.strategy import CHOICES, favoured
from pytest_hricdv.generate.rng import pick, pick_weighted, shuffle

TriedTogether = dict[frozenset[str], list[tuple[MissingCondition, ...]]]
"""Disturbances that were tried together -> the conditions that were missing then, each time."""

MAX_INTERVENTIONS = 5
"""An interaction has at most so many. Chosen (4: -1.5 +- 3.0, 6: -0.3 +- 0.5; see the package)."""

DROPPED_FACTOR = 0.5
"""A combination of more loses some. Each that is left out may have been needed: it is expected so much less. Chosen: as
likely needed as not (0.25: -0.4 +- 0.8, 0.75: no change; see the package)."""

RELIABLE = 0.4
"""A combination that leads to an outcome with at least this chance is known to lead there. Chosen (0.2: no change; see
the package)."""


class CombinationSynthesis:
    """Puts combinations together.

    Args:
        model: what is known; nothing more is learned while this is used.
    """

    def __init__(self, model: OutcomeModel) -> None:
        self._model = model
        self._effects = InterventionEffects(model)
        self._vain: dict[tuple[Effect, Outcome, int], Counter[Effect]] = {}

    def drawn(self, planned: Bin, outcome: Outcome, commands: int, rng: Random) -> Candidate | None:
        """A combination that may lead to an outcome in an interaction of so many commands.

        Its chance is what is expected before it is tried. None where a condition is missing that no intervention has
        brought about.
        """
        wanted, nominal = self._wanted(planned, outcome), self._model.nominal(planned)
        if wanted is None or nominal is None:
            return None
        deviations = [Deviation(UNDISTURBED, nominal, 1.0), *self._fitting(nominal, commands)]
        vain = self._vain.get((nominal, outcome, commands))
        if vain is None:
            vain = self._vain[nominal, outcome, commands] = self._in_vain(nominal, outcome, wanted, commands)
        chances = {
            deviation: chance
            for deviation in deviations
            if (chance := self._chance(deviation, wanted, vain, commands)) > 0.0
        }
        if not chances:
            return None
        deviation = favoured(rng, chances)
        added = {
            favoured(rng, self._effects.chances(condition, commands))
            for condition in missing_conditions(deviation.effect, wanted)
        }
        kept = shuffle(rng, [*deviation.combination])[: MAX_INTERVENTIONS - len(added)]
        combination = fitted(tuple({*kept, *added}), commands)
        if not combination:
            return None
        chance = self._model.chance(planned, combination, outcome, expected=chances[deviation])
        return Candidate(combination, chance)

    def _fitting(self, nominal: Effect, commands: int) -> Iterator[Deviation]:
        """The known deviations; one of a longer interaction, of which interventions have to be moved, until this was
        tried."""
        for deviation in self._effects.deviations(nominal):
            combination = fitted(deviation.combination, commands)
            if combination == deviation.combination or combination not in self._model.results:
                yield deviation

    def reduced(self, planned: Bin, commands: int, rng: Random) -> Combination | None:
        """A combination that changed the nominal effect, without one of its interventions; it was never tried.

        What comes then says which interventions it takes. None where no such combination is known.
        """
        nominal = self._model.nominal(planned)
        deviations = () if nominal is None else tuple(self._fitting(nominal, commands))
        parts = dict.fromkeys(
            fitted(part, commands)
            for deviation in deviations
            if len(deviation.combination) > 1
            for part in combinations(deviation.combination, len(deviation.combination) - 1)
        )
        untried = [part for part in parts if part not in self._model.results]
        return pick(rng, untried) if untried else None

    def masked(self, planned: Bin, commands: int, rng: Random) -> Combination | None:
        """An intervention that probably changes the effect, with those of other disturbances that may mask this.

        What seems nominal and is not leads to checks in the code that are beyond the first ones. Of several, it is
        rather one whose disturbances were rarely combined. None where no way to mask a change is known.
        """
        nominal = self._model.nominal(planned)
        changes = {} if nominal is None else self._changes(nominal)
        if nominal is None or not changes:
            return None
        together = self._tried_together(nominal, nominal)
        drawn = [self._masking((), pick_weighted(rng, changes), together, commands, rng) for _ in range(CHOICES)]
        by_names = {_names(combination): combination for combination in drawn if len(combination) > 1}
        rare = {combination: 1.0 / (1 + len(together.get(names, ()))) for names, combination in by_names.items()}
        return pick_weighted(rng, rare) if rare else None

    def beside(self, planned: Bin, outcome: Outcome, commands: int, rng: Random) -> Combination | None:
        """What is known to lead to an outcome, and an intervention that changes it where it is nominal.

        What hides the person's state from the code may mask such a change as well: where all sensors are wrong, a part
        that is pulled out changes nothing that they say. None where nothing leads there, or no such one is known.
        """
        candidate, wanted = self._model.best(planned, outcome, commands), self._wanted(planned, outcome)
        nominal = self._model.nominal(planned)
        if candidate is None or wanted is None or nominal is None or candidate.chance < RELIABLE:
            return None
        names = _names(candidate.combination)
        changes = {
            change: chance
            for change, chance in self._changes(wanted).items()
            if change.intervention.name not in names
            and not any(isinstance(condition, EffectCondition) for condition in change.conditions)
        }
        if not changes or len(candidate.combination) >= MAX_INTERVENTIONS:
            return None
        change = pick_weighted(rng, changes)._replace(conditions=())
        together = self._tried_together(nominal, wanted)
        return self._masking(candidate.combination, change, together, commands, rng)

    def _changes(self, nominal: Effect) -> dict[Change, float]:
        """Interventions that change an effect -> how often to choose them: by how probably their disturbance does
        anything, but the less, the more often it was masked and nothing else came of it."""
        changes, sums = self._effects.changes(nominal), dict[str, float]()
        for change in changes:
            name = change.intervention.name
            sums[name] = sums.get(name, 0.0) + change.chance
        masked = Counter(
            name
            for interaction in self._model.interactions
            if len(interaction.combination) > 1 and interaction.effect == nominal
            for name in _names(interaction.combination)
        )
        often = {name: self._effects.chance_of_any(name, nominal) / (1 + masked[name]) for name in sums}
        return {
            change: often[change.intervention.name] * change.chance / sums[change.intervention.name]
            for change in changes
        }

    def _masking(
        self, combination: Combination, change: Change, together: TriedTogether, commands: int, rng: Random
    ) -> Combination:
        """A combination and a change, with interventions for the conditions that are missing then.

        Where these disturbances were tried together before, so are those for what was still missing: a part that is
        pulled out sooner lies elsewhere, where other sensors miss it.
        """
        combination = fitted((*combination, change.intervention), commands)
        conditions = change.conditions or together.get(_names(combination), [()])[-1]
        while conditions:
            others = [self._others(condition, _names(combination), commands) for condition in conditions]
            if not all(others) or len(combination) + len(others) > MAX_INTERVENTIONS:
                break
            added = dict.fromkeys(favoured(rng, chances) for chances in others)
            combination = fitted((*combination, *added), commands)
            conditions = together.get(_names(combination), [()])[-1]
        return combination

    def _others(self, condition: MissingCondition, names: frozenset[str], commands: int) -> dict[Intervention, float]:
        chances = self._effects.chances(condition, commands)
        return {intervention: chance for intervention, chance in chances.items() if intervention.name not in names}

    def _tried_together(self, nominal: Effect, wanted: Effect) -> TriedTogether:
        """Where this effect is nominal: disturbances that were tried together, not for an outcome, with the conditions
        that were missing each time.

        Where an effect came that differs in more than characters, something else went wrong: it was not tried.
        """
        together: TriedTogether = {}
        for interaction in self._model.interactions:
            is_free = len(interaction.combination) > 1 and not interaction.wanted
            if is_free and self._model.nominal(interaction.planned) == nominal:
                conditions = missing_conditions(interaction.effect, wanted)
                if not any(isinstance(condition, EffectCondition) for condition in conditions):
                    together.setdefault(_names(interaction.combination), []).append(conditions)
        return together

    def expected_changes(
        self, names: Collection[str], planned: Bin, outcome: Outcome, commands: int
    ) -> dict[str, float]:
        """Disturbance -> how many of the missing characters its interventions probably change, of those that no known
        intervention brings about.

        Empty where no character is missing: that another effect comes does not promise that it is nearer.
        """
        wanted, nominal = self._wanted(planned, outcome), self._model.nominal(planned)
        expected: dict[str, float] = {}
        if wanted is None or nominal is None:
            return expected
        for condition in missing_conditions(nominal, wanted):
            if isinstance(condition, CharacterCondition):
                need = 1.0 - max(self._effects.chances(condition, commands).values(), default=0.0)
                for name, chance in self._effects.chances_of_change(names, condition).items():
                    expected[name] = expected.get(name, 0.0) + need * chance
        return expected

    def _wanted(self, planned: Bin, outcome: Outcome) -> Effect | None:
        """The effect that an outcome was most often part of; if it was never seen, it is part of the nominal one."""
        counts, nominal = self._model.effects_with.get(outcome), self._model.nominal(planned)
        if counts:
            return max(counts, key=lambda effect: (counts[effect], effect))
        if not nominal:
            return None
        return tuple(outcome if present[0] == outcome[0] else present for present in nominal)

    def _chance(self, deviation: Deviation, wanted: Effect, vain: Mapping[Effect, int], commands: int) -> float:
        """How probably a deviation comes, and what is missing then comes about: less, the more often it was in vain."""
        conditions = missing_conditions(deviation.effect, wanted)
        if len(conditions) > MAX_INTERVENTIONS:
            return 0.0
        best = (max(self._effects.chances(condition, commands).values(), default=0.0) for condition in conditions)
        chance = deviation.chance * prod(best)
        chance *= DROPPED_FACTOR ** max(0, len(deviation.combination) + len(conditions) - MAX_INTERVENTIONS)
        return chance * PRIOR_TRIES / (PRIOR_TRIES + vain.get(deviation.effect, 0))

    def _in_vain(self, nominal: Effect, outcome: Outcome, wanted: Effect, commands: int) -> Counter[Effect]:
        """The effect of a deviation -> how often the conditions missing then had good interventions, in vain.

        What is missing may not be what it seems: who is given nothing because there is nothing to give misses more than
        a good sensor.
        """
        deviating = {
            frozenset(deviation.combination): deviation.effect for deviation in self._effects.deviations(nominal)
        }
        vain: Counter[Effect] = Counter()
        for interaction in self._model.interactions:
            combination = interaction.combination
            is_in_vain = len(combination) > 1 and outcome in interaction.wanted and outcome not in interaction.effect
            if is_in_vain and self._model.nominal(interaction.planned) == nominal:
                effects = {deviating[part] for part in _parts(combination) if part in deviating} or {nominal}
                names = _names(combination)
                vain.update(effect for effect in effects if self._is_complete(effect, wanted, names, commands))
        return vain

    def _is_complete(self, effect: Effect, wanted: Effect, names: frozenset[str], commands: int) -> bool:
        """Whether these disturbances have a good intervention for each missing condition."""
        return all(self._good(condition, commands) & names for condition in missing_conditions(effect, wanted))

    def _good(self, condition: MissingCondition, commands: int) -> frozenset[str]:
        """The disturbances with interventions that are at least half as good as the best one.

        Half is chosen; its effect was not measured.
        """
        chances = self._effects.chances(condition, commands)
        best = max(chances.values(), default=0.0)
        return frozenset(intervention.name for intervention, chance in chances.items() if chance >= best / 2)


def _parts(combination: Combination) -> Iterator[frozenset[Intervention]]:
    """What may have been added to, to make a combination."""
    return (frozenset(part) for size in range(1, len(combination)) for part in combinations(combination, size))


def _names(combination: Combination) -> frozenset[str]:
    return frozenset(intervention.name for intervention in combination)
