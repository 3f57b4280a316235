"""Searches for inputs that violate a requirement of a model, each by what a user of the plugin has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from random import Random

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.evolution_strategy import Evaluation, search_violation
from pytest_hricdv.extra.search.violation_search import STARTS
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import SAMPLINGS, Uniform
from pytest_hricdv.monitor import Log, Requirement, Vocabulary, evaluate, parse_formula
from studies.falsification import drive

SEGMENTS = 20
"""Of the cars' input: the second instance of the competition, with an input that may change every 5 s."""
MOST = 300
"""Simulations of a search."""
SUITE = 20
"""Tests of the suite that is run before `--hri-search`."""


@dataclass(frozen=True)
class FalsificationProblem:
    """A model, and a requirement that it is to violate.

    Args:
        requirement: to be violated.
        space: the ranges of the input: those of a single command.
        actions: of a test.
        log: simulates a test.
    """

    requirement: Requirement
    space: Concretization
    actions: int
    log: Callable[[ConcreteTest], Log]

    def run(self, test: ConcreteTest) -> Evaluation:
        """Simulate a test and judge it."""
        [verdict] = evaluate([self.requirement], self.log(test))
        return Evaluation(verdict.margin, violated=verdict.verdict == "Failed")

    def tests(self, sampling: str, rng: Random) -> Iterator[ConcreteTest]:
        """Tests with parameters drawn as `--hri-sampling` does."""
        draw = SAMPLINGS[sampling]
        [(command, ranges)] = self.space.commands.items()
        while True:
            actions = [
                ConcreteAction(command, {name: draw(sampler, rng) for name, sampler in ranges.items()})
                for _ in range(self.actions)
            ]
            yield ConcreteTest("test", "falsification", 0, tuple(actions), {})


def requirement_on(signals: Iterable[str], name: str, title: str, text: str) -> Requirement:
    """A requirement of the competition, on signals of numbers."""
    vocabulary = Vocabulary(signals=dict.fromkeys(signals, float))
    return Requirement(name, title, "ARCH-COMP", text, parse_formula(text, vocabulary))


def _cars(test: ConcreteTest) -> Log:
    course = drive([(action.parameters["throttle"], action.parameters["brake"]) for action in test.actions])
    named = {f"y{number}": values for number, values in enumerate(course.places, 1)}
    signals = {name: (course.times_s, values) for name, values in {"t": course.times_s, **named}.items()}
    return Log(signals, (), course.times_s[-1])


_INPUT = Concretization({"drive": {"throttle": Uniform(0.0, 1.0), "brake": Uniform(0.0, 1.0)}})

CARS = tuple(
    FalsificationProblem(requirement_on(("t", "y1", "y2", "y3", "y4", "y5"), *about), _INPUT, SEGMENTS, _cars)
    for about in (
        ("CC1", "G[0,100] y5 - y4 <= 40", "always(t >= 0 -> y5 - y4 <= 40)"),
        # A trigger is an episode of a small distance: the first window without a large one begins with an episode.
        (
            "CC2",
            "G[0,70] F[0,30] y5 - y4 >= 15",
            "always(t <= 70 & y5 - y4 < 15 -> eventually[0:30](y5 - y4 >= 15))",
        ),
    )
)


@dataclass(frozen=True)
class Falsification:
    """How a search ended.

    Args:
        simulations: that were run.
        violated: whether the last one violated the requirement.
    """

    simulations: int
    violated: bool


def by_sampling(sampling: str) -> Callable[[FalsificationProblem, int], Falsification]:
    """Tests that do not depend on each other."""

    def search(problem: FalsificationProblem, seed: int) -> Falsification:
        tests = problem.tests(sampling, make_rng("falsification", seed))
        for simulations in range(1, MOST + 1):
            if problem.run(next(tests)).violated:
                return Falsification(simulations, violated=True)
        return Falsification(MOST, violated=False)

    return search


def by_margins(sampling: str) -> Callable[[FalsificationProblem, int], Falsification]:
    """A suite, and then `--hri-search`, which varies its tests with the smallest margins."""

    def search(problem: FalsificationProblem, seed: int) -> Falsification:
        tests = problem.tests(sampling, make_rng("falsification", seed))
        suite = []
        for simulations in range(1, SUITE + 1):
            test = next(tests)
            suite.append((test, problem.run(test)))
            if suite[-1][1].violated:
                return Falsification(simulations, violated=True)
        nearest = sorted(suite, key=lambda pair: pair[1].objective)[:STARTS]
        rng = make_rng("search", seed, problem.requirement.id)
        outcome = search_violation(nearest, problem.space, problem.run, Budget(MOST - SUITE), rng)
        return Falsification(SUITE + outcome.runs, outcome.evaluation.violated)

    return search


METHODS = {
    "uniform": ("tests with `--hri-sampling=uniform`", by_sampling("uniform")),
    "corners": ("tests with `--hri-sampling=corners`", by_sampling("corners")),
    "uniform, search": ("20 tests, then `--hri-search=280`", by_margins("uniform")),
    "corners, search": ("20 tests with `corners`, then `--hri-search=280`", by_margins("corners")),
}
"""Key -> title on the page, and the search."""
