"""Cost of one more test that parts at a decision point, compared with its run from the start: medians of CPU time.

    python -m benchmarks.branching [--repeat N]

The test asks for four legs; the others have the same commands, and other values from the decision point on. Costs
include the fork.
"""

from __future__ import annotations

import argparse
import os
import statistics
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import choose
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.extra.closing.tree_runner import TreeRunner
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.run import Actions
from studies.session import machine
from tests.hri import bench

LEGS = 4
LEAVES = 4
"""So many tests part at a decision point."""

LIMIT_S = 60.0  # of wall time, for a run of a second: it only ends what hangs


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--repeat", type=int, default=3, metavar="N", help="repetitions of each measurement (default 3)"
    )
    repeat = parser.parse_args().repeat
    print(f"machine: {machine()}\nmedians of {repeat}\n")
    commands = bench.leg() * LEGS
    trunk, *others = (bench.concrete(commands, seed) for seed in range(1, LEAVES + 2))
    run = runner()
    run([trunk], False)  # what is loaded once
    alone_s = median(repeat, partial(run, [trunk, *others], True)) / (1 + LEAVES)
    print(f"from the start                {1000.0 * alone_s:6.0f} ms")
    trunk_s = median(repeat, partial(run, [trunk], False))
    for taken in (1, *range(len(bench.leg()), len(commands), len(bench.leg())), len(commands) - 1):
        leaves = [replace(trunk, actions=trunk.actions[:taken] + other.actions[taken:]) for other in others]
        leaf_s = (median(repeat, partial(run, [trunk, *leaves], False)) - trunk_s) / LEAVES
        print(f"parting after {taken:2} of {len(commands)} actions {1000.0 * leaf_s:6.0f} ms ({leaf_s / alone_s:4.0%})")


def runner() -> Callable[[Sequence[ConcreteTest], bool], float]:
    """Runs tests, as a tree or from the start; returns the CPU time (s) of all processes together."""
    measurement = choose(map_code(bench.testbench().code, bench.ROOT), contexts_by_test=False)
    settings = RunSettings(bench.testbench(), bench.requirements(), measurement=measurement)

    def executed(test: ConcreteTest, actions: Actions) -> CaseResult:
        return execute(settings, test, "branching", producing=actions)

    def run(tests: Sequence[ConcreteTest], from_the_start: bool) -> float:
        before_s = cpu_s()
        for number, problem in TreeRunner(executed, lambda leaf: leaf.problem, 1, LIMIT_S).run(
            tests, from_the_start=from_the_start
        ):
            assert not problem, f"test {number}: {problem}"
        return cpu_s() - before_s

    executed(bench.concrete(bench.leg()), lambda run: iter(run.test.actions))  # forks need not load what it loads
    return run


def cpu_s() -> float:
    """CPU time (s) of this process and of all that have ended."""
    return sum(os.times()[:4])


def median(repeat: int, measured: Callable[[], float]) -> float:
    """The median of several measurements."""
    return statistics.median(measured() for _ in range(repeat))


if __name__ == "__main__":
    main()
