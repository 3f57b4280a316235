"""`ClosureGenerator`: generates the suite `closure` by running tests until nothing is open, or the budget is spent.

`ClosingFeature.generate` calls its method `suite`, which reads the suite from the cache (`SuiteCache`) or runs a `Loop`
with all strategies, and returns the suite with its evidence (`ClosingResult`).
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv._base.project_files import identity
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import CodeMap, CoverageError
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.coverage.reachability import Reachability, explore_model, reachable, sample_model
from pytest_hricdv.execution.separate_process import ProcessError
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing import online_strategy
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.evidence import evidence
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interleaving_strategy import InterleavingStrategy
from pytest_hricdv.extra.closing.loop import NAME, GivenUpError, Loop, LoopError, search_violations
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
from pytest_hricdv.extra.closing.nearest_strategy import NearestStrategy
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.online_strategy import OnlineStrategy, roles_of
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.progress import ClosingProgress, list_open
from pytest_hricdv.extra.closing.records import CLOSING, ClosingEnd, ClosingOptions, ClosingResult
from pytest_hricdv.extra.closing.runs import ClosingRuns, RunsHere, RunsOnCluster
from pytest_hricdv.extra.closing.strategy import GIVEN, Archive, Strategy
from pytest_hricdv.extra.closing.suite import SuiteCache, repeatable_suite, smallest_suite
from pytest_hricdv.extra.closing.targets import Surroundings, impossible_points, target_points
from pytest_hricdv.extra.closing.violation_strategy import ViolationStrategy
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest, Plans
from pytest_hricdv.generate.actors import TURN_WAIT_S
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.model import Exploration
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.generate.suite import Generation, Suite
from pytest_hricdv.online.declaration import InteractiveAgentError
from pytest_hricdv.results.folder_files import remove_progress
from pytest_hricdv.results.report_builder import GeneratedSuite
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.option import usage_error
from pytest_hricdv.session.remote import ClusterError, remote
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.signals import Signals
from pytest_hricdv.session.suites import generation_context

CACHE_SCHEMA = "hricdv-closing/6"  # part of the key of a cached suite; changes with the strategies


class ClosureGenerator:
    """The closing loop of a session."""

    def __init__(self, collection: Collection, context: RunContext, options: ClosingOptions) -> None:
        self._collection = collection
        self._context = context
        self._options = options
        self._is_over = False

    def suite(self, others: Sequence[GeneratedSuite]) -> GeneratedSuite:
        """The suite, from the cache or of a new loop, given the other suites of the session.

        Raises:
            pytest.UsageError: there can be no loop, or every run errs.
        """
        tests = [test for other in others for test in other.suite.tests] if self._options.given else []
        kept = SuiteCache(self._collection, self._key(tests))
        suite_before = kept.read()
        if suite_before is not None:
            return suite_before
        began_s = time.perf_counter()
        try:
            with self._signals.defer(), self._runs() as runs:
                suite, result = self._close(runs, tests)
                self._signals.hold()  # up to where a report can be made
        except (ProcessError, LoopError) as error:
            raise usage_error(f"--hri-suite={NAME}: no run completed: {error}") from None
        except (GenerateError, CoverageError, InteractiveAgentError) as error:
            raise usage_error(f"--hri-suite={NAME}: {error}") from None
        except ClusterError as error:
            raise usage_error(f"--hri-cluster: {error}") from None
        if result.end_reason not in ("seconds", "interrupted", "error"):  # otherwise it would depend on the machine
            kept.write(suite, result, runs.files)
        return GeneratedSuite(suite, time.perf_counter() - began_s, cached=False, sections={CLOSING.name: result})

    def _runs(self) -> ClosingRuns:
        config = self._collection.config
        cluster = remote()
        if cluster is None or not cluster.address_of_session(self._collection.options):
            return RunsHere(config, _processes(config), self._say, self._signals.let_through)
        here = identity(Path(config.rootpath), self._context.provenance.code)
        return RunsOnCluster(cluster, self._collection, here.project, self._signals.let_through)

    def _close(self, runs: ClosingRuns, others: Sequence[AbstractTest]) -> tuple[Suite, ClosingResult]:
        archive, seed = Archive(self._targets), self._collection.options.seed
        progress = ClosingProgress(self._collection, self._options.runs, _processes(self._collection.config))

        def show(archive: Archive) -> None:
            progress.show(archive)
            progress.write(archive)

        self._collection.say(
            f"hricdv: closing {list_open(archive)}, at most {self._options.runs} runs (seed {seed}) ..."
        )
        for note in self._exploration_notes:
            self._collection.say(f"hricdv: {note}")
        faults: list[str] = []
        ended = "interrupted" if self._is_over else self._run_others(archive, runs, others, faults)
        if ended is None:
            budget = Budget(self._options.runs, self._options.seconds)
            strategies, let_through = self._used_strategies(), self._signals.let_through
            loop = Loop(archive, strategies, runs.run, seed, budget, show, FallbackStrategy(self._pool), self._searcher)
            loop.let_through, loop.faults = let_through, faults
            try:
                ended = search_violations(loop, loop.run(), self._options.search)
            finally:
                remove_progress(self._collection.options.report)
        suite, result = self._suite(archive, ended, runs, faults)
        self._signals.interrupted |= result.end_reason == "interrupted"
        progress.end(archive, result.end_reason, faults, len(suite.tests), goes_on=not self._signals.terminated)
        return suite, result

    @property
    def _searcher(self) -> Strategy | None:
        context = self._context
        # Known whatever violates them: those with a condition may be violated otherwise.
        excused = [name for name in context.violation_exemptions if name not in context.exemption_conditions]
        requirements = [requirement.id for requirement in context.requirements if requirement.id not in excused]
        return (
            ViolationStrategy(requirements, self._collection.testbench.commands) if self._options.search != 0 else None
        )

    def _used_strategies(self) -> tuple[Strategy, ...]:
        """The strategies that are not left out."""
        strategies, without = self._strategies(), self._options.without
        names = [strategy.name for strategy in strategies]
        for name in without:
            if name not in names:
                raise usage_error(f"--hri-close-without: no strategy {name!r}; there are: {', '.join(names)}")
        return tuple(strategy for strategy in strategies if strategy.name not in without)

    def _strategies(self) -> tuple[Strategy, ...]:
        testbench, pool = self._collection.testbench, self._pool
        experience = Experience(pool)
        disturbances = {name: disturbance.parameters for name, disturbance in testbench.disturbances.items()}
        roles = roles_of(testbench)
        return (
            ModelStrategy(pool, experience),
            DisturbanceStrategy(pool, experience, disturbances),
            NearestStrategy(pool, disturbances),
            *([InterleavingStrategy(pool, testbench.commands.run[TURN_WAIT_S])] if testbench.model.actors else []),
            *([OnlineStrategy(len(roles))] if roles else []),
        )

    def _run_others(
        self, archive: Archive, runs: ClosingRuns, tests: Sequence[AbstractTest], faults: list[str]
    ) -> ClosingEnd | None:
        """Run the other suites, outside the budget: their hits are not open. Returns why there is no loop."""
        ended: ClosingEnd | None = None
        observed: dict[int, RunObservation] = {}
        if tests:
            self._say(f"running the {len(tests)} tests of the other suites first ...")
            try:
                observed.update(runs.run(tests, frozenset()))
            except KeyboardInterrupt:
                ended = "interrupted"
            except GivenUpError as error:
                faults.append(f"the loop did not start: {error}")
                ended = "error"
        for number in sorted(observed):
            archive.add(observed[number], GIVEN)
        return ended

    def _say(self, text: str) -> None:
        self._collection.say(f"hricdv: {text}")

    @property
    def _signals(self) -> Signals:
        return self._context.signals

    def _suite(
        self, archive: Archive, ended: ClosingEnd, runs_again: ClosingRuns, faults: Sequence[str]
    ) -> tuple[Suite, ClosingResult]:
        online = (online_strategy.NAME,)
        try:
            entries, left_out = repeatable_suite(archive, online, runs_again.run)
        except (ProcessError, GivenUpError, ClusterError, KeyboardInterrupt) as error:
            # Tests cannot run any more, or nobody waits for them: keep only results that need no check.
            ended = "interrupted" if isinstance(error, KeyboardInterrupt) else ended
            left_out = tuple(entry for entry in archive.entries if entry.strategy in online)
            entries = smallest_suite(archive, {entry.number for entry in left_out})
        entries = entries[: self._collection.options.tests]
        errored_runs = [entry.observation.error for entry in archive.entries if entry.observation.error]
        notes = [*self._exploration_notes, *faults]
        if errored_runs:
            notes.append(f"{len(errored_runs)} runs did not end; the first: {errored_runs[0]}")
        if left_out:
            notes.append(
                f"{len(left_out)} tests are left out, because they do not do again what they did with a person who "
                f"decided during the run; the first: {left_out[0].test.id}"
            )
        explored_runs = len(self._exploration.runs)
        generation = Generation(bdi_runs=explored_runs, declared_plans=self._plans, notes=tuple(notes))
        suite = Suite.of_tests(NAME, self._collection.options.seed, tuple(entry.test for entry in entries), generation)
        return suite, evidence(
            archive,
            entries,
            impossible_points(*self._coverage_model),
            self._surroundings,
            suite=NAME,
            ended=ended,
            budget=self._options.runs,
            without=[entry.number for entry in left_out],
        )

    @property
    def _targets(self) -> tuple[Point, ...]:
        return target_points(
            *self._coverage_model, self._context.requirements, self._collection.testbench.state.transitions
        )

    @cached_property
    def _coverage_model(self) -> tuple[CodeMap | None, Plans, Mapping[str, CrossProduct], Reachability]:
        """The points to reach, and the model's results on them."""
        testbench = self._collection.testbench
        code = self._context.code if self._collection.options.coverage else None
        return code, self._plans, testbench.cross, reachable(self._exploration, testbench.cross)

    @property
    def _surroundings(self) -> Surroundings:
        code, _, cross, reachability = self._coverage_model
        coordinates = {name: tuple(product.coordinates) for name, product in cross.items()}
        return Surroundings(code, coordinates, reachability.exploration.plans or {})

    @cached_property
    def _exploration(self) -> Exploration:
        """The runs of the model; of belief sets that are drawn where it has too many."""
        context = generation_context(self._collection.options, self._collection.testbench)
        cache = getattr(self._collection.config, "cache", None)
        try:
            with self._signals.let_through():
                return _explore(context, cache)
        except KeyboardInterrupt:
            self._is_over = True
            return Exploration(reason="exploring the model was interrupted")

    @property
    def _exploration_notes(self) -> list[str]:
        return [self._exploration.reason] if self._exploration.reason else []

    @cached_property
    def _pool(self) -> Pool:
        """The tests of the model, without beliefs to which no plan applies, as nothing would happen."""
        testbench = self._collection.testbench
        exploration = replace(
            self._exploration, runs=tuple(run for run in self._exploration.runs if run.lines or run.plans)
        )
        planned = {name: product.planned for name, product in testbench.cross.items() if product.planned is not None}
        if not testbench.model.actors:
            return Pool(exploration, testbench.beliefs, planned)
        runner = generation_context(self._collection.options, testbench).model_runner()
        return Pool(exploration, testbench.beliefs, planned, cache(runner.order))

    @property
    def _plans(self) -> Plans:
        plans: dict[str, tuple[str, ...]] = {}
        for agent, label in self._exploration.plans:
            plans[agent] = (*plans.get(agent, ()), label)
        return plans

    def _key(self, others: Sequence[AbstractTest]) -> str:
        """The hash of all that a suite depends on, except files that runs load."""
        options, testbench = self._collection.options, self._collection.testbench
        requirements = testbench.requirements
        of_file = sha256(requirements.read_bytes()).hexdigest() if isinstance(requirements, Path) else ""
        return digest(
            CACHE_SCHEMA,
            generation_context(options, testbench).fingerprint(NAME),
            self._context.code.sha256,
            of_file,
            self._options.runs,
            self._options.search,
            self._options.without,
            options.coverage,
            testbench.name,
            testbench.simulation.fidelity,
            testbench.simulation.engine,
            testbench.state.transitions,
            [test.id for test in others],
        )


def _explore(context: GenerationContext, cache: Any) -> Exploration:
    try:
        exploration = explore_model(context, cache)
    except GenerateError as error:  # of one belief set, it may be, that other suites never use
        exploration = Exploration(reason=f"the model cannot be explored: {error}")
    return exploration if exploration.runs else sample_model(context, exploration.reason, cache)


def _processes(config: pytest.Config) -> int:
    """The number of xdist's workers; without xdist, the number of processors."""
    return int(getattr(config.option, "numprocesses", None) or os.cpu_count() or 1)
