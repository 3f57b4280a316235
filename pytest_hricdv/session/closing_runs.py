"""The runs of a closing loop: in a process beside the session, of which this is the session's end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

import msgspec
import pytest

from pytest_hricdv.close.loop import OnlineWeights
from pytest_hricdv.close.observation import Observation
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.session import closing_process
from pytest_hricdv.session.closing_process import Done, Job, Told
from pytest_hricdv.session.separate_process import ProcessError, SeparateProcess, arguments_of, started


@dataclass
class ClosingRuns:
    """Runs tests in a process beside the session; a context manager, which ends it.

    Args:
        config: of the session.
        processes: so many runs at a time.
    """

    config: pytest.Config
    processes: int
    files: tuple[str, ...] = ()
    """Of the project, that the runs have loaded."""
    _stack: ExitStack = field(default_factory=ExitStack)

    def __enter__(self) -> ClosingRuns:
        directory = self.config.invocation_params.dir
        self._process: SeparateProcess = self._stack.enter_context(started(closing_process, directory))
        self._process.send(Job(arguments_of(self.config), self.processes))
        self._lines = self._process.lines()
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def run(self, tests: Sequence[AbstractTest], online: OnlineWeights) -> Iterator[tuple[int, Observation]]:
        """Run tests, as trees; yields the number of each and what it yields, as soon as it is known.

        Raises:
            ProcessError: the process failed.
        """
        return self._run(tests, online, from_the_start=False)

    def run_from_the_start(
        self, tests: Sequence[AbstractTest], online: OnlineWeights
    ) -> Iterator[tuple[int, Observation]]:
        """The same, with each test alone."""
        return self._run(tests, online, from_the_start=True)

    def _run(
        self, tests: Sequence[AbstractTest], online: OnlineWeights, *, from_the_start: bool
    ) -> Iterator[tuple[int, Observation]]:
        weights = {number: tuple(each) for number, each in online.items()}
        data = tuple(test.to_data() for test in tests)
        self._process.send(closing_process.Generation(data, from_the_start, weights))
        for line in self._lines:
            told = msgspec.json.decode(line, type=Told | Done)
            if isinstance(told, Done):
                self.files = told.files
                return
            yield told.number, told.observation
        raise ProcessError("the process of the runs ended")
