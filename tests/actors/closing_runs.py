"""How many runs the closing loop takes on the testbenches with several actors: what its strategies bring.

    python -m tests.actors.closing_runs corridor --seeds 100 108 --without interleaving

A line a seed: runs, points left open, and in which run a requirement was first violated. Statements and branches are no
targets here. It was chosen with the seeds 0 to 2 of the corridor.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.reachability import explore_model, reachable
from pytest_hricdv.execution.case import RunSettings, execute
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interleaving_strategy import InterleavingStrategy
from pytest_hricdv.extra.closing.loop import Loop, OnlineTests
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
from pytest_hricdv.extra.closing.observation import RunObservation, observe
from pytest_hricdv.extra.closing.online_strategy import OnlineRun, OnlineStrategy, roles_of
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.strategy import Strategy
from pytest_hricdv.extra.closing.targets import target_points
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.actors import TURN_WAIT_S
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.testbench import Testbench
from pytest_hricdv.testbench_faults import check_testbench
from tests.actors.corridor.bench import crossed_ward
from tests.actors.hospital.bench import hospital

TESTBENCHES: Mapping[str, Testbench] = {"corridor": crossed_ward(), "hospital": hospital()}
NEVER = {("verdict", "R1", "Passed")}
"""In the corridor the cart always drives where the child is so near: it is what the requirement forbids."""


class ClosureGenerator:
    """Closing loops of a testbench, in this process."""

    def __init__(self, testbench: Testbench) -> None:
        self._bench = bench = check_testbench(testbench, "tests")
        self._requirements = load_requirements(bench.requirements, bench.vocabulary())
        self._settings = RunSettings(bench, self._requirements)
        context = GenerationContext(bench.model, bench.beliefs, tuple(bench.concretization.commands), 0, 10)
        self._exploration = explore_model(context, None)
        self._pool = Pool(self._exploration, bench.beliefs, {}, cache(context.model_runner().order))
        self._roles = roles_of(bench)

    def loop(self, seed: int, runs: int, without: Sequence[str]) -> Archive:
        """A loop that has ended."""
        archive = Archive(point for point in self._targets() if point not in NEVER)
        strategies = [strategy for strategy in self._strategies() if strategy.name not in without]
        Loop(archive, strategies, self._run, seed, Budget(runs, None), fallback=FallbackStrategy(self._pool)).run()
        return archive

    def _targets(self) -> Iterator[tuple[str, ...]]:
        plans: dict[str, tuple[str, ...]] = {}
        for agent, label in self._exploration.plans:
            plans[agent] = (*plans.get(agent, ()), label)
        cross = self._bench.cross
        yield from target_points(None, plans, cross, reachable(self._exploration, cross), self._requirements)

    def _strategies(self) -> list[Strategy]:
        bench = self._bench
        experience = Experience(self._pool, lambda test: concretize(test, bench.commands).run)
        disturbances = {name: disturbance.parameters for name, disturbance in bench.disturbances.items()}
        strategies: list[Strategy] = [
            ModelStrategy(self._pool, experience),
            DisturbanceStrategy(self._pool, experience, disturbances),
            InterleavingStrategy(self._pool, bench.commands.run[TURN_WAIT_S]),
        ]
        return [*strategies, OnlineStrategy(len(self._roles))] if self._roles else strategies

    def _run(self, tests: Sequence[AbstractTest], online: OnlineTests, /) -> Iterator[tuple[int, RunObservation]]:
        bench = self._bench
        for number, abstract in enumerate(tests):
            concrete = concretize(abstract, bench.commands)
            if number in online:
                people = OnlineRun(self._roles, bench.commands, concrete.seed)
                result = execute(self._settings, concrete, producing=people.actions, watching=[people.watcher])
                test = people.to_test(result)
            else:
                result, test = execute(self._settings, concrete), abstract
            yield (
                number,
                observe(
                    test,
                    result,
                    code=CodeMap((), (), ""),
                    cross=bench.cross,
                    requirements=self._requirements,
                    known_violations=(),
                ),
            )


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser()
    parser.add_argument("testbench", choices=[*TESTBENCHES])
    parser.add_argument("--seeds", type=int, nargs=2, default=(100, 108))
    parser.add_argument("--runs", type=int, default=150)
    parser.add_argument("--without", nargs="*", default=())
    options = parser.parse_args()
    closing = ClosureGenerator(TESTBENCHES[options.testbench])
    for seed in range(*options.seeds):
        archive = closing.loop(seed, options.runs, options.without)
        violating = [
            entry.number
            for entry in archive.entries
            if any(point[0] == "violation" for point in entry.observation.points)
        ]
        print(
            f"seed {seed}: {len(archive.entries)} runs, {len(archive.open)} of {len(archive.targets)} points open, "
            f"first violation in run {violating[0] if violating else None}, {len(violating)} in all",
            flush=True,
        )


if __name__ == "__main__":
    main()
