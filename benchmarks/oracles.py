"""Cost of judging runs: requirements, the model, and both, as ratios to the same runs judged by nothing.

    python -m benchmarks.oracles [--tests N] [--repeat N]

Tests of the learned suite, evenly chosen, with coverage; the four ways alternate, so that a busy machine slows all
alike. CPU times of one core, medians per test. A run that is judged goes on until no deadline is open, which counts.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Mapping, Sequence
from itertools import count

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.execution.case import RunSettings, execute, feature_criteria
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion
from studies.session import machine
from tests.hri import bench

RUNS = count(1)
NOTHING = "nothing"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=10, metavar="N", help="tests (default 10)")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each test and way (default 5)")
    options = parser.parse_args()
    suite = list(bench.suite("rl"))
    tests = suite[:: max(1, len(suite) // options.tests)][: options.tests]
    formulas, model = bench.requirements(), feature_criteria(bench.testbench())
    ways: dict[str, tuple[Criterion, ...]] = {
        NOTHING: (),
        f"{len(formulas)} requirements": formulas,
        "the model": model,
        "both": (*formulas, *model),
    }
    print(f"machine: {machine()}\n{len(tests)} tests, {options.repeat} runs of each\n")
    spent = measured(tests, ways, options.repeat)
    for name, cpu_s in spent.items():
        print(f"judged by {name:20} {1e3 * cpu_s / len(tests):8.1f} ms a run   x {cpu_s / spent[NOTHING]:.3f}")


def measured(tests: Sequence[ConcreteTest], ways: Mapping[str, tuple[Criterion, ...]], repeat: int) -> dict[str, float]:
    """The CPU time (s) of all tests by each way: the sum of their medians."""
    measurement = choose(map_code(bench.testbench().code, bench.ROOT), contexts_by_test=False)
    spent: dict[str, float] = dict.fromkeys(ways, 0.0)
    for test in tests:
        times: dict[str, list[float]] = {name: [] for name in ways}
        for number in range(repeat + 1):
            for name, criteria in ways.items():
                cpu_s = once(test, criteria, measurement)
                if number:  # the first one warms up
                    times[name].append(cpu_s)
        for name in ways:
            spent[name] += statistics.median(times[name])
    return spent


def once(test: ConcreteTest, criteria: tuple[Criterion, ...], measurement: Measurement) -> float:
    """CPU time (s) of one run."""
    began_s = time.thread_time()
    execute(RunSettings(bench.testbench(), criteria, measurement=measurement), test, f"{test.id} {next(RUNS)}")
    return time.thread_time() - began_s


if __name__ == "__main__":
    main()
