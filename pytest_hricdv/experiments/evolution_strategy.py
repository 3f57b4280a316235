"""`search_violation` looks for a violation: it minimizes the margin, from the tests that came nearest to a violation.

`ViolationSearch` calls it; the closing loop's `ViolationStrategy` uses `mutate` and `next_width`. The method is a (1+1)
evolution strategy with the 1/5 success rule for the step width (I. Rechenberg: Evolutionsstrategie, 1973), on each of
a few starting tests. If one of them has not improved for a while, the next one is varied.

Why not `hypothesis.target`: Hypothesis runs its own loop around a test function, its random stream changes with its
version, and it would have to be installed to run a suite. Here a seed means the same search for years.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from random import Random

from pytest_hricdv.experiments.budget import Budget, BudgetSpentError, Ended
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, Parameters
from pytest_hricdv.generate.rng import pick, random_index
from pytest_hricdv.generate.sampler import Sampler, Sometimes, Uniform

PATIENCE = 8
"""Number of steps without improvement after which the next starting test is varied."""

FIRST_WIDTH = 0.1
"""Maximum size of the first step, as a share of a parameter's range; the 1/5 success rule adapts it."""

_WIDER, _NARROWER = 1.5, 1.5**-0.25  # with one success in five, the width stays the same
_WIDTHS = (0.01, 0.5)  # minimum and maximum step width, as shares of a range
_NEW_SAMPLE, _SIMPLE_VALUE = 0.1, 0.1  # shares of all changes; the rest are steps nearby


@dataclass(frozen=True)
class Evaluation:
    """The result of one run: its margin (None: nothing was compared), and whether it violated the requirement."""

    margin: float | None
    violated: bool

    @property
    def objective(self) -> float:
        """The quantity that is minimized."""
        if self.violated:
            return -math.inf
        return math.inf if self.margin is None else self.margin


@dataclass(frozen=True)
class SearchOutcome:
    """The best test of a search.

    Args:
        start: the number of the start it came from.
        runs: how many runs the search took.
        wall_s: how long it took (s of wall time).
    """

    test: ConcreteTest
    evaluation: Evaluation
    start: int
    runs: int
    wall_s: float
    ended: Ended


@dataclass
class _Individual:
    """The current test of one start."""

    start: int
    test: ConcreteTest
    evaluation: Evaluation
    width: float = FIRST_WIDTH
    failures: int = 0
    """Steps in a row without an improvement."""


def search_violation(
    starts: Sequence[tuple[ConcreteTest, Evaluation]],
    space: Concretization,
    run: Callable[[ConcreteTest], Evaluation],
    budget: Budget,
    rng: Random,
) -> SearchOutcome:
    """Search for a violation; ends at the first one.

    Args:
        starts: at least one test that was run, with its evaluation.
        space: the ranges of the parameters.
        run: runs a test and evaluates the run.

    Returns:
        The best test, one of the starts if none was better; also if the user pressed Ctrl-C.
    """
    population = [_Individual(number, test, evaluation) for number, (test, evaluation) in enumerate(starts)]
    ended: Ended = "done"
    try:
        while not any(individual.evaluation.violated for individual in population):
            budget.spend()  # also for a step without a change, so that the search ends if nothing can be changed
            _step(min(population, key=_turn), space, run, rng)
    except BudgetSpentError as spent:
        ended = spent.ended
    except KeyboardInterrupt:
        ended = "interrupted"
    best = min(population, key=lambda individual: (individual.evaluation.objective, individual.start))
    return SearchOutcome(best.test, best.evaluation, best.start, budget.used, budget.age_s, ended)


def _turn(individual: _Individual) -> tuple[int, float, int]:
    """The best one first, until it has not improved for a while."""
    return individual.failures // PATIENCE, individual.evaluation.objective, individual.start


def _step(
    individual: _Individual, space: Concretization, run: Callable[[ConcreteTest], Evaluation], rng: Random
) -> None:
    test = mutate(individual.test, space, individual.width, rng)
    evaluation = run(test) if test != individual.test else individual.evaluation
    before = individual.evaluation.objective
    improved = evaluation.objective < before
    if evaluation.objective <= before:  # an equal one is accepted, too, to cross plateaus
        individual.test, individual.evaluation = test, evaluation
    individual.failures = 0 if improved else individual.failures + 1
    individual.width = next_width(individual.width, improved=improved)


def next_width(width: float, *, improved: bool) -> float:
    """The width of the next step: wider after an improvement."""
    return min(max(width * (_WIDER if improved else _NARROWER), _WIDTHS[0]), _WIDTHS[1])


def mutate(test: ConcreteTest, space: Concretization, step: float, rng: Random) -> ConcreteTest:
    """A neighbour: the same actions with other parameters, each within its declared range.

    One parameter certainly changes, and each other one with probability 1/n for n parameters. Most changes are steps
    of at most `step` of the range's width; the others are a new sample or a simple value (`Sampler.simple_values`).
    Parameters with only one possible value stay as they are; if there are no others, the test is returned unchanged.

    Args:
        test: the test to change.
        space: the ranges.
        step: share of a range's width, from 0 to 1.
    """
    actions = [(action.parameters, space.commands.get(action.command, {})) for action in test.actions]
    spots = [
        (place, name)
        for place, (parameters, samplers) in enumerate([(test.run, space.run), *actions])
        for name in sorted(parameters)
        if name in samplers and len(set(samplers[name].simple_values())) > 1
    ]
    if not spots:
        return test
    certain = spots[random_index(rng, len(spots))]
    chosen = {spot for spot in spots if rng.random() * len(spots) < 1.0} | {certain}

    def vary(place: int, parameters: Parameters, samplers: Mapping[str, Sampler]) -> Parameters:
        values = dict(parameters)
        for name in sorted(name for spot, name in chosen if spot == place):
            values[name] = _other_value(values[name], samplers[name], step, rng)
        return values

    run = vary(0, test.run, space.run)
    others = (
        replace(action, parameters=vary(place, action.parameters, space.commands.get(action.command, {})))
        for place, action in enumerate(test.actions, 1)
    )
    return replace(test, actions=tuple(others), run=run)


def _other_value(value: float, sampler: Sampler, step: float, rng: Random) -> float:
    share = rng.random()
    if share < _NEW_SAMPLE:
        return sampler.sample(rng)
    if share < _NEW_SAMPLE + _SIMPLE_VALUE:
        return pick(rng, sampler.simple_values())
    inside = sampler.then if isinstance(sampler, Sometimes) else sampler
    if not isinstance(inside, Uniform):
        return pick(rng, sampler.simple_values())
    # 0.0 of a chance that did not occur may be outside: then the step starts at a sample.
    start = value if inside.contains(value) else inside.sample(rng)
    return inside.clip(start + (2.0 * rng.random() - 1.0) * step * (inside.high - inside.low))
