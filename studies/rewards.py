"""Which reward learns the better suite, `published` or `uncovered`: equal numbers of model runs, 20 seeds.

    python -m studies.rewards [--write]

`--write` replaces the tables in docs/studies/rewards.md. The figures depend on the model and the plugin only:
every run gives the same bytes.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

import conftest
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import ReinforcementLearning
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.generate.rng import make_rng, random_index
from pytest_hricdv.generate.suite import Suite, diagnose
from studies import page
from studies.session import ROOT

DOCUMENT = ROOT / "docs" / "studies" / "rewards.md"
COMMAND = "python -m studies.rewards --write"
SEEDS = range(20)
RESAMPLES = 10_000  # five times those of `studies.estimates`: the table shows differences of hundredths of a plan
LEVEL = 0.95


@dataclass(frozen=True)
class Arm:
    """What is compared: a reward, and the number of rounds of learning and selection."""

    reward: str
    rounds: int

    def __str__(self) -> str:
        return f"{self.reward}, {self.rounds} round{'s' if self.rounds > 1 else ''}"


@dataclass(frozen=True)
class Size:
    """Model runs of learning, size of the suite, and candidates for each test."""

    runs: int
    tests: int
    candidates: int

    def __str__(self) -> str:
        chosen = "as the policy gives them" if self.candidates == 1 else f"chosen from {self.tests * self.candidates}"
        return f"{self.runs:,} runs to learn in; {self.tests} tests, {chosen}"


ARMS = (Arm("published", 1), Arm("published", 10), Arm("uncovered", 10))
SIZES = (Size(800, 134, 10), Size(800, 134, 1), Size(800, 20, 1), Size(4000, 134, 1), Size(4000, 20, 1))
"""The published reward converges in about 800 runs (119 iterations at seed 0); ten rounds need about 5,900."""
FIGURES: Mapping[str, Callable[[Suite], float]] = {
    "model runs": lambda suite: suite.generation.bdi_runs,
    "plans of human (48)": lambda suite: len(diagnose(suite).plans["human"]),
    "suites with all 60 plans": lambda suite: not suite.plans_not_covered(),
    "distinct texts": lambda suite: diagnose(suite).distinct_texts,
    "entropy of beliefs, bit": lambda suite: diagnose(suite).belief_entropy_bits,
}
COMPARED = "plans of human (48)"


def main() -> None:
    """Measure, and print or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="replace the tables in docs/studies/rewards.md")
    options = parser.parse_args()
    text = "\n\n".join(table(size, {arm: suites(arm, size) for arm in ARMS}) for size in SIZES)
    print(text)
    if options.write:
        page.replace_figures(DOCUMENT, COMMAND, text)


def suites(arm: Arm, size: Size) -> list[Suite]:
    """One suite for each seed."""
    bench = conftest.pytest_hricdv_testbench(None)  # type: ignore[arg-type]
    learning = QLearning(
        reward=arm.reward,
        rounds=arm.rounds,
        model_runs=size.runs,
        stop_when_converged=False,
        suite_size=size.tests,
        candidates=size.candidates,
    )
    context = GenerationContext(model=bench.model, space=bench.beliefs, learning=learning)
    return [ReinforcementLearning().generate(replace(context, seed=seed)) for seed in SEEDS]


def table(size: Size, by_arm: Mapping[Arm, Sequence[Suite]]) -> str:
    """One row for each arm: means with intervals, and the gain in plans over the row above, paired by seed."""
    rows = []
    before: list[float] = []
    for arm, made in by_arm.items():
        cells = [
            interval([figure(suite) for suite in made], str(size), str(arm), name) for name, figure in FIGURES.items()
        ]
        plans = [FIGURES[COMPARED](suite) for suite in made]
        more = [now - then for now, then in zip(plans, before, strict=True)] if before else []
        rows.append([str(arm), *cells, interval(more, str(size), str(arm), "more") if more else "-"])
        before = plans
    return f"**{size}**\n\n" + page.table(["reward", *FIGURES, "plans more than the row above"], rows)


def interval(values: Sequence[float], *key: str) -> str:
    """The mean with its bootstrap percentile interval; without one where all values are equal."""
    if len(set(values)) == 1:
        return f"{values[0]:.4g}"
    means = sorted(resampled(values, *key))
    outside = (1.0 - LEVEL) / 2
    low, high = (means[round(share * (len(means) - 1))] for share in (outside, 1.0 - outside))
    return f"{fmean(values):.4g} ({low:.4g} to {high:.4g})"


def resampled(values: Sequence[float], *key: str) -> Iterator[float]:
    """Means of resamples, drawn from a separate random stream."""
    rng = make_rng("rewards-bootstrap", *key)
    for _ in range(RESAMPLES):
        yield fmean(values[random_index(rng, len(values))] for _ in values)


if __name__ == "__main__":
    main()
