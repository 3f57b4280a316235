"""Runs the tests of a closing loop outside the session: `RunsHere` in a subprocess, `RunsOnCluster` on a cluster.

`ClosureGenerator` makes one of these `ClosingRuns`; the `Loop` calls its method `run` for each generation. The other
end, which runs the tests, is the module `process`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, nullcontext
from itertools import count, pairwise
from typing import Self

import msgspec
import pytest

from pytest_hricdv.execution.forks import MAX_ATTEMPTS
from pytest_hricdv.execution.separate_process import LetThrough, LostError, ProcessError, SeparateProcess, start_process
from pytest_hricdv.extra.closing import process as closing_process
from pytest_hricdv.extra.closing.loop import GivenUpError, OnlineTests
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.process import BatchEnd, LoopSettings, ObservationReply, TestBatch
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.session.child_process import session_arguments
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.remote import Answer, LostRequest, Remote, Workers, WorkRequest

BATCH_S = 600.0
"""Time without an observation (s) after which a process on a cluster counts as lost: twice `LIMIT_S` of `process`, the
limit of a run."""


class ClosingRuns(ABC):
    """Runs tests for a closing loop; a context manager, which ends the processes."""

    files: tuple[str, ...] = ()
    """The files of the project that runs have loaded, on which a cached suite depends."""

    def __init__(self, say: Callable[[str], None], let_through: LetThrough) -> None:
        self._stack = ExitStack()
        self._requests = count(1)
        self._say = say
        self._let_through = let_through
        self._losses = 0

    @abstractmethod
    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    @abstractmethod
    def run(self, tests: Sequence[AbstractTest], online: OnlineTests) -> Iterator[tuple[int, RunObservation]]:
        """Run tests. Yields the number of each test and its observation as soon as it is known.

        Raises:
            ProcessError, ClusterError: no process that runs tests could be started.
            GivenUpError: the process was lost repeatedly.
        """

    def _observations(
        self, lines: Iterable[bytes], request: int, numbers: Sequence[int]
    ) -> Iterator[tuple[int, RunObservation]]:
        """The observations of the tests with these numbers in an answer; answers to another request are dropped."""
        for line in lines:
            answer = msgspec.json.decode(line, type=ObservationReply | BatchEnd)
            if answer.request != request:
                continue
            if isinstance(answer, BatchEnd):
                self.files = tuple(sorted({*self.files, *answer.files}))
            else:
                yield numbers[answer.number], answer.observation

    def _lose(self, problem: str, where: str = "") -> None:
        """A process was lost. Raises GivenUpError if that was one too many."""
        self._losses += 1
        if self._losses >= MAX_ATTEMPTS:
            raise GivenUpError(f"{_loss_text(self._losses)}, the last time{where}: {problem}") from None
        self._say(f"the process of the closing loop{where} was lost: {problem}; it is replaced")


class RunsHere(ClosingRuns):
    """Runs tests in a process next to the session; in another one if it is lost.

    A process whose answer was not read to its end is ended: it may be busy with it, and a session that is interrupted
    has no time for that.

    Args:
        processes: largest number of runs at a time.
        say: receives messages.
        let_through: while the process is waited for, a signal may raise.
    """

    def __init__(
        self,
        config: pytest.Config,
        processes: int,
        say: Callable[[str], None] = lambda text: None,
        let_through: LetThrough = nullcontext,
    ) -> None:
        super().__init__(say, let_through)
        self._config = config
        self._processes = processes
        self._process: SeparateProcess | None = None
        self._has_begun = False

    def __enter__(self) -> Self:
        self._start()
        return self

    def _start(self) -> SeparateProcess:
        directory = self._config.invocation_params.dir
        starting = start_process(closing_process.__name__, directory, let_through=self._let_through)
        self._process = process = self._stack.enter_context(starting)
        self._has_begun = False
        process.send(LoopSettings(session_arguments(self._config), self._processes))
        return process

    def _end(self) -> None:
        self._process = None
        self._stack.close()

    def run(self, tests: Sequence[AbstractTest], online: OnlineTests) -> Iterator[tuple[int, RunObservation]]:
        """See `ClosingRuns`. Tests of a lost process run again, and do the same: each begins from the same state."""
        observed: set[int] = set()
        left = [*range(len(tests))]
        while True:
            try:
                for number, observation in self._answer(tests, left, online):
                    if number not in observed:
                        observed.add(number)
                        yield number, observation
                return
            except ProcessError as error:
                if not (self._has_begun or isinstance(error, LostError)):
                    raise  # it says why it cannot begin, and another one could not either
                self._lose(str(error))
            # The last one again, where all are known: only whoever has run a test tells all files of the project.
            left = [number for number in left if number not in observed] or left[-1:]

    def _answer(
        self, tests: Sequence[AbstractTest], numbers: Sequence[int], online: OnlineTests
    ) -> Iterator[tuple[int, RunObservation]]:
        if self._losses >= MAX_ATTEMPTS:
            raise GivenUpError(_loss_text(self._losses))
        process, request = self._process or self._start(), next(self._requests)
        is_read = False
        try:
            if not self._has_begun:  # not when it is started: until it is asked, the session has other things to do
                deque(process.answer(BATCH_S), maxlen=0)  # who it is, which is known here
                self._has_begun = True
            process.send(_batch(request, tests, numbers, online))
            yield from self._observations(process.answer(BATCH_S), request, numbers)
            is_read = True
        finally:
            if not is_read:
                self._end()


def _loss_text(times: int) -> str:
    return f"the process that runs its tests was lost {times} times"


class RunsOnCluster(ClosingRuns):
    """Runs tests on the workers of a cluster, each of which has a process for them; in another one if it is lost.

    Args:
        cluster: the cluster, with the workers.
        project: files that have to be there as they are here, name -> hash.
        let_through: while the cluster is waited for, a signal may raise.

    Raises:
        ClusterError: there is no such cluster, or the project is too large to be sent.
    """

    def __init__(
        self,
        cluster: Remote,
        collection: Collection,
        project: Mapping[str, str],
        let_through: LetThrough = nullcontext,
    ) -> None:
        super().__init__(lambda text: collection.say(f"hricdv: {text}"), let_through)
        options, config = collection.options, collection.config
        self._cluster, self._address = cluster, cluster.address_of_session(options)
        there = cluster.project_of_session(config, options)
        settings = msgspec.json.encode(LoopSettings((*there.arguments, *session_arguments(config)), 1))
        self._service = there.service(closing_process.__name__, settings, project, BATCH_S)

    def __enter__(self) -> Self:
        connecting = self._cluster.connect(self._address, self._say)
        with self._let_through():
            self._workers: Workers = self._stack.enter_context(connecting)
        return self

    def run(self, tests: Sequence[AbstractTest], online: OnlineTests) -> Iterator[tuple[int, RunObservation]]:
        """See `ClosingRuns`. Tests of a lost process run again, as those of one next to the session."""
        observed: set[int] = set()
        parts: dict[str, Sequence[int]] = {}
        questions, request = deque[WorkRequest](), next(self._requests)

        def ask(numbers: Sequence[int]) -> None:
            key = tests[numbers[0]].id
            parts[key] = numbers
            questions.append(WorkRequest(key, msgspec.json.encode(_batch(request, tests, numbers, online))))

        for part in _split(len(tests), max(1, self._workers.threads)):
            ask(part)
        with closing(self._workers.answers(self._service, questions)) as answers:
            while (answered := self._next(answers)) is not None:
                question, answer = answered
                numbers = parts[question.key]
                lines = () if isinstance(answer, LostRequest) else answer.lines
                for number, observation in self._observations(lines, request, numbers):
                    if number not in observed:
                        observed.add(number)
                        yield number, observation
                left = [number for number in numbers if number not in observed]
                if isinstance(answer, LostRequest):
                    yield from (
                        (number, RunObservation(tests[number].to_data(), error=answer.reason)) for number in left
                    )
                elif answer.problem:
                    self._lose(answer.problem, f" on worker {answer.worker.address} ({answer.worker.host})")
                    ask(left or numbers[-1:])  # as next to the session

    def _next(
        self, answers: Iterator[tuple[WorkRequest, Answer | LostRequest]]
    ) -> tuple[WorkRequest, Answer | LostRequest] | None:
        with self._let_through():
            return next(answers, None)


def _batch(request: int, tests: Sequence[AbstractTest], numbers: Sequence[int], online: OnlineTests) -> TestBatch:
    places = tuple(place for place, number in enumerate(numbers) if number in online)
    return TestBatch(request, tuple(tests[number].to_data() for number in numbers), places)


def _split(size: int, parts: int) -> list[range]:
    """Numbers from 0 in this number of parts of about the same size."""
    bounds = [size * part // parts for part in range(parts + 1)]
    return [range(low, high) for low, high in pairwise(bounds) if low < high]
