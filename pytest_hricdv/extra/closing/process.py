"""The process of a closing loop: runs the tests that it is sent in forks, and returns observations.

`ClosingRuns` starts `main` in a subprocess or on a cluster, sends it `LoopSettings` and then `TestBatch`es, and gets an
`ObservationReply` for each test. Each run begins from the same state of this process, whatever ran before: so it is the
same on any number of processes.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import io
import os
import sys
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec

from pytest_hricdv.execution.case import CaseResult, execute
from pytest_hricdv.execution.execution_feature import Watcher
from pytest_hricdv.execution.forks import KILLED, MAX_ATTEMPTS, OutputLine, ProcessPool, Send
from pytest_hricdv.extra.closing.observation import RunObservation, observe
from pytest_hricdv.extra.closing.online_strategy import OnlineRun, roles_of
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.online.role import Role
from pytest_hricdv.results.codec import encode
from pytest_hricdv.run import Actions
from pytest_hricdv.session.child_process import (
    END,
    RUN_S,
    channel,
    disable_core_dumps,
    limit_processor_time,
    preload,
    run_configured,
    send_identity,
)
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.testbench_search import engine_modules

T = TypeVar("T")  # what a run of a test returns


def may_fork() -> bool:
    """Whether this process can fork: the operating system can, and Python has no other thread in it."""
    return hasattr(os, "fork") and threading.active_count() == 1


@dataclass(frozen=True)
class ForkRunner(Generic[T]):
    """Runs tests in forks of this process, and describes each run in a line.

    Args:
        execute: runs a test.
        text: what is to be said of the test with a number, in one line: of its result, or, where it has none, of the
            problem; made in the process that ran it.
        processes: largest number at a time.
        limit_s: limit of a run (s of wall time).
    """

    execute: Callable[[ConcreteTest], T]
    text: Callable[[int, T | None, str], str]
    processes: int
    limit_s: float

    def run(self, tests: Sequence[ConcreteTest]) -> Iterator[tuple[int, str]]:
        """Run tests; yields the number of each with its observation, as soon as it is known."""
        if not may_fork():
            yield from ((number, self._run_text(number, test)) for number, test in enumerate(tests))
            return
        gc.freeze()  # a collection in a fork would copy all that the forks share
        try:
            yield from self._in_forks(tests)
        finally:
            gc.unfreeze()

    def _in_forks(self, tests: Sequence[ConcreteTest]) -> Iterator[tuple[int, str]]:
        def work(number: int, send: Send) -> None:
            send(self._run_text(number, tests[number]))

        longest_first = sorted(range(len(tests)), key=lambda number: -len(tests[number].actions))  # all end together
        done, attempts, queue = set[int](), Counter[int](), deque(longest_first)
        for event in ProcessPool(work, self.processes, self.limit_s).run(queue):
            if isinstance(event, OutputLine):
                done.add(event.item)
                yield event.item, event.text
                continue
            attempts[event.item] += 1
            if event.item not in done and event.problem == KILLED and attempts[event.item] < MAX_ATTEMPTS:
                queue.append(event.item)
            elif event.item not in done:
                problem = f"its process: {event.problem or 'ended without a result'}"
                yield event.item, self.text(event.item, None, problem)

    def _run_text(self, number: int, test: ConcreteTest) -> str:
        try:
            return self.text(number, self.execute(test), "")
        except Exception as error:
            cause = error.__cause__ or error  # what a node raised says more than that it failed
            return self.text(number, None, f"{type(cause).__name__}: {cause}")


LIMIT_S = 300.0
"""Wall time (s) after which a run is ended. Beside thirty other processes on two cores, a run of 3 s of processor time
took 50 s."""


@dataclass(frozen=True)
class LoopSettings:
    """The settings of the process, its first line.

    Args:
        arguments: the arguments of pytest, as the session was started with.
        processes: number of processes at the same time.
    """

    arguments: tuple[str, ...]
    processes: int


@dataclass(frozen=True)
class TestBatch:
    """A request to run tests, a later line.

    Args:
        number: the number of this request, which its answers repeat.
        tests: the tests to run, as `AbstractTest.to_data` gives them.
        online: the numbers of those in which the person decides during the run.
    """

    number: int
    tests: tuple[dict[str, Any], ...]
    online: tuple[int, ...] = ()


class ObservationReply(msgspec.Struct, frozen=True, tag=True):
    """The observation of the test with this number, of the request with that number."""

    request: int
    number: int
    observation: RunObservation


class BatchEnd(msgspec.Struct, frozen=True, tag=True):
    """All tests of the request were run. `files`: of the project, that are loaded here, sorted."""

    request: int
    files: tuple[str, ...]


class _LoopServer:
    """Runs the tests that are sent.

    Args:
        settings: the settings of the loop.
        write: sends a line.
        context: the context of the session that is configured here.
    """

    def __init__(self, settings: LoopSettings, write: Callable[[bytes], None], context: RunContext) -> None:
        self._settings = settings
        self._write = write
        self._context = context
        self._collection = context.collection
        self._is_warm = False
        self._online: frozenset[str] = frozenset()
        """The ids of those tests of the present batch in which the person decides during the run."""
        self._online_run: OnlineRun | None = None
        """The last run of this process, if the person decided in it."""

    def serve(self, messages: Iterable[bytes]) -> None:
        """Run one batch after the other, until there is none."""
        disable_core_dumps()
        testbench = self._collection.testbench
        for name in (*testbench.simulation.requires, *engine_modules(testbench)):
            importlib.import_module(name)
        _ = self._context.code, self._context.measurement, self._roles  # once, and not in each fork
        send_identity(self._context, self._write)
        for line in messages:
            batch = msgspec.json.decode(line, type=TestBatch)
            tests = [AbstractTest.from_data(test) for test in batch.tests]
            self._online = frozenset(tests[number].id for number in batch.online)
            for number, observation in self._run(tests):
                self._write(encode(ObservationReply(batch.number, number, observation)).encode())
            self._write(msgspec.json.encode(BatchEnd(batch.number, self._files())))
            self._write(END)

    def _run(self, tests: Sequence[AbstractTest]) -> Iterator[tuple[int, RunObservation]]:
        commands = self._collection.testbench.commands
        concrete = [concretize(test, commands) for test in tests]
        well: list[ConcreteTest] = []

        def text_of(number: int, result: CaseResult | None, problem: str) -> str:
            return encode(self._observe(tests[number], result, problem))

        runner = ForkRunner(self._execute_in_fork, text_of, self._settings.processes, LIMIT_S)
        for number, text in runner.run(concrete):
            observation = msgspec.json.decode(text, type=RunObservation)
            yield number, observation
            if not observation.error:
                well.append(concrete[number])
        if not self._is_warm:
            self._warm(well)

    def _execute_in_fork(self, test: ConcreteTest) -> CaseResult:
        limit_processor_time(RUN_S)
        return self._execute(test)

    @cached_property
    def _roles(self) -> tuple[Role, ...]:
        return roles_of(self._collection.testbench)

    def _execute(self, test: ConcreteTest) -> CaseResult:
        self._online_run = None
        actions: Actions | None = None
        watching: list[Watcher] = []
        if test.id in self._online and self._roles:
            self._online_run = OnlineRun(self._roles, self._collection.testbench.commands, test.seed)
            actions, watching = self._online_run.actions, [self._online_run.watcher]
        with contextlib.redirect_stdout(io.StringIO()):
            settings = self._context.run_settings.with_measurement(self._context.measurement)
            return execute(settings, test, "closing", producing=actions, watching=watching)

    def _observe(self, test: AbstractTest, result: CaseResult | None, problem: str) -> RunObservation:
        if result is None:
            return RunObservation(test.to_data(), error=problem)
        online_run = self._online_run
        return observe(
            test if online_run is None else online_run.to_test(result),
            result,
            code=self._context.code,
            cross=self._collection.testbench.cross,
            requirements=self._context.requirements,
            known_violations=self._context.violation_exemptions,
            state=self._collection.testbench.state.name,
        )

    def _warm(self, tests: Sequence[ConcreteTest]) -> None:
        """Repeat a test here that came to its end in a fork: what it imports and computes once, later forks have."""
        if tests:
            self._execute(min(tests, key=lambda test: (len(test.actions), test.to_json())))
            self._is_warm = True

    def _files(self) -> tuple[str, ...]:
        root = self._collection.config.rootpath
        loaded = {str(getattr(module, "__file__", None) or "") for module in [*sys.modules.values()]}
        installed = ("site-packages", "dist-packages")
        own = (Path(name) for name in loaded if name.endswith(".py"))
        return tuple(
            sorted(
                path.relative_to(root).as_posix()
                for path in own
                if path.is_relative_to(root) and not set(installed) & set(path.parts)
            )
        )


def main() -> None:
    """Serve: the first line of standard input is `LoopSettings`, the others are batches."""
    preload()
    with channel() as (messages, write):
        settings = msgspec.json.decode(messages.readline(), type=LoopSettings)
        status = run_configured(
            settings.arguments, lambda context: _LoopServer(settings, write, context).serve(messages)
        )
    sys.exit(status or 1)


if __name__ == "__main__":
    main()
