"""The pool: the abstract tests that the explored model gives, by their interactions and the plans executed for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from random import Random

from pytest_hricdv.extra.closing.interactions import (
    Combination,
    Planned,
    PlannedInteraction,
    RunValues,
    insert_combinations,
    starts_of,
)
from pytest_hricdv.generate.abstract import AbstractDraft, Plans
from pytest_hricdv.generate.actors import NO_ORDER, After, actor_of
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import random_index


class Pool:
    """The abstract tests of an explored model.

    Args:
        exploration: of the model: all of its runs, or those that are known.
        space: the belief space.
        planned: `planned` of each cross product that has it.
        order: which actions come after which of other actors in the model's run with these beliefs.
    """

    def __init__(
        self,
        exploration: Exploration,
        space: BeliefSpace,
        planned: Mapping[str, Planned],
        order: Callable[[tuple[str, ...]], After] = lambda beliefs: NO_ORDER,
    ) -> None:
        self.exploration = exploration
        self.planned = dict(planned)
        self._order = order
        self._space = space
        self._interactions: dict[int, tuple[PlannedInteraction, ...]] = {}

    @property
    def tests(self) -> Sequence[ExploredRun]:
        """The tests, those of few beliefs first."""
        return self.exploration.runs

    def interactions(self, number: int) -> tuple[PlannedInteraction, ...]:
        """The interactions of a test, cross product by cross product, each in order."""
        if number not in self._interactions:
            lines = self.tests[number].lines
            self._interactions[number] = tuple(
                PlannedInteraction(product, tuple(coordinates))
                for product, planned in self.planned.items()
                for coordinates in planned(lines)
            )
        return self._interactions[number]

    def interactions_of(self, number: int, product: str) -> list[PlannedInteraction]:
        """Those of one cross product, in order."""
        return [interaction for interaction in self.interactions(number) if interaction.product == product]

    @cached_property
    def by_interaction(self) -> dict[PlannedInteraction, list[int]]:
        """The tests that plan an interaction."""
        numbers: dict[PlannedInteraction, list[int]] = {}
        for number in range(len(self.tests)):
            for interaction in dict.fromkeys(self.interactions(number)):
                numbers.setdefault(interaction, []).append(number)
        return numbers

    @cached_property
    def by_plan(self) -> dict[tuple[str, str], list[int]]:
        """The tests for which the model executes a plan: agent and label -> numbers."""
        plans = self.exploration.plans
        numbers: dict[tuple[str, str], list[int]] = {plan: [] for plan in plans}
        for number, test in enumerate(self.tests):
            for place, plan in enumerate(plans):
                if test.plans >> place & 1:
                    numbers[plan].append(number)
        return numbers

    def commands(self, interaction: PlannedInteraction) -> int:
        """How many commands an interaction has: in the first test that plans it."""
        number = self.by_interaction[interaction][0]
        return self.sizes(number, interaction.product)[
            self.interactions_of(number, interaction.product).index(interaction)
        ]

    def any(self, rng: Random) -> int:
        """Any test."""
        return random_index(rng, len(self.tests))

    def draft(
        self, number: int, product: str = "", combinations: Sequence[Combination] = (), run_values: RunValues = ()
    ) -> AbstractDraft:
        """A test of the pool, as it is or disturbed.

        Args:
            number: of the test.
            product: the cross product whose interactions are disturbed.
            combinations: of each of them, in order.
            run_values: parameters of the run as a whole; the others are drawn.
        """
        test = self.tests[number]
        lines, values = test.lines, dict[int, dict[str, float]]()
        if any(combinations):
            lines, values = insert_combinations(test.lines, self.starts(number, product), combinations)
        if run_values:
            values[RUN] = dict(run_values)
        beliefs = self.exploration.belief_set(test.beliefs)
        after = with_disturbances(self._order(beliefs), lines)
        return AbstractDraft(self._space.target(beliefs), beliefs, lines, self._plans(test), values=values, after=after)

    def starts(self, number: int, product: str) -> tuple[int, ...]:
        """Where the interactions of a test begin; a test without any is one interaction as a whole."""
        planned = self.planned.get(product)
        return (starts_of(self.tests[number].lines, planned) if planned is not None else ()) or (0,)

    def sizes(self, number: int, product: str) -> list[int]:
        """How many commands the interactions of a test have, in order."""
        starts = self.starts(number, product)
        ends = (*starts[1:], len(self.tests[number].lines))
        return [end - start for start, end in zip(starts, ends, strict=True)]

    def _plans(self, test: ExploredRun) -> Plans:
        plans: dict[str, list[str]] = {agent: [] for agent, _ in self.exploration.plans}
        for place, (agent, label) in enumerate(self.exploration.plans):
            if test.plans >> place & 1:
                plans[agent].append(label)
        return {agent: tuple(sorted(labels)) for agent, labels in sorted(plans.items())}


def with_disturbances(after: After, lines: Sequence[str]) -> After:
    """The order of a test between whose lines disturbances have been put: actions have other numbers then."""
    if not after:
        return NO_ORDER
    places = [0, *(place for place, line in enumerate(lines, 1) if actor_of(line))]
    return {places[number]: tuple(places[cause] for cause in causes) for number, causes in after.items()}
