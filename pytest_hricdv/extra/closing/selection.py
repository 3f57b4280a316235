"""`Selection`: chooses the abstract test and the interventions that will probably hit the most open bins at once.

The strategies `model` and `disturbances` make one per generation, each with a function that returns the `Option`s that
the strategy has for an interaction, and call `select` for each proposal.
"""

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
"""Maximum number of tests with a wanted interaction that are compared, as a pool may have thousands of them. For its
choice see the package."""


class Option(NamedTuple):
    """What a strategy may try in an interaction.

    Args:
        gain: the expected number of open bins that the option hits.
        outcomes: the outcomes that it aims at.
        combination: makes the interventions, given the interaction's number of commands and whether it is the first.
    """

    gain: float
    outcomes: tuple[Outcome, ...]
    combination: Callable[[int, bool], Combination]


Options = Callable[[PlannedInteraction, dict[Outcome, float]], list[Option]]
"""The options of an interaction, best first, given its wanted outcomes (outcome -> how open it still is, 1 to 0);
without wanted outcomes, whatever the strategy may try there."""


class TestSelection(NamedTuple):
    """A test with combinations for its interactions of a cross product, and the points that it aims at."""

    test: int
    product: str
    combinations: tuple[Combination, ...]
    targets: tuple[Point, ...]


class Selection:
    """Selects the tests of a generation; a point that one test will probably hit is worth less to the next.

    Args:
        pool: the pool of abstract tests.
        experience: the experience from all runs so far.
        archive: all runs so far, which say what is open.
        options: lists the options of an interaction.
    """

    def __init__(self, pool: Pool, experience: Experience, archive: Archive, options: Options) -> None:
        self._pool = pool
        self._make_options = options
        self._targets = experience.open_outcomes(archive)
        self._openness = dict.fromkeys((point for points in self._targets.values() for point in points.values()), 1.0)
        self._options: dict[PlannedInteraction, list[Option]] = {}

    def select(self, rng: Random) -> TestSelection | None:
        """Select one test; None if no gain is expected."""
        best = {interaction: options[0] for interaction in self._targets if (options := self._options_of(interaction))}
        gains = {interaction: option.gain for interaction, option in best.items() if option.gain > 0.0}
        if not gains:
            return None
        interaction = draw_good(rng, gains)
        # With twice as many draws as tests, one test in seven is never drawn.
        tests = self._pool.by_interaction[interaction]
        candidates = [tests[random_index(rng, len(tests))] for _ in range(min(CANDIDATES, 2 * len(tests)))]
        test = max(candidates, key=lambda number: self._gain(number, interaction.product))
        return self._make_selection(test, interaction.product)

    def _options_of(self, interaction: PlannedInteraction) -> list[Option]:
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
            options, place = self._options_of(interaction), used.get(interaction, 0)
            gain += options[place].gain if place < len(options) else 0.0
            used[interaction] = place + 1
        return gain

    def _make_selection(self, test: int, product: str) -> TestSelection:
        interactions, sizes = self._pool.interactions_of(test, product), self._pool.sizes(test, product)
        combinations: list[Combination] = []
        targets: list[Point] = []
        for place, interaction in enumerate(interactions):
            options = self._options_of(interaction)
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
