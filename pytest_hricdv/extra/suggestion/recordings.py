"""`Recordings`: makes and stores the runs that suggestions rest on, of tests with and without seeded bugs.

`Suggester` uses it. The runs take place in separate processes (`process`); `vary_tests` draws further parameters.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import cycle, islice
from pathlib import Path

import msgspec

from pytest_hricdv._base.project_files import identity
from pytest_hricdv.execution.faulty_import import SeededFault
from pytest_hricdv.execution.forks import MAX_ATTEMPTS
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.separate_process import LetThrough, LostError, ProcessError, start_process
from pytest_hricdv.extra.suggestion import process as recording_process
from pytest_hricdv.extra.suggestion.process import RecordingJob, RecordingRequest, Version, VersionEnd, runs_to_repeat
from pytest_hricdv.extra.suggestion.stored_run import StoredRun, read
from pytest_hricdv.generate.concrete import UNIFORM, ConcreteTest, concretize
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.session.child_process import session_arguments
from pytest_hricdv.session.progress import time_left
from pytest_hricdv.session.run_context import RunContext

MIN_RUN_S, FACTOR = 10, 10
"""A run counts as endless after this processor time (s), or FACTOR times that of the slowest test if this is more."""

FIRST_VARIANT = 1_000
"""The tests of `vary_tests` have concretization numbers from here on; a session has fewer concretizations of a test."""


class RecordingError(Exception):
    """Runs cannot be recorded; the message says why."""


@dataclass
class Recordings:
    """Makes runs, and keeps them in a folder: a run that is there already is not made again.

    Args:
        processes: number of processes at the same time.
        slowest_s: the slowest test (s of wall time).
        let_through: while runs are made, a signal may raise.
    """

    context: RunContext
    folder: Path
    processes: int
    slowest_s: float
    say: Callable[[str], None]
    let_through: LetThrough = nullcontext

    def __post_init__(self) -> None:
        here = identity(Path(self.context.collection.config.rootpath), self.context.provenance.code)
        simulation = self.context.collection.testbench.simulation
        engine = simulation.engine, simulation.fidelity
        # What is judged is not part of a run, but of what is stored of it: which requirements failed.
        texts = {name: text.text for name, text in self.context.texts.items()}
        self._key = digest(sorted(here.project.items()), sorted(here.versions.items()), engine, sorted(texts.items()))

    def request(
        self,
        test: ConcreteTest,
        fault: SeededFault | None = None,
        record_sha256: str = "",
        formulas: Sequence[str] = (),
    ) -> RecordingRequest:
        """A run to be made, with the file that it is stored in: another one where anything is different."""
        name = digest(self._key, test.to_json(), "" if fault is None else fault.path + fault.text, *formulas)
        return RecordingRequest(test, f"{name[:32]}.run", record_sha256)

    def of_tests(self, tests: Sequence[ConcreteTest], what: str, formulas: Sequence[str] = ()) -> list[StoredRun]:
        """The runs of tests with the unchanged code, in order, except those that did not end.

        Args:
            what: what they are, for people.
            formulas: further requirements; a run continues until they are decided, and `failed` has those that failed.

        Raises:
            RecordingError: they cannot be made.
            KeyboardInterrupt: it was interrupted; what is stored stays.
        """
        planned = [self.request(test, formulas=formulas) for test in tests]
        # Some tests a process: starting one takes as long as several runs.
        size = max(1, -(-len(planned) // max(1, self.processes)))
        versions = [Version("", tuple(planned[at : at + size])) for at in range(0, len(planned), size)]
        self._record(versions, what, None, formulas)
        runs = (read(self.folder / run.file) for run in planned)
        return [run for run in runs if run is not None and run.has_record]

    def of_faults(
        self, faults: Mapping[SeededFault, Sequence[tuple[ConcreteTest, str]]], seconds: float | None
    ) -> dict[SeededFault, list[StoredRun]]:
        """The runs with seeded bugs, each with its tests, in order, up to the first that decides.

        Args:
            faults: seeded bug -> tests to try it on, each with the hash of its record in the original code.
            seconds: none is begun later; None: no limit.

        Returns:
            Seeded bug -> its runs that differ from those in the original code; bugs that were not tried are not in it.

        Raises:
            RecordingError: they cannot be made.
            KeyboardInterrupt: it was interrupted; what is stored stays.
        """
        versions = {
            fault: Version(
                fault.name, tuple(self.request(test, fault, sha) for test, sha in tests), fault.path, fault.text
            )
            for fault, tests in faults.items()
            if tests
        }
        self._record([*versions.values()], "seeded bugs", seconds)
        return {
            fault: [run for run, planned in self._read(version) if run.sha256 != planned.record_sha256]
            for fault, version in versions.items()
            if not [*runs_to_repeat(self.folder, version)]
        }

    def _read(self, version: Version) -> Iterable[tuple[StoredRun, RecordingRequest]]:
        for planned in version.runs:
            run = read(self.folder / planned.file)
            if run is not None:
                yield run, planned

    def _record(
        self, versions: Sequence[Version], what: str, seconds: float | None, formulas: Sequence[str] = ()
    ) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        left = [version for version in versions if next(iter(runs_to_repeat(self.folder, version)), None) is not None]
        if not left:
            return None
        self.say(f"hricdv: recording {what}, {self.processes} at a time ...")
        job = RecordingJob(
            arguments=session_arguments(self.context.collection.config),
            folder=str(self.folder.resolve()),
            versions=tuple(left),
            processes=self.processes,
            run_s=max(MIN_RUN_S, FACTOR * self.slowest_s),
            seconds=seconds,
            formulas=tuple(formulas),
        )
        for attempt in range(MAX_ATTEMPTS):
            try:
                return self._follow(job, what)
            except LostError as error:
                if attempt == MAX_ATTEMPTS - 1:
                    raise RecordingError(f"the process that records runs was lost: {error}") from None
                still = tuple(version for version in job.versions if [*runs_to_repeat(self.folder, version)])
                job = replace(job, versions=still)
            except ProcessError as error:
                raise RecordingError(f"runs could not be recorded: {error}") from None
        return None

    def _follow(self, job: RecordingJob, what: str) -> None:
        began_s, total, done = time.monotonic(), len(job.versions), 0
        directory = self.context.collection.config.invocation_params.dir
        with start_process(recording_process.__name__, directory, let_through=self.let_through) as recording:
            recording.send(job)
            for line in recording.lines():
                msgspec.json.decode(line, type=VersionEnd)
                done += 1
                if done * 5 // total > (done - 1) * 5 // total and done < total:
                    left_s = (time.monotonic() - began_s) / done * (total - done)
                    self.say(f"hricdv: {what}: {done} of {total}, {time_left(left_s)}")


def vary_tests(cases: Sequence[HriCase], count: int) -> list[ConcreteTest]:
    """The tests of the session with other parameters, every other one at the ends of the ranges, where bounds break
    first.

    Args:
        cases: the session's cases, in an order that does not depend on workers.
        count: how many.
    """
    made: list[ConcreteTest] = []
    for number, case in enumerate(islice(cycle(cases), count)):
        drawn = replace(case.abstract, values={})  # without chosen values
        made.append(concretize(drawn, case.ranges, FIRST_VARIANT + number, "corners" if number % 2 else UNIFORM))
    return made
