"""Selects the abstract test and the interventions that will probably hit the most open bins at once."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.pool import (
    UNDISTURBED,
    Combination,
    Outcome,
    PlannedInteraction,
    Pool,
)
from pytest_hricdv.extra.closing.strategy import Archive, draw_good
from pytest_hricdv.generate.rng import random_index

CANDIDATES = 48
"""Number of tests with a wanted interaction that are compared: there may be thousands; see the package."""


class Option(NamedTuple):
    """An option for an interaction.

    Args:
        gain: how many open bins it will probably hit.
        outcomes: the outcomes that it is to lead to.
        combination: makes up its interventions, for its number of commands, and whether it is the first one.
    """

    gain: float
    outcomes: tuple[Outcome, ...]
    combination: Callable[[int, bool], Combination]


Options = Callable[[PlannedInteraction, dict[Outcome, float]], list[Option]]
"""The options for an interaction with wanted outcomes (outcome -> how open it still is, 1 to 0), best first; without
wanted outcomes, what the strategy may try there."""


class TestSelection(NamedTuple):
    """A test with combinations for its interactions of a cross product, and the points that it is to hit."""

    test: int
    product: str
    combinations: tuple[Combination, ...]
    targets: tuple[Point, ...]


class Selection:
    """Selects the tests of a generation; points that one will probably hit are worth less to the next ones.

    Args:
        pool: the pool of abstract tests.
        experience: the experience of all runs so far.
        archive: what is open.
        options: what may be done with an interaction.
    """

    def __init__(self, pool: Pool, experience: Experience, archive: Archive, options: Options) -> None:
        self._pool = pool
        self._make_options = options
        self._targets = experience.open_outcomes(archive)
        self._openness = dict.fromkeys((point for points in self._targets.values() for point in points.values()), 1.0)
        self._options: dict[PlannedInteraction, list[Option]] = {}

    def select(self, rng: Random) -> TestSelection | None:
        """Select one test; None if no gain is expected."""
        gains = {interaction: options[0].gain for interaction in self._targets if (options := self._of(interaction))}
        gains = {interaction: gain for interaction, gain in gains.items() if gain > 0.0}
        if not gains:
            return None
        interaction = draw_good(rng, gains)
        # Twice as many draws as there are tests leave out one in seven of them.
        tests = self._pool.by_interaction[interaction]
        candidates = [tests[random_index(rng, len(tests))] for _ in range(min(CANDIDATES, 2 * len(tests)))]
        test = max(candidates, key=lambda number: self._gain(number, interaction.product))
        return self._make_selection(test, interaction.product)

    def _of(self, interaction: PlannedInteraction) -> list[Option]:
        if interaction not in self._options:
            points = self._targets.get(interaction, {})
            wanted = {outcome: self._openness[point] for outcome, point in points.items()}
            self._options[interaction] = self._make_options(interaction, wanted)
        return self._options[interaction]

    def _gain(self, number: int, product: str) -> float:
        """The expected number of open bins that a test hits."""
        used: dict[PlannedInteraction, int] = {}
        gain = 0.0
        for interaction in self._pool.interactions_of(number, product):
            options, place = self._of(interaction), used.get(interaction, 0)
            gain += options[place].gain if place < len(options) else 0.0
            used[interaction] = place + 1
        return gain

    def _make_selection(self, test: int, product: str) -> TestSelection:
        interactions, sizes = self._pool.interactions_of(test, product), self._pool.sizes(test, product)
        combinations: list[Combination] = []
        targets: list[Point] = []
        for place, interaction in enumerate(interactions):
            options = self._of(interaction)
            if not options:
                combinations.append(UNDISTURBED)
                continue
            gain, outcomes, combination = options[0]
            combinations.append(combination(sizes[place], place == 0))
            points = [self._targets[interaction][outcome] for outcome in outcomes]
            for point in points:
                self._openness[point] *= 1.0 - min(gain / len(points), 1.0)
            targets += points
            self._options.pop(interaction)
        return TestSelection(test, product, tuple(combinations), tuple(targets))
