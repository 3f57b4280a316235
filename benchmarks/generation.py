"""How long the generation of the learned suite takes, phase by phase. Prints a table of medians.

    python -m benchmarks.generation [--repeat N]

Every measurement is a fresh process. A session has loaded pytest and the testbench before it generates, so these do
not count. Wall times need an otherwise idle machine; CPU times need one less so.

    import       the generator and the BDI engine
    parsing      the model of the suite
    learning     Q-learning, with its runs of the model
    selection    everything else of the suite: the subsets of the policy, their runs, the greedy choice, ids
    exploration  all runs of the model, for the proof of impossible bins; it reuses the runs of the suite
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from studies.session import ROOT, machine

PHASES = ("import", "parsing", "learning", "selection", "exploration", "whole")

Times = dict[str, tuple[float, float]]
"""Phase -> wall and CPU time (s)."""


def main() -> None:
    """Measure and print; with `--once`, measure in this process and print JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="processes to measure (default 5)")
    parser.add_argument("--once", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        print(json.dumps(measure()))
        return
    print(f"machine: {machine()}\nmedians of {options.repeat}\n\n{'':12}    wall     CPU", flush=True)
    processes = [in_fresh_process() for _ in range(options.repeat)]
    for phase in PHASES:
        wall_s, cpu_s = (statistics.median(times[phase][kind] for times in processes) for kind in (0, 1))
        print(f"{phase:12}{wall_s:6.2f} s{cpu_s:6.2f} s")


def in_fresh_process() -> Times:
    """Measure in a new process."""
    command = [sys.executable, "-m", "benchmarks.generation", "--once"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    times: Times = json.loads(done.stdout)
    return times


def measure() -> Times:
    """Generate the suite `rl` as its method does, and explore the model, in this process."""
    import conftest

    testbench = conftest.pytest_hricdv_testbench(None)  # type: ignore[arg-type]
    times: Times = {}
    with timed("whole", times):
        with timed("import", times):
            from pytest_hricdv.generate import context, learner, methods, model_runner, suite
        space, parameters = testbench.beliefs, testbench.suites.learning
        with timed("parsing", times):
            runner = model_runner.ModelRunner(testbench.model, space)
        with timed("learning", times):
            learned = learner.learn(runner, space, parameters, seed=0)
        with timed("selection", times):
            count = parameters.suite_size * parameters.candidates
            subsets = learner.policy_subsets(learned.q, space, parameters, count, seed=0)
            selector = methods.GreedySelector()
            selector.choose(map(runner.run, subsets), parameters.suite_size)
            drafts = [context.draft_of(run, space) for run in selector.chosen]
            suite.Suite.of_drafts("rl", 0, drafts, suite.Generation(declared_plans=runner.plan_labels))
        with timed("exploration", times):
            model_runner.explore_exhaustively(model_runner.ModelRunner(testbench.model, space))
    return times


@contextmanager
def timed(phase: str, times: Times) -> Iterator[None]:
    """Measure a block."""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    yield
    times[phase] = time.perf_counter() - wall_s, time.process_time() - cpu_s


if __name__ == "__main__":
    main()
