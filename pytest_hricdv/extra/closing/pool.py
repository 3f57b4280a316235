"""`Pool`: all abstract tests of the explored model, indexed by their interactions and the plans that they execute.

`ClosureGenerator` makes it; the strategies choose tests from it, and its method `draft` inserts disturbances into them.
An interaction has what it plans, its interventions, and its effect. A cross product with `planned` says which
combination of its first coordinates each interaction of a test plans. An interaction begins with the command at which
`planned` of the commands so far returns one combination more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.generate.abstract import AbstractDraft, Plans, disturbance_line, disturbance_of
from pytest_hricdv.generate.actors import NO_ORDER, After, actor_of
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.chosen_values import Values
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import random_index

Planned = Callable[[Sequence[str]], Iterable[Bin]]
"""`CrossProduct.planned`: a test's commands -> what each of its interactions plans."""


class Intervention(NamedTuple):
    """One disturbance in an interaction: after a number of its commands, with its parameters."""

    place: int
    name: str
    values: tuple[tuple[str, float], ...] = ()


Combination = tuple[Intervention, ...]
"""The interventions in one interaction, in order."""

UNDISTURBED: Combination = ()  # no intervention


Outcome = tuple[str, ...]
"""How an interaction ends in one cross product: its name, and the unplanned coordinates of the bin."""

Effect = tuple[Outcome, ...]
"""How an interaction ends in all cross products: its outcomes, sorted."""


class PlannedInteraction(NamedTuple):
    """An interaction before it is run: a cross product, and the first coordinates of its bin."""

    product: str
    planned: Bin


class Interaction(NamedTuple):
    """One interaction of a run.

    Args:
        planned: the first coordinates of its bin.
        combination: its interventions.
        effect: how it ended.
        is_isolated: whether no earlier interaction of the run had interventions whose effects could carry over.
    """

    planned: Bin
    combination: Combination
    effect: Effect
    is_isolated: bool = True


def commands_of(lines: Sequence[str]) -> tuple[str, ...]:
    """The commands of a test without its disturbances."""
    return tuple(line for line in lines if disturbance_of(line) is None)


def starts_of(commands: Sequence[str], planned: Planned) -> tuple[int, ...]:
    """The place of the first command of each interaction."""
    sizes = [len([*planned(commands[:place])]) for place in range(len(commands) + 1)]
    return tuple(place for place in range(len(commands)) for _ in range(sizes[place + 1] - sizes[place]))


def combinations_of(lines: Sequence[str], values: Values, starts: Sequence[int]) -> tuple[Combination, ...]:
    """The interventions in each interaction of a test.

    A disturbance right before the first command of an interaction belongs to the one before, if there is one.

    Args:
        starts: where its interactions begin, among its commands.
    """
    interventions: list[list[Intervention]] = [[] for _ in starts]
    place = number = 0
    for row, line in enumerate(lines, 1):
        while number + 1 < len(starts) and place > starts[number + 1]:
            number += 1
        if (name := disturbance_of(line)) is None:
            place += 1
        elif starts:
            chosen = tuple(sorted(values.get(row, {}).items()))
            interventions[number].append(Intervention(place - starts[number], name, chosen))
    return tuple(map(tuple, interventions))


def insert_combinations(
    commands: Sequence[str], starts: Sequence[int], combinations: Sequence[Combination]
) -> tuple[tuple[str, ...], dict[int, dict[str, float]]]:
    """Lines and values of a test with these interventions in its interactions; the reverse of `combinations_of`."""
    at: dict[int, list[Intervention]] = {}
    for start, combination in zip(starts, combinations, strict=False):
        for intervention in combination:
            at.setdefault(min(max(start + intervention.place, 0), len(commands)), []).append(intervention)
    lines: list[str] = []
    values: dict[int, dict[str, float]] = {}
    for place in range(len(commands) + 1):
        for intervention in at.get(place, ()):
            lines.append(disturbance_line(intervention.name))
            if intervention.values:
                values[len(lines)] = dict(intervention.values)
        lines += commands[place : place + 1]
    return tuple(lines), values


def interactions_of(
    lines: Sequence[str], values: Values, hits: Mapping[str, Sequence[Bin]], product: str, planned: Planned
) -> tuple[Interaction, ...]:
    """The interactions of a run, as far as they have a bin of the cross product.

    A run may end before its test, and an interaction may have no bin: a bin belongs to the next interaction that
    plans its first coordinates. Other cross products are part of the effect where they have as many bins.

    Args:
        lines: the lines of its test.
        values: the values of its test.
        hits: cross product -> the bins of its interactions, in their order.
        product: the cross product in question.
        planned: `planned` of this cross product.
    """
    commands, own = commands_of(lines), hits.get(product, ())
    combinations = combinations_of(lines, values, starts_of(commands, planned))
    plans = [tuple(coordinates) for coordinates in planned(commands)][: len(combinations)]
    alike = {name: bins for name, bins in hits.items() if len(bins) == len(own)}
    interactions = []
    for row, number in _match(plans, own):
        size = len(plans[number])
        effect = tuple(sorted((name, *bins[row][size if name == product else 0 :]) for name, bins in alike.items()))
        is_isolated = not any(combinations[:number])
        interactions.append(Interaction(plans[number], combinations[number], effect, is_isolated))
    return tuple(interactions)


def _match(plans: Sequence[Bin], hits: Sequence[Bin]) -> Iterator[tuple[int, int]]:
    """The row of each bin, with the number of the interaction that it belongs to."""
    begin = 0
    for row, hit in enumerate(hits):
        number = next((place for place in range(begin, len(plans)) if hit[: len(plans[place])] == plans[place]), None)
        if number is not None:
            begin = number + 1
            yield row, number


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

    @cached_property
    def by_commands(self) -> dict[tuple[str, ...], int]:
        """The commands of a test -> its number."""
        return {test.lines: number for number, test in enumerate(self.tests)}

    def commands(self, interaction: PlannedInteraction) -> int:
        """The number of commands of an interaction, in the first test that plans it."""
        number = self.by_interaction[interaction][0]
        return self.sizes(number, interaction.product)[
            self.interactions_of(number, interaction.product).index(interaction)
        ]

    def any(self, rng: Random) -> int:
        """The number of a random test."""
        return random_index(rng, len(self.tests))

    def draft(self, number: int, product: str = "", combinations: Sequence[Combination] = ()) -> AbstractDraft:
        """A test of the pool, as it is or with disturbances.

        Args:
            number: the test.
            product: the cross product whose interactions are disturbed.
            combinations: the combination for each of these interactions, in order.
        """
        test = self.tests[number]
        lines, values = test.lines, dict[int, dict[str, float]]()
        if any(combinations):
            lines, values = insert_combinations(test.lines, self.starts(number, product), combinations)
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
