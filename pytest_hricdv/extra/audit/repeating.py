"""`Repeater`: reruns tests in fresh processes for the audit, and returns their results.

`Auditor` and `CauseSearch` use it. A `Start` says how a process starts: with which tests, and with which environment
and import path (`Begin`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from pytest_hricdv.execution.forks import MAX_ATTEMPTS
from pytest_hricdv.execution.separate_process import (
    LetThrough,
    LostError,
    ProcessError,
    SeparateProcess,
    SilentError,
    start_process,
)
from pytest_hricdv.extra.audit import process as process_module
from pytest_hricdv.extra.audit.process import RerunAnswer, RerunOrder
from pytest_hricdv.session.child_process import FreshSession

PATIENCE_S = 120.0
"""Time limit (s of wall time) for a process to begin; a run has it in addition to PATIENCE_FACTOR times its time in the
session. Chosen: collecting takes seconds, on a busy machine ten times that."""

PATIENCE_FACTOR = 20.0
"""Time limit of a run, as a multiple of its time in the session. Chosen: a busy machine makes a run ten times as long;
other values were not measured."""

SILENT = "no answer"


class StartError(Exception):
    """A fresh process did not begin; the message says why."""


@dataclass(frozen=True)
class Begin:
    """The conditions before a session's first test: variables of the environment, and where modules were found."""

    environment: Mapping[str, str]
    path: tuple[str, ...]


@dataclass(frozen=True)
class Start:
    """How a fresh process is started.

    Args:
        session: the first message that it receives.
        directory: where pytest was started.
        begin: the environment and import path to start with.
        reusable: whether it can run several orders, each in a fork.
    """

    session: FreshSession
    directory: Path
    begin: Begin
    reusable: bool

    def with_tests(self, nodeids: Sequence[str]) -> Start:
        """This start with other tests."""
        return replace(self, session=replace(self.session, nodeids=tuple(nodeids)))


class Fresh:
    """A fresh process that has begun."""

    def __init__(self, running: SeparateProcess) -> None:
        self._running = running
        self.problem = ""
        """Why it has ended; empty while it has not."""
        self.is_lost = False
        """It was killed by somebody else."""

    def begin(self, session: FreshSession) -> None:
        """Start pytest there. Raises StartError if it does not begin."""
        self._running.send(session)
        self._lines(PATIENCE_S)
        if self.problem:
            raise StartError(self.problem)

    def run(self, order: RerunOrder, patience_s: float) -> RerunAnswer:
        """Run an order; what its last test came to.

        Args:
            patience_s: after so long (s of wall time) the process is ended.
        """
        if not self.problem:
            self._running.send(order)
        lines = self._lines(patience_s)
        return msgspec.json.decode(lines[0], type=RerunAnswer) if lines else RerunAnswer(problem=self.problem or SILENT)

    def _lines(self, patience_s: float) -> list[bytes]:
        if self.problem:
            return []
        try:
            return [*self._running.answer(patience_s)]
        except SilentError:
            self.problem = f"{SILENT} for {patience_s:g} s"
        except ProcessError as error:
            self.problem, self.is_lost = str(error), isinstance(error, LostError)
        return []


@dataclass
class Repeater:
    """Runs tests again. Processes that can serve several orders are kept until the end.

    Args:
        start: starts processes.
        wall_s: node id -> how long the test took (s).
        let_through: while a process is waited for, a signal may raise.
    """

    start: Start
    wall_s: Mapping[str, float]
    let_through: LetThrough = nullcontext
    runs: int = 0
    _stack: ExitStack = field(default_factory=ExitStack)
    _kept: dict[tuple[object, ...], Fresh] = field(default_factory=dict)

    @contextmanager
    def open(self) -> Iterator[Repeater]:
        """Within: processes may be started; all are ended at the end."""
        with self._stack:
            yield self

    def run(
        self,
        order: RerunOrder,
        hash_seed: str,
        *,
        copy: int = 0,
        variables: Mapping[str, str] | None = None,
        among: Sequence[str] = (),
    ) -> RerunAnswer:
        """Run an order of tests. Raises StartError if a process does not begin.

        Args:
            order: the order of tests.
            copy: another number is another process.
            variables: the variables of the environment, besides those of the session.
            among: the tests that the process is to have; none: those of the start.
        """
        start = self.start.with_tests(among) if among else self.start
        name = (hash_seed, copy, tuple(sorted((variables or {}).items())), start.session.nodeids)
        patience_s = PATIENCE_S + PATIENCE_FACTOR * sum(self.wall_s.get(nodeid, 1.0) for nodeid in order.nodeids)
        for _ in range(MAX_ATTEMPTS):
            self.runs += len(order.nodeids)
            fresh = self._kept.get(name)
            if fresh is None:
                fresh = self._start_process(start, hash_seed, variables or {})
                if start.reusable:
                    self._kept[name] = fresh
            repeat = fresh.run(order, patience_s)
            if fresh.problem:
                self._kept.pop(name, None)  # the next order gets another one
            if not fresh.is_lost:
                break
        return repeat

    def _start_process(self, start: Start, hash_seed: str, variables: Mapping[str, str]) -> Fresh:
        process = start_process(
            process_module.__name__,
            start.directory,
            variables,
            path=start.begin.path,
            hash_seed=hash_seed,
            inherited=start.begin.environment,
            let_through=self.let_through,
        )
        try:
            running = self._stack.enter_context(process)
        except OSError as error:  # the code under test may have left the session too few files or processes
            raise StartError(str(error)) from error
        fresh = Fresh(running)
        fresh.begin(start.session)
        return fresh
