"""The pool: all abstract tests of the explored model, indexed by their interactions and the plans that they execute.

The strategies of the closing loop choose tests from it, and insert disturbances into them.
"""

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
        exploration: the runs of the model, all of them or those that are known.
        space: the belief space.
        planned: cross product -> its function `planned`; without products that have none.
        order: beliefs -> which actions of other actors precede each action in the model's run.
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
        """The tests, those with few beliefs first. Other methods refer to a test by its number in this list."""
        return self.exploration.runs

    def interactions(self, number: int) -> tuple[PlannedInteraction, ...]:
        """The interactions of a test, grouped by cross product, each group in order."""
        if number not in self._interactions:
            lines = self.tests[number].lines
            self._interactions[number] = tuple(
                PlannedInteraction(product, tuple(coordinates))
                for product, planned in self.planned.items()
                for coordinates in planned(lines)
            )
        return self._interactions[number]

    def interactions_of(self, number: int, product: str) -> list[PlannedInteraction]:
        """The interactions of a test that belong to one cross product, in order."""
        return [interaction for interaction in self.interactions(number) if interaction.product == product]

    @cached_property
    def by_interaction(self) -> dict[PlannedInteraction, list[int]]:
        """Interaction -> the tests that plan it."""
        numbers: dict[PlannedInteraction, list[int]] = {}
        for number in range(len(self.tests)):
            for interaction in dict.fromkeys(self.interactions(number)):
                numbers.setdefault(interaction, []).append(number)
        return numbers

    @cached_property
    def by_plan(self) -> dict[tuple[str, str], list[int]]:
        """Agent and label of a plan -> the tests in which the model executes it."""
        plans = self.exploration.plans
        numbers: dict[tuple[str, str], list[int]] = {plan: [] for plan in plans}
        for number, test in enumerate(self.tests):
            for place, plan in enumerate(plans):
                if test.plans >> place & 1:
                    numbers[plan].append(number)
        return numbers

    def commands(self, interaction: PlannedInteraction) -> int:
        """The number of commands of an interaction, in the first test that plans it."""
        number = self.by_interaction[interaction][0]
        return self.sizes(number, interaction.product)[
            self.interactions_of(number, interaction.product).index(interaction)
        ]

    def any(self, rng: Random) -> int:
        """The number of a random test."""
        return random_index(rng, len(self.tests))

    def draft(
        self, number: int, product: str = "", combinations: Sequence[Combination] = (), run_values: RunValues = ()
    ) -> AbstractDraft:
        """A test of the pool, as it is or with disturbances.

        Args:
            number: the test.
            product: the cross product whose interactions are disturbed.
            combinations: the combination for each of these interactions, in order.
            run_values: parameters of the run; the others are drawn.
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
        """The line at which each interaction of a test begins; a test without interactions counts as a single one."""
        planned = self.planned.get(product)
        return (starts_of(self.tests[number].lines, planned) if planned is not None else ()) or (0,)

    def sizes(self, number: int, product: str) -> list[int]:
        """The number of commands of each interaction of a test, in order."""
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
    """The order of actions after disturbances are inserted between the lines of a test, which renumbers the actions."""
    if not after:
        return NO_ORDER
    places = [0, *(place for place, line in enumerate(lines, 1) if actor_of(line))]
    return {places[number]: tuple(places[cause] for cause in causes) for number, causes in after.items()}
