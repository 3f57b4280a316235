"""The strategy `disturbances`: intervenes in interactions so that they probably end as none has ended yet.

A combination that has led to an outcome is used again where it may lead to an open bin (exploitation); so is one that
can be put together from interventions that have brought about what is missing. Beside that, new interventions are tried
(exploration): of disturbances that probably change what is missing, and of those that were rarely tried where the same
outcome is nominal.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from random import Random
from typing import TypeVar

from pytest_hricdv.extra.closing.combination_synthesis import CombinationSynthesis
from pytest_hricdv.extra.closing.experience import AT_THE_START, Experience
from pytest_hricdv.extra.closing.pool import (
    Combination,
    Intervention,
    Outcome,
    PlannedInteraction,
    Pool,
)
from pytest_hricdv.extra.closing.selection import CANDIDATES, Option, Selection
from pytest_hricdv.extra.closing.strategy import Archive, Proposal, draw_good
from pytest_hricdv.generate.rng import pick, random_index
from pytest_hricdv.generate.sampler import Sampler

T = TypeVar("T")

MIN_CHANCE = 0.01
"""A known or synthesized combination is used if it leads to an outcome with at least this chance; see the package."""

NEW_CHANCE = 0.015
"""Least chance expected of a new intervention; see the package."""

VARYING = 0.35
"""Probability that an intervention of such a combination is varied; see the package."""

EXPLORING = 0.4
"""Probability of a new intervention in an interaction, whatever is known; see the package."""

MIN_UNTARGETED = 0.25
"""Smallest share of tests in which all interactions have a rarely tried disturbance; the share of open points that are
no bins, if that is larger; see the package."""

MASKED = 0.75
"""Share of rarely tried combinations in which disturbances mask each other; see the package."""

Disturbances = Mapping[str, Mapping[str, Sampler]]
"""Name -> the ranges of its parameters."""


class DisturbanceStrategy:
    """Adds interventions to tests so that interactions end as none has ended yet.

    Args:
        pool: of abstract tests.
        experience: of all runs so far.
        disturbances: of the testbench.
    """

    name = "disturbances"

    def __init__(self, pool: Pool, experience: Experience, disturbances: Disturbances) -> None:
        self._pool = pool
        self._experience = experience
        self._disturbances = disturbances

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        if not self._disturbances or not self._pool.tests:
            return []
        self._experience.learn(archive)
        generation = _Generation(self._pool, self._experience, self._disturbances, archive, rng)
        selection = Selection(self._pool, self._experience, archive, generation.options)
        others = sum(point[0] != "bin" for point in archive.open)
        untargeted = max(MIN_UNTARGETED, others / len(archive.open)) if others else 0.0
        proposals = []
        for _ in range(count):
            selected = selection.select(rng) if rng.random() >= untargeted else None
            if selected is None:
                proposals.append(self._rarely_tried(generation))
            else:
                draft = self._pool.draft(selected.test, selected.product, selected.combinations, selected.run_values)
                proposals.append(Proposal(draft, self.name, selected.targets))
        return proposals

    def _rarely_tried(self, generation: _Generation) -> Proposal:
        """A test with disturbances that were rarely tried: for open points that are no bins.

        Each is tried once before any is tried again where the same outcome is nominal: what was not tried there may be
        all that is missing.
        """
        test, product = generation.newest_test()
        interactions: list[PlannedInteraction | None] = [*self._pool.interactions_of(test, product)]
        starts, sizes = self._pool.starts(test, product), self._pool.sizes(test, product)
        combinations = [
            generation.rare(interaction, size, start == starts[0])
            for interaction, start, size in zip(interactions or [None], starts, sizes, strict=True)
        ]
        return Proposal(self._pool.draft(test, product, combinations), self.name)


class _Generation:
    """The combinations of a generation."""

    def __init__(
        self, pool: Pool, experience: Experience, disturbances: Disturbances, archive: Archive, rng: Random
    ) -> None:
        self._pool = pool
        self._experience = experience
        self._disturbances = disturbances
        self._rng = rng
        self._tries = experience.tries.copy()
        self._tries_at = experience.tries_at.copy()
        self._has_others = any(point[0] != "bin" for point in archive.open)
        self._synthesis = {name: CombinationSynthesis(model) for name, model in experience.models.items()}
        self._open_counts = experience.count_open(archive)
        self._by_nominal: dict[Outcome | None, list[PlannedInteraction]] = {}
        """A nominal outcome -> the interactions that have it."""
        for interaction in pool.by_interaction:
            self._by_nominal.setdefault(experience.nominal(interaction), []).append(interaction)

    def options(self, interaction: PlannedInteraction, wanted: dict[Outcome, float]) -> list[Option]:
        """See `selection.Options`."""
        outcomes, planned = tuple(wanted), interaction.planned
        if not wanted:
            return [Option(0.0, (), partial(self.rare if self._has_others else self.single, interaction))]
        new = partial(self._new, interaction, outcomes)
        if self._rng.random() < EXPLORING:
            return [Option(NEW_CHANCE * sum(wanted.values()), outcomes, new)]
        model, commands = self._experience.models[interaction.product], self._pool.commands(interaction)
        options: list[Option] = []
        gain = 0.0
        for outcome, openness in wanted.items():
            bins = openness * self._open_counts.get((model.nominal(planned), outcome), 1)
            synthesized = self._synthesis[interaction.product].synthesize(planned, outcome, commands, self._rng)
            best = model.best(planned, outcome, commands)
            if best is not None and best.chance >= MIN_CHANCE:
                options.append(Option(best.chance * bins, (outcome,), partial(_again, best.combination)))
            if synthesized is not None and synthesized.chance >= MIN_CHANCE:
                varied = partial(self._vary, synthesized.combination)
                options.append(Option(synthesized.chance * bins, (outcome,), varied))
            gain += max(model.first_chance(planned, outcome), NEW_CHANCE) * bins
        options.append(Option(gain, outcomes, new))
        return sorted(options, key=lambda option: -option.gain)

    def newest_test(self) -> tuple[int, str]:
        """A test, and a cross product whose interactions have the nominal outcome where most is new."""
        if not self._by_nominal:
            return self._pool.any(self._rng), next(iter(self._pool.planned), "")
        novelty = {
            nominal: sum(1.0 / (1 + self._tries[name, nominal]) for name in self._disturbances)
            for nominal in self._by_nominal
        }
        interactions = self._by_nominal[max(novelty, key=lambda nominal: novelty[nominal])]
        drawn = [pick(self._rng, interactions) for _ in range(CANDIDATES)]
        candidates = [
            (pick(self._rng, self._pool.by_interaction[interaction]), interaction.product) for interaction in drawn
        ]
        wanted = frozenset(interactions)
        return max(
            candidates,
            key=lambda candidate: sum(interaction in wanted for interaction in self._pool.interactions(candidate[0])),
        )

    def rare(self, interaction: PlannedInteraction | None, commands: int, is_first: bool) -> Combination:
        """Rarely tried combinations: a new intervention, or known ones of which one masks the effect of another."""
        nominal = None if interaction is None else self._experience.nominal(interaction)
        is_known = interaction is not None and all(self._tries[name, nominal] for name in self._disturbances)
        if interaction is not None and is_known and self._rng.random() < MASKED:
            masked = self._synthesis[interaction.product].mask(interaction.planned, commands, self._rng)
            if masked is not None:
                return self._vary(masked, commands, False)
        return self.single(interaction, commands, is_first)

    def single(self, interaction: PlannedInteraction | None, commands: int, is_first: bool) -> Combination:
        """A disturbance tried as rarely as any where the same outcome is nominal, or at the start; at such a place."""
        nominal = None if interaction is None else self._experience.nominal(interaction)
        starts = [(name, AT_THE_START) for name in self._disturbances if is_first]
        new = [start for start in starts if not self._tries[start]]
        name, where = self._rarest([(name, nominal) for name in self._disturbances], self._tries, new)
        if where == AT_THE_START:
            return (self._intervention(name, 0),)
        return (self._intervention(name, self._place(name, nominal, commands)),)

    def _place(self, name: str, nominal: Outcome | None, commands: int) -> int:
        """Whether it was tried as rarely as any after this many commands where the same outcome is nominal."""
        places = [(name, nominal, place) for place in range(1, max(commands, 1) + 1)]  # of no commands, after the last
        return self._rarest(places, self._tries_at)[2]

    def _rarest(self, choices: Sequence[T], counts: Counter[T], preferred: Sequence[T] = ()) -> T:
        """One of the least taken choices; a preferred one, if it is among these."""
        rarest = min(counts[choice] for choice in (*preferred, *choices))
        rare = [choice for choice in preferred if counts[choice] == rarest]
        choice = pick(self._rng, rare or [choice for choice in choices if counts[choice] == rarest])
        counts[choice] += 1
        return choice

    def _new(
        self, interaction: PlannedInteraction, outcomes: Sequence[Outcome], commands: int, is_first: bool
    ) -> Combination:
        """A new intervention: of a disturbance that probably changes what is missing, or one that was rarely tried."""
        synthesis, outcome = self._synthesis[interaction.product], pick(self._rng, outcomes)
        expected = synthesis.promise_changes(self._disturbances, interaction.planned, outcome, commands, self._rng)
        if not expected:
            return self.single(interaction, commands, is_first)
        name = draw_good(self._rng, expected)
        return (self._intervention(name, self._place(name, self._experience.nominal(interaction), commands)),)

    def _vary(self, combination: Combination, commands: int, is_first: bool) -> Combination:
        """The combination; at times one intervention gets another place and other parameters, as its joint effect may
        depend on them."""
        if not combination or self._rng.random() >= VARYING:
            return combination
        varied = pick(self._rng, combination)
        other = self._intervention(varied.name, 1 + random_index(self._rng, max(commands, 1)))
        return tuple(sorted(other if intervention == varied else intervention for intervention in combination))

    def _intervention(self, name: str, place: int) -> Intervention:
        return draw_intervention(self._disturbances, name, place, self._rng)


def draw_intervention(disturbances: Disturbances, name: str, place: int, rng: Random) -> Intervention:
    """A disturbance at a place, with parameters drawn from its ranges."""
    ranges = sorted(disturbances[name].items())
    return Intervention(place, name, tuple((parameter, sampler.sample(rng)) for parameter, sampler in ranges))


def _again(combination: Combination, commands: int, is_first: bool) -> Combination:
    return combination
