"""The process that tries mutants: it reads a job, and forks a process for each mutant, which runs tests one by one.

`MutationRun` starts it with a `MutationJob`. The code under test must not have been imported before its mutant. So
pytest is configured only in the fork of a mutant, which imports conftest files, testbench and world, too.
"""

from __future__ import annotations

import re
import resource
import signal
import sys
import time
from collections import Counter, deque
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.execution.case import CaseResult, execute
from pytest_hricdv.execution.faulty_import import FaultyImport
from pytest_hricdv.execution.forks import KILLED, MAX_ATTEMPTS, OutputLine, ProcessPool, Send
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.judge import list_undeclared_violations
from pytest_hricdv.extra.mutation.records import BIN, ENDING, EXCEPTION, MutantRun
from pytest_hricdv.generate.concrete import ConcreteTest, abstract_from
from pytest_hricdv.results.baseline import behaviour_of
from pytest_hricdv.results.behaviour import Behaviour
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.report_builder import build_result
from pytest_hricdv.session.child_process import channel, limit_processor_time, preload, run_configured, silence
from pytest_hricdv.session.run_context import RunContext

SILENCE = 30
"""A mutant is ended if it sends nothing for this many times the limit of a run's processor time: it waits in vain."""

_ADDRESS = re.compile(r"\b0x[0-9a-f]+")


@dataclass(frozen=True)
class TrialTest:
    """A test to run with mutants, and its run in the original code: the hash of its record, its end, its outcomes."""

    suite: str
    concrete: ConcreteTest
    record_sha256: str | None
    ended: str
    outcomes: tuple[str, ...]


@dataclass(frozen=True)
class MutantTrial:
    """A mutant with the ids of the tests to try it on, in order.

    Args:
        path: the path of the changed file; empty for the code as it is.
        text: the text of the changed file.
    """

    mutant: str
    tests: tuple[str, ...]
    path: str = ""
    text: str = field(default="", repr=False)


@dataclass(frozen=True)
class MutationJob:
    """The job of the process: mutants, and the tests to try them on.

    Args:
        arguments: the arguments of pytest, as the session was started with.
        tests: id -> test.
        control: the code as it is: its runs must be those of the session.
        processes: number of processes at the same time.
        run_s: a run that takes more processor time (s) does not end.
        seconds: no mutant is begun after this time; None: no limit.
        matrix: whether to try a mutant on all of its tests; otherwise up to the first of each suite that fails.
    """

    arguments: tuple[str, ...]
    tests: dict[str, TrialTest]
    control: MutantTrial
    trials: tuple[MutantTrial, ...]
    processes: int
    run_s: float
    seconds: float | None
    matrix: bool

    def left(self, trial: MutantTrial, runs: Sequence[MutantRun]) -> tuple[str, ...]:
        """The tests of a trial that are still to be run after these runs."""
        done = {run.test for run in runs}
        over = set() if self.matrix else {run.suite for run in runs if run.assertions}
        return tuple(test for test in trial.tests if test not in done and self.tests[test].suite not in over)


class MutantRunEnd(msgspec.Struct, frozen=True, tag=True):
    """A run of a mutant; the first one that changed and in which nothing failed has its whole behaviour."""

    mutant: str
    run: MutantRun
    behaviour: Behaviour | None = None


class TrialEnd(msgspec.Struct, frozen=True, tag=True):
    """All runs of a mutant that were needed are done."""

    mutant: str


class ControlDiffers(msgspec.Struct, frozen=True, tag=True):
    """Runs without any mutant differ from those of the session: nothing was tried."""

    reason: str


TrialEvent = MutantRunEnd | TrialEnd | ControlDiffers


def events(job: MutationJob) -> Iterator[TrialEvent]:
    """Do a job; what there is to tell, as soon as it is known."""
    for event in _try(replace(job, seconds=None), [job.control]):
        if isinstance(event, MutantRunEnd) and (event.run.assertions or event.run.changed):
            failed = ", ".join(event.run.assertions)
            yield ControlDiffers(
                f"{event.run.test}: {event.run.note or (failed and f'{failed} failed') or 'another record'}"
            )
            return
    yield from _try(job, job.trials)


def _try(job: MutationJob, trials: Sequence[MutantTrial]) -> Iterator[MutantRunEnd | TrialEnd]:
    began_s = time.monotonic()
    runs: dict[str, list[MutantRun]] = {trial.mutant: [] for trial in trials}
    queue, killed = deque(trials), Counter[str]()
    pool = ProcessPool[MutantTrial](
        lambda trial, send: _Trier(job, trial, send).run(), job.processes, SILENCE * job.run_s
    )
    for event in pool.run(queue):
        trial = event.item
        if isinstance(event, OutputLine):
            ended = msgspec.json.decode(event.text, type=MutantRunEnd)
            runs[trial.mutant].append(ended.run)
            yield ended
            continue
        left = job.left(trial, runs[trial.mutant])
        killed[trial.mutant] += event.problem == KILLED
        if left and not (event.problem == KILLED and killed[trial.mutant] < MAX_ATTEMPTS):  # it ended within a run
            runs[trial.mutant].append(_end_run(job.tests[left[0]].suite, left[0], event.problem))
            yield MutantRunEnd(trial.mutant, runs[trial.mutant][-1])
            left = job.left(trial, runs[trial.mutant])
        if left:
            queue.appendleft(replace(trial, tests=left))
        else:
            yield TrialEnd(trial.mutant)
        if job.seconds is not None and time.monotonic() - began_s > job.seconds:
            queue.clear()


def _end_run(suite: str, test: str, problem: str) -> MutantRun:
    """The run in which a process came to its end, or was ended."""
    spins = signal.SIGXCPU.name in problem
    oracle = ENDING if spins or not problem.startswith("ended") else EXCEPTION
    note = "takes too much processor time" if spins else problem
    return MutantRun(test=test, suite=suite, assertions=(oracle,), changed=True, note=note)


class _Trier:
    """Tries one mutant in its own process; a plugin of the pytest that is configured there."""

    def __init__(self, job: MutationJob, trial: MutantTrial, send: Send) -> None:
        self._job = job
        self._trial = trial
        self._send = send
        self._runs: list[MutantRun] = []

    def run(self) -> None:
        """Run the tests of the trial; each run is sent."""
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if self._trial.path:
            sys.meta_path.insert(0, FaultyImport({Path(self._trial.path): self._trial.text}))
            silence(2)
        limit_processor_time(self._job.run_s)
        run_configured(self._job.arguments, self._run_all)
        if not self._runs:
            self._tell(self._trial.tests[0], (EXCEPTION,), "the testbench cannot be built")

    def _run_all(self, context: RunContext) -> None:
        while left := self._job.left(self._trial, self._runs):
            limit_processor_time(self._job.run_s)
            self._run(left[0], context)

    def _run(self, name: str, context: RunContext) -> None:
        test = self._job.tests[name]
        try:
            result = execute(context.run_settings, test.concrete)
        except Exception as error:
            self._tell(name, (EXCEPTION,), f"{type(error).__name__}: {text_of(error)}")
            return
        oracles = tuple(_has_failed(result, context.violation_exemptions))
        outcome = result.outcome
        now = (result.record.sha256, outcome.ended, tuple(outcome.outcomes))
        changed = now != (test.record_sha256, test.ended, test.outcomes)
        first = changed and not oracles and not test.concrete.schedule and not any(run.changed for run in self._runs)
        behaviour = _behaviour(test, result, context) if first else None
        self._tell(name, oracles, "; ".join(result.errors), changed=changed, behaviour=behaviour)

    def _tell(
        self,
        name: str,
        oracles: tuple[str, ...],
        note: str = "",
        *,
        changed: bool = True,
        behaviour: Behaviour | None = None,
    ) -> None:
        suite, note = self._job.tests[name].suite, _ADDRESS.sub("0x...", note)
        self._runs.append(MutantRun(test=name, suite=suite, assertions=oracles, changed=changed, note=note))
        self._send(encode(MutantRunEnd(self._trial.mutant, self._runs[-1], behaviour)))


def _has_failed(result: CaseResult, known_violations: Container[str]) -> Iterator[str]:
    """The oracles that fail a run."""
    yield from list_undeclared_violations(result, known_violations)
    if result.ending_faults:
        yield EXCEPTION if result.error is not None else ENDING
    if result.bin_faults:
        yield BIN


def _behaviour(test: TrialTest, result: CaseResult, context: RunContext) -> Behaviour:
    concrete, ranges = test.concrete, context.collection.testbench.commands
    case = HriCase(test.suite, abstract_from(concrete, "mutant", keeps_id=True), ranges, fixed=concrete)
    return behaviour_of(build_result(case, concrete.id, result, requirements=context.requirements))


def main() -> None:
    """Do the job that is read from standard input; a line of standard output is a `TrialEvent`."""
    preload()
    with channel() as (messages, write):
        job = msgspec.json.decode(messages.readline(), type=MutationJob)
        for event in events(job):
            write(msgspec.json.encode(event))


if __name__ == "__main__":
    main()
