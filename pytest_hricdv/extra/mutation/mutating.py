"""`MutationRun`: tries mutants after the last test of a session, and collects which of them the tests kill.

`MutationFeature` uses it. The runs take place in a separate process (`process`).
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from pytest_hricdv._base.hash_seed import question_of_drawn_seed
from pytest_hricdv.coverage.closure import MeasuredTest, PointIndex, minimal_suite
from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.execution.forks import MAX_ATTEMPTS
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.execution.separate_process import LetThrough, LostError, ProcessError, start_process
from pytest_hricdv.extra.mutation import process as mutant_process
from pytest_hricdv.extra.mutation.mutants import Mutant, all_mutants, sample
from pytest_hricdv.extra.mutation.options import MutationOptions
from pytest_hricdv.extra.mutation.process import MutantRunEnd, MutantTrial, MutationJob, TrialEnd, TrialEvent, TrialTest
from pytest_hricdv.extra.mutation.records import (
    MutantResult,
    MutantRun,
    MutationEnd,
    MutationResult,
    mutant_status,
    score_mutants,
)
from pytest_hricdv.results.baseline import behaviour_of
from pytest_hricdv.results.behaviour import Behaviour
from pytest_hricdv.results.behaviour_diff import change_of
from pytest_hricdv.results.derivation import coverage_of
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.child_process import session_arguments
from pytest_hricdv.session.feature import DecidingRun
from pytest_hricdv.session.progress import time_left
from pytest_hricdv.session.run_context import RunContext

LEAST_RUN_S, FACTOR = 10, 10
"""A run counts as endless after this processor time (s), or FACTOR times that of the slowest test if this is more."""

STEPS = 10
"""Number of progress messages during a session's mutation testing."""


class MutationError(Exception):
    """Mutants cannot be tried; the message says why, and what to do."""


@dataclass
class MutationRun:
    """Tries the mutants of the code under test on the tests of a session.

    Args:
        options: how they are tried.
        chosen: node id -> test, of the session.
        processes: number of processes at the same time.
        let_through: while mutants are made and tried, a signal may raise.
        deciding: runs with schedules, of tests that take part.
    """

    context: RunContext
    options: MutationOptions
    chosen: Mapping[str, HriCase]
    processes: int
    say: Callable[[str], None]
    let_through: LetThrough = nullcontext
    deciding: Sequence[DecidingRun] = ()

    def mutate(self, results: Sequence[TestResult]) -> MutationResult:
        """Try the mutants. At Ctrl-C it stops, and keeps what was found until then.

        Raises:
            MutationError: no test can take part, or tests run otherwise than in the session.
        """
        began_s, options = time.perf_counter(), self.options
        results = sorted(results, key=lambda result: (result.suite, result.id, result.nodeid))  # workers finish anyhow
        tests = {result.id: result for result in results if _takes_part(result)}
        if not tests:
            raise MutationError("no mutant was tried: expected tests that pass and that were measured")
        with self.let_through():
            every = all_mutants(self.context.code)
            drawn = sample(every, self.context.options.seed, options.mutants)
            order = TrialOrder(candidates_of(self.context, [*tests.values()]), options.tests, self.deciding)
            trials = _Trials(drawn, order, tests, self.say)
            job = self._job(trials.plan(self.context), tests)
        self.say(f"hricdv: trying {len(drawn)} mutants on {len(tests)} tests, {self.processes} at a time ...")
        ended = trials.follow(job, self.context.collection.config.invocation_params.dir, self.let_through)
        return score_mutants(
            mutants=tuple(trials.result(mutant) for mutant in every if mutant.id in trials.runs),
            made=len(every),
            seed=self.context.options.seed,
            tests_per_mutant=options.tests,
            matrix=options.matrix,
            excluded_tests=tuple(result.id for result in results if not _takes_part(result)),
            processes=self.processes,
            wall_s=round(time.perf_counter() - began_s, 3),
            ended=ended,
            requirements={name: text.group for name, text in self.context.texts.items()},
        )

    def _job(self, trials: Sequence[MutantTrial], tests: Mapping[str, TestResult]) -> MutationJob:
        options = self.options
        slowest_s = max(result.wall_s or 0.0 for result in tests.values())
        one_of_each = {result.nodeid.partition("[")[0]: result.id for result in tests.values()}
        scheduled = {run.concrete.id: _trial_of_schedule(run, tests[run.test]) for run in self.deciding}
        return MutationJob(
            arguments=session_arguments(self.context.collection.config),
            tests={name: self._trial_test(result) for name, result in tests.items()} | scheduled,
            control=MutantTrial("", (*one_of_each.values(), *[*scheduled][:1])),
            trials=tuple(trials),
            processes=self.processes,
            run_s=max(LEAST_RUN_S, FACTOR * slowest_s),
            seconds=options.seconds,
            matrix=options.matrix,
        )

    def _trial_test(self, result: TestResult) -> TrialTest:
        concrete = self.chosen[result.nodeid].concrete
        return TrialTest(result.suite, concrete, result.record_sha256, result.end_reason, result.outcomes)


def _trial_of_schedule(run: DecidingRun, result: TestResult) -> TrialTest:
    return TrialTest(result.suite, run.concrete, run.record_sha256, run.ended, run.outcomes)


class _Trials:
    """The trials of mutants, and what is known of them."""

    def __init__(
        self,
        mutants: Sequence[Mutant],
        order: TrialOrder,
        tests: Mapping[str, TestResult],
        say: Callable[[str], None],
    ) -> None:
        self.runs: dict[str, list[MutantRun]] = {mutant.id: [] for mutant in mutants}
        self._differences: dict[str, str] = {}
        self._tests = tests
        self._mutants = mutants
        self._order = order
        self._say = say
        self._began_s = time.monotonic()
        self._done: set[str] = set()

    def plan(self, context: RunContext) -> list[MutantTrial]:
        """The plan of the trials, without mutants whose statement no test executes."""
        paths = {file.name: str(file.path) for file in context.code.files}
        plans = [
            (mutant, (*self._order.tests(mutant.statement), *self._order.schedules(mutant))) for mutant in self._mutants
        ]
        return [MutantTrial(mutant.id, tests, paths[mutant.file], mutant.text) for mutant, tests in plans if tests]

    def follow(self, job: MutationJob, directory: Path, let_through: LetThrough) -> MutationEnd:
        """Have a job done in a process that starts in this directory; in another one, where it is lost.

        Raises:
            MutationError: it was not: something is wrong with it, or its process was lost again and again.
        """
        lost: ProcessError | None = None
        for _ in range(MAX_ATTEMPTS):
            try:
                self._follow(self._left(job), directory, let_through, len(job.trials))
                return "done" if len(self._done) == len(job.trials) else "seconds"
            except LostError as error:
                lost = error
                self._say(f"hricdv: the process that tries mutants was lost: {error}")
            except ProcessError as error:
                raise MutationError(f"mutants could not be tried: {error}") from None
            except KeyboardInterrupt:
                return "interrupted"
        if not self._done:
            raise MutationError(f"mutants could not be tried: their process was lost {MAX_ATTEMPTS} times: {lost}")
        return "lost"

    def _follow(self, job: MutationJob, directory: Path, let_through: LetThrough, total: int) -> None:
        with start_process(mutant_process.__name__, directory, let_through=let_through) as process:
            process.send(job)
            for line in process.lines():
                self._note(msgspec.json.decode(line, type=TrialEvent), total)

    def _left(self, job: MutationJob) -> MutationJob:
        """The rest of a job, including all of a mutant whose trial was cut off."""
        left = tuple(trial for trial in job.trials if trial.mutant not in self._done)
        for trial in left:
            self.runs[trial.mutant].clear()
            self._differences.pop(trial.mutant, None)
        return replace(job, trials=left)

    def result(self, mutant: Mutant) -> MutantResult:
        """The result of a mutant."""
        executing = self._order.suites_of(mutant.statement)
        runs, complete = tuple(self.runs[mutant.id]), not executing or mutant.id in self._done
        status = mutant_status(runs, executed=bool(executing), complete=complete)
        return MutantResult(
            id=mutant.id,
            file=mutant.file,
            line=mutant.line,
            operator=mutant.operator,
            before=mutant.before,
            after=mutant.after,
            executing=executing,
            runs=runs,
            complete=complete,
            status=status,
            difference=self._differences.get(mutant.id, "") if status == "survived" else "",
        )

    def _note(self, event: TrialEvent, total: int) -> None:
        if isinstance(event, MutantRunEnd):
            self.runs[event.mutant].append(event.run)
            if event.behaviour is not None:
                self._differences[event.mutant] = _difference(self._tests[event.run.test], event.behaviour)
        elif isinstance(event, TrialEnd):
            self._done.add(event.mutant)
            self._tell_progress(len(self._done), total)
        else:
            raise MutationError(
                f"no mutant was tried: {event.reason}, where the code under test is as it was in the session; does "
                f"a fixture of the test function change what a run depends on?{question_of_drawn_seed()}"
            )

    def _tell_progress(self, done: int, total: int) -> None:
        if done * STEPS // total > (done - 1) * STEPS // total and done < total:
            killed = sum(any(run.assertions for run in self.runs[name]) for name in self._done)
            left_s = (time.monotonic() - self._began_s) / done * (total - done)
            self._say(f"hricdv: {done} of {total} mutants, {killed} killed, {time_left(left_s)}")


def _difference(before: TestResult, now: Behaviour) -> str:
    change = change_of(behaviour_of(before), now)
    # The comparison speaks of a baseline: here it is the same test of the original code.
    return f"{before.id}: {change.text.replace('in the baseline', 'in the original code')}" if change else ""


def _takes_part(result: TestResult) -> bool:
    """Whether a test can kill mutants: it passes in the original code, and it is known what it executes."""
    return result.outcome in AS_DECLARED and result.code is not None


@dataclass(frozen=True)
class TrialCandidate:
    """A test: the statements that it executes, all points that it covers (bit sets), and its simulated time (s)."""

    id: str
    suite: str
    statements: int
    points: int
    sim_s: float


def candidates_of(context: RunContext, results: Iterable[TestResult]) -> list[TrialCandidate]:
    """The tests that were measured, with what each covers."""
    code, cross = context.code, context.collection.testbench.cross
    index = PointIndex(code.statements, code.branches, {name: product.forbidden for name, product in cross.items()})
    candidates = []
    for result in results:
        bits = Bits.of(result.code)
        if bits is not None:
            points = index.points(coverage_of(result).runs)
            candidates.append(TrialCandidate(result.id, result.suite, bits.statements, points, result.sim_s))
    return candidates


class TrialOrder:
    """The tests on which a mutant is tried.

    Args:
        tests: the tests of all suites.
        most: most tests of each suite; None: all that execute the mutant's statement.
        deciding: runs of tests with schedules.
    """

    def __init__(self, tests: Sequence[TrialCandidate], most: int | None, deciding: Sequence[DecidingRun] = ()) -> None:
        self._tests = tests
        self._deciding = deciding
        self._most = most
        self._orders: dict[int, tuple[str, ...]] = {}

    def suites_of(self, statement: int) -> dict[str, int]:
        """Suite -> how many of its tests execute a statement, given by its number."""
        return dict(Counter(test.suite for test in self._tests if test.statements >> statement & 1))

    def schedules(self, mutant: Mutant) -> tuple[str, ...]:
        """The ids of runs with schedules, those that decide nearest to a mutant first."""
        executing = {test.id for test in self._tests if test.statements >> mutant.statement & 1}
        runs = [run for run in self._deciding if run.test in executing]
        runs.sort(key=lambda run: (_distance(run.places, mutant), len(run.concrete.schedule)))
        return tuple(run.concrete.id for run in runs)[: self._most]

    def tests(self, statement: int) -> tuple[str, ...]:
        """The ids of the tests to try, in order, suite after suite."""
        if statement not in self._orders:
            executing = [test for test in self._tests if test.statements >> statement & 1]
            order = []
            for suite in dict.fromkeys(test.suite for test in executing):
                order += _order_tests([test for test in executing if test.suite == suite])[: self._most]
            self._orders[statement] = tuple(order)
        return self._orders[statement]


def _distance(places: Iterable[str], mutant: Mutant) -> float:
    """The distance in lines to the nearest place; infinite for other files."""
    lines = (place.rpartition(":") for place in places)
    return min(
        (abs(int(line) - mutant.line) for file, _, line in lines if mutant.file.endswith(file)), default=math.inf
    )


def _order_tests(tests: Sequence[TrialCandidate]) -> list[str]:
    """First the test that does least else, so that a mutant that any test kills costs one short run; then those that
    together cover all that these tests cover, the most per second first, because a test like the one before notices
    what that one noticed; then the rest, the shortest first.
    """
    shortest = sorted(tests, key=lambda test: (test.statements.bit_count(), test.sim_s, test.id))
    varied = minimal_suite([MeasuredTest(test.id, test.points, test.sim_s) for test in shortest])
    names = [shortest[0].id, *(step.name for step in varied), *(test.id for test in shortest)]
    return list(dict.fromkeys(names))
