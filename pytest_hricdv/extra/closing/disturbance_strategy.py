"""The strategy `disturbances`: disturbs interactions so that they will probably end in a way that no run has shown yet.

`DisturbanceStrategy.propose`, called by the closing loop, uses a combination that has led to an outcome again where it
may lead to an open bin, or a combination that `CombinationSynthesis` makes (exploitation). It also tries new
interventions, of disturbances that were rarely tried where the same outcome is nominal (exploration).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from random import Random

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
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.rng import pick, random_index
from pytest_hricdv.generate.sampler import Sampler

Try = tuple[str, Outcome | None]
"""A disturbance, and the nominal outcome of the interaction in which it is tried."""

MIN_CHANCE = 0.01
"""Least chance of a wanted outcome with which a combination is used. For the choice of constants see the package."""

NEW_CHANCE = 0.015
"""Expected chance that a new intervention leads to a wanted outcome."""

VARYING = 0.35
"""Probability that an intervention of a known or synthesized combination is varied."""

EXPLORING = 0.4
"""Probability of a new intervention in an interaction, whatever combinations are known."""

MIN_UNTARGETED = 0.25
"""Smallest share of tests in which all interactions have a rarely tried disturbance. The share of open points that are
no bins counts instead if it is larger."""

Disturbances = Mapping[str, Mapping[str, Sampler]]
"""Name of a disturbance -> the ranges of its parameters."""


class DisturbanceStrategy:
    """Adds interventions to tests of the pool so that interactions end as none has ended yet."""

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
                draft = self._pool.draft(selected.test, selected.product, selected.combinations)
                proposals.append(Proposal(draft, self.name, selected.targets))
        return proposals

    def _rarely_tried(self, generation: _Generation) -> Proposal:
        """A test with disturbances that were rarely tried: for open points that are not bins.

        Each is tried once before any is tried again where the same outcome is nominal: what was not tried there may be
        all that is missing.
        """
        test, product = generation.newest_test()
        interactions: list[PlannedInteraction | None] = [*self._pool.interactions_of(test, product)]
        starts, sizes = self._pool.starts(test, product), self._pool.sizes(test, product)
        combinations = [
            generation.single(interaction, size, start == starts[0])
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
        self._synthesis = {name: CombinationSynthesis(model) for name, model in experience.models.items()}
        self._by_nominal: dict[Outcome | None, list[PlannedInteraction]] = {}
        """A nominal outcome -> the interactions that have it."""
        for interaction in pool.by_interaction:
            self._by_nominal.setdefault(experience.nominal(interaction), []).append(interaction)

    def options(self, interaction: PlannedInteraction, wanted: dict[Outcome, float]) -> list[Option]:
        """See `selection.Options`."""
        outcomes, planned, new = tuple(wanted), interaction.planned, partial(self.single, interaction)
        if not wanted or self._rng.random() < EXPLORING:
            return [Option(NEW_CHANCE * sum(wanted.values()), outcomes, new)]
        model, commands = self._experience.models[interaction.product], self._pool.commands(interaction)
        options: list[Option] = []
        for outcome, openness in wanted.items():
            synthesized = self._synthesis[interaction.product].synthesize(planned, outcome, commands, self._rng)
            best = model.best(planned, outcome, commands)
            if best is not None and best.chance >= MIN_CHANCE:
                options.append(Option(best.chance * openness, (outcome,), partial(_again, best.combination)))
            if synthesized is not None and synthesized.chance >= MIN_CHANCE:
                varied = partial(self._vary, synthesized.combination)
                options.append(Option(synthesized.chance * openness, (outcome,), varied))
        options.append(Option(NEW_CHANCE * sum(wanted.values()), outcomes, new))
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

    def single(self, interaction: PlannedInteraction | None, commands: int, is_first: bool) -> Combination:
        """A disturbance tried as rarely as any where the same outcome is nominal, or at the start; at any place."""
        nominal = None if interaction is None else self._experience.nominal(interaction)
        starts: list[Try] = [(name, AT_THE_START) for name in self._disturbances if is_first]
        new = [start for start in starts if not self._tries[start]]
        name, where = self._rarest([(name, nominal) for name in self._disturbances], new)
        if where == AT_THE_START:
            return (self._intervention(name, 0),)
        return (self._intervention(name, self._any_place(commands)),)

    def _any_place(self, commands: int) -> int:
        return 1 + random_index(self._rng, max(commands, 1))  # of no commands, after the last

    def _rarest(self, choices: Sequence[Try], preferred: Sequence[Try]) -> Try:
        """One of the least taken choices; a preferred one, if it is among these."""
        rarest = min(self._tries[choice] for choice in (*preferred, *choices))
        rare = [choice for choice in preferred if self._tries[choice] == rarest]
        choice = pick(self._rng, rare or [choice for choice in choices if self._tries[choice] == rarest])
        self._tries[choice] += 1
        return choice

    def _vary(self, combination: Combination, commands: int, is_first: bool) -> Combination:
        """The combination; at times one intervention gets another place and other parameters, as its joint effect may
        depend on them."""
        if not combination or self._rng.random() >= VARYING:
            return combination
        varied = pick(self._rng, combination)
        other = self._intervention(varied.name, self._any_place(commands))
        return tuple(sorted(other if intervention == varied else intervention for intervention in combination))

    def _intervention(self, name: str, place: int) -> Intervention:
        return draw_intervention(self._disturbances, name, place, self._rng)


def draw_intervention(disturbances: Disturbances, name: str, place: int, rng: Random) -> Intervention:
    """A disturbance at a place, with parameters drawn from its ranges."""
    ranges = sorted(disturbances[name].items())
    return Intervention(place, name, tuple((parameter, sampler.sample(rng)) for parameter, sampler in ranges))


def _again(combination: Combination, commands: int, is_first: bool) -> Combination:
    return combination
