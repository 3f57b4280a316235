"""The process that records runs: it reads a job, and forks a process for each version of the code, which runs tests.

`Recordings` starts it with a `RecordingJob`. Only the fork imports the code under test, with or without a seeded bug.
Each run is stored in a file of its own; later sessions use the files that exist, so an interrupted session resumes.
"""

from __future__ import annotations

import signal
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.execution.case import execute
from pytest_hricdv.execution.faulty_import import FaultyImport
from pytest_hricdv.execution.forks import OutputLine, ProcessPool, Send
from pytest_hricdv.execution.judge import list_undeclared_violations
from pytest_hricdv.extra.suggestion.stored_run import Authorship, StoredRun, read, store, write
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Requirement, parse_formula
from pytest_hricdv.session.child_process import (
    channel,
    disable_core_dumps,
    limit_processor_time,
    preload,
    run_configured,
    silence,
)
from pytest_hricdv.session.run_context import RunContext

SILENCE = 30
"""A version is ended if it sends nothing for this many times the limit of a run's processor time, as a mutant is."""

MAX_CHANGED = 2
"""A version with a bug runs no more tests after this many records that differ from those of the original code."""


@dataclass(frozen=True)
class RecordingRequest:
    """A test, the file that its run is stored in, and the hash of its record in the original code; empty if unknown."""

    test: ConcreteTest
    file: str
    record_sha256: str = ""


@dataclass(frozen=True)
class Version:
    """The code under test, as it is or with a seeded bug, and the runs to make with it, in order.

    Args:
        name: name of the bug; empty for the code as it is.
        path: the path of the changed file; empty for the code as it is.
        text: the text of the changed file.
    """

    name: str
    runs: tuple[RecordingRequest, ...]
    path: str = ""
    text: str = field(default="", repr=False)


@dataclass(frozen=True)
class RecordingJob:
    """The job of the process: the versions of the code, and the runs to record of each.

    Args:
        arguments: the arguments of pytest, as the session was started with.
        folder: the folder of the stored runs.
        processes: number of processes at the same time.
        run_s: a run that takes more processor time (s) does not end.
        seconds: no version is begun after this time; None: no limit.
        formulas: more requirements to judge runs by; a run continues until they are decided.
    """

    arguments: tuple[str, ...]
    folder: str
    versions: tuple[Version, ...]
    processes: int
    run_s: float
    seconds: float | None = None
    formulas: tuple[str, ...] = ()


class VersionEnd(msgspec.Struct, frozen=True):
    """The end of a version: all of its runs to repeat are stored."""

    name: str


def events(job: RecordingJob) -> Iterator[VersionEnd]:
    """Do a job; yields each version that is done."""
    began_s, folder = time.monotonic(), Path(job.folder)
    queue = deque(job.versions)
    pool = ProcessPool[Version](
        lambda version, send: _Recorder(job, version, send).run(), job.processes, SILENCE * job.run_s
    )
    for event in pool.run(queue):
        if isinstance(event, OutputLine):
            continue  # a run is stored
        version = event.item
        left = list(runs_to_repeat(folder, version))
        if left and event.problem:  # it ended within a run
            write(folder / left[0].file, StoredRun(test=left[0].test.id, errors=(_words(event.problem),)))
            left = list(runs_to_repeat(folder, version))
        if left and event.problem:
            queue.appendleft(version)
        else:
            yield VersionEnd(version.name)
        if job.seconds is not None and time.monotonic() - began_s > job.seconds:
            queue.clear()


def _words(problem: str) -> str:
    return "takes too much processor time" if signal.SIGXCPU.name in problem else problem


def runs_to_repeat(folder: Path, version: Version) -> Iterator[RecordingRequest]:
    """The runs of a version that are left to make: of a bug, until enough of them differ or one fails."""
    changed = 0
    for planned in version.runs:
        if version.name and changed >= MAX_CHANGED:
            return
        run = read(folder / planned.file)
        if run is None:
            yield planned
            continue
        if version.name and (run.failed or run.errors):
            return
        changed += run.sha256 != planned.record_sha256


class _Recorder:
    """Records the runs of one version in its own process; a plugin of the pytest that is configured there."""

    def __init__(self, job: RecordingJob, version: Version, send: Send) -> None:
        self._job = job
        self._version = version
        self._send = send

    def run(self) -> None:
        """Make the runs, store and report them."""
        disable_core_dumps()
        if self._version.path:
            sys.meta_path.insert(0, FaultyImport({Path(self._version.path): self._version.text}))
            silence(2)
        limit_processor_time(self._job.run_s)
        run_configured(self._job.arguments, self._run_all)
        raise SystemExit(1)  # pytest could not be configured, so the testbench cannot be built with this bug

    def _run_all(self, context: RunContext) -> None:
        folder = Path(self._job.folder)
        while planned := next(runs_to_repeat(folder, self._version), None):
            limit_processor_time(self._job.run_s)
            write(folder / planned.file, record_run(planned.test, context, self._job.formulas))
            self._send(planned.test.id)


def record_run(test: ConcreteTest, context: RunContext, formulas: Sequence[str] = ()) -> StoredRun:
    """Run a test, judged by these requirements as well; returns what is stored."""
    authorship, settings = Authorship(), context.run_settings
    if formulas:
        vocabulary = context.collection.testbench.vocabulary()
        further = (Requirement(text, text, "", text, parse_formula(text, vocabulary)) for text in formulas)
        settings = replace(settings, requirements=(*settings.requirements, *further))
    try:
        result = execute(settings, test, watching=(authorship,), begun=authorship.begin)
    except Exception as error:
        return StoredRun(test=test.id, errors=(f"{type(error).__name__}: {text_of(error)}",))
    return store(test.id, result, authorship, list_undeclared_violations(result, context.violation_exemptions))


def main() -> None:
    """Do the job that is read from standard input; a line of standard output is a `VersionEnd`."""
    preload()
    with channel() as (messages, write_line):
        job = msgspec.json.decode(messages.readline(), type=RecordingJob)
        for event in events(job):
            write_line(msgspec.json.encode(event))


if __name__ == "__main__":
    main()
