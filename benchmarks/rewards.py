"""Which reward makes the better suite: published or uncovered, at equal numbers of runs of the model, over 20 seeds.

    python -m benchmarks.rewards [--write]

`--write` puts the tables into docs/rewards.md, below the text there. The figures are a function of the model and the
plugin: every run of this gives the same bytes.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean

import conftest
from pytest_hricdv.generate.diagnosis import diagnose
from pytest_hricdv.generate.method import Context
from pytest_hricdv.generate.qlearning import QLearning
from pytest_hricdv.generate.rl import ReinforcementLearning
from pytest_hricdv.generate.stream import index, stream
from pytest_hricdv.generate.suite import Suite

ROOT = Path(__file__).parents[1]
DOCUMENT = ROOT / "docs" / "rewards.md"
MARK = "<!-- figures: python -m benchmarks.rewards --write -->"
SEEDS = range(20)
RESAMPLES = 10_000
LEVEL = 0.95


@dataclass(frozen=True)
class Arm:
    """What is compared: a reward, and the rounds that the suite is made in."""

    reward: str
    rounds: int

    def __str__(self) -> str:
        return f"{self.reward}, {self.rounds} round{'s' if self.rounds > 1 else ''}"


@dataclass(frozen=True)
class Size:
    """Runs of the model to learn in, size of the suite, subsets of the policy to choose each test from."""

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
    "suites with all 60 plans": lambda suite: not suite.uncovered_plans(),
    "distinct texts": lambda suite: diagnose(suite).distinct_texts,
    "entropy of beliefs, bit": lambda suite: diagnose(suite).belief_entropy_bits,
}
COMPARED = "plans of human (48)"


def main() -> None:
    """Measure, and print or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/rewards.md")
    options = parser.parse_args()
    text = "\n\n".join(table(size, {arm: suites(arm, size) for arm in ARMS}) for size in SIZES)
    print(text)
    if options.write:
        head = DOCUMENT.read_text(encoding="utf-8").partition(MARK)[0]
        DOCUMENT.write_text(f"{head}{MARK}\n\n{text}\n", encoding="utf-8")


def suites(arm: Arm, size: Size) -> list[Suite]:
    """A suite of each seed."""
    bench = conftest.pytest_hricdv_testbench(None)  # type: ignore[arg-type]
    learning = QLearning(
        reward=arm.reward,
        rounds=arm.rounds,
        model_runs=size.runs,
        stop_when_converged=False,
        suite_size=size.tests,
        candidates=size.candidates,
    )
    context = Context(model=bench.model, space=bench.beliefs, learning=learning)
    return [ReinforcementLearning().generate(replace(context, seed=seed)) for seed in SEEDS]


def table(size: Size, by_arm: Mapping[Arm, Sequence[Suite]]) -> str:
    """A row an arm: means with their intervals, and how many plans more than in the row above, seed by seed."""
    rows = [["reward", *FIGURES, "plans more than the row above"], ["---"] * (len(FIGURES) + 2)]
    before: list[float] = []
    for arm, made in by_arm.items():
        cells = [interval([each(suite) for suite in made], str(size), str(arm), name) for name, each in FIGURES.items()]
        plans = [FIGURES[COMPARED](suite) for suite in made]
        more = [now - then for now, then in zip(plans, before, strict=True)] if before else []
        rows.append([str(arm), *cells, interval(more, str(size), str(arm), "more") if more else "-"])
        before = plans
    return f"**{size}**\n\n" + "\n".join("| " + " | ".join(row) + " |" for row in rows)


def interval(values: Sequence[float], *key: str) -> str:
    """The mean with its bootstrap percentile interval; without one where all values are equal."""
    if len(set(values)) == 1:
        return f"{values[0]:.4g}"
    means = sorted(resampled(values, *key))
    outside = (1.0 - LEVEL) / 2
    low, high = (means[round(share * (len(means) - 1))] for share in (outside, 1.0 - outside))
    return f"{fmean(values):.4g} ({low:.4g} to {high:.4g})"


def resampled(values: Sequence[float], *key: str) -> Iterator[float]:
    """Means of resamples, from a stream of their own."""
    random = stream("rewards-bootstrap", *key)
    for _ in range(RESAMPLES):
        yield fmean(values[index(random, len(values))] for _ in values)


if __name__ == "__main__":
    main()
