"""The process of a closing loop: it runs tests that it is sent, each in a fork of its own, and answers what they yield.

Each run begins from the same state of this process, whatever ran before: so it is the same on any number of processes.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import resource
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from pytest_hricdv.close.observation import Observation, observe
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import concretize
from pytest_hricdv.process_pool import Line, ProcessPool, Send
from pytest_hricdv.results.codec import encode
from pytest_hricdv.session.running import Running
from pytest_hricdv.session.separate_process import in_session, limit_time, preload, session

RUN_S = 60.0
"""A run that takes more processor time (s) does not end."""

SILENT_S = 120.0
"""A run that takes more time (s) waits for what never comes."""


@dataclass(frozen=True)
class Job:
    """The first line that is sent.

    Args:
        arguments: of pytest, as the session was started with.
        processes: at the same time.
    """

    arguments: tuple[str, ...]
    processes: int


@dataclass(frozen=True)
class Generation:
    """A further line: tests to run, as `AbstractTest.to_data` gives them."""

    tests: tuple[dict[str, Any], ...]


class Told(msgspec.Struct, frozen=True, tag=True):
    """What the test with this number yielded."""

    number: int
    observation: Observation


class Done(msgspec.Struct, frozen=True, tag=True):
    """All tests of a generation were run. `files`: of the project, that are loaded here, sorted."""

    files: tuple[str, ...]


class _Serving:
    """Runs the tests that are sent.

    Args:
        job: how.
        write: sends a line.
        running: of the session that is configured here.
    """

    def __init__(self, job: Job, write: Callable[[bytes], None], running: Running) -> None:
        self._job = job
        self._write = write
        self._running = running
        self._collection = running.collection
        self._is_warm = False

    def serve(self, messages: Iterable[bytes]) -> None:
        """Run one generation after the other, until there is none."""
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for name in self._collection.testbench.requires:
            importlib.import_module(name)
        _ = self._running.code, self._running.measurement  # once, and not in each fork
        for line in messages:
            generation = msgspec.json.decode(line, type=Generation)
            for told in self._run([AbstractTest.from_data(each) for each in generation.tests]):
                self._write(encode(told).encode())
            self._write(msgspec.json.encode(Done(self._files())))

    def _run(self, tests: Sequence[AbstractTest]) -> Iterator[Told]:
        """Long tests first, so that no process waits for long at the end."""
        order = sorted(range(len(tests)), key=lambda number: (-len(tests[number].lines), number))
        pool = ProcessPool[int](lambda number, send: self._work(tests[number], send), self._job.processes, SILENT_S)
        came: dict[int, Observation] = {}
        for event in pool.run(deque(order)):
            if isinstance(event, Line):
                came[event.item] = msgspec.json.decode(event.text, type=Observation)
                yield Told(event.item, came[event.item])
            elif event.item not in came:
                error = f"its process {event.problem or 'ended without a result'}"
                yield Told(event.item, Observation(tests[event.item].to_data(), error=error))
        if not self._is_warm:
            self._warm([tests[number] for number in sorted(came) if not came[number].error])

    def _work(self, test: AbstractTest, send: Send) -> None:
        limit_time(RUN_S)
        send(encode(self._observed(test)))

    def _observed(self, test: AbstractTest) -> Observation:
        running, testbench = self._running, self._collection.testbench
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                result = running.execute(concretize(test, testbench.commands), running.measurement, "closing")
        except Exception as error:
            cause = error.__cause__ or error
            return Observation(test.to_data(), error=f"{type(cause).__name__}: {cause}")
        return observe(
            test,
            result,
            code=running.code,
            cross=testbench.cross,
            requirements=running.requirements,
            known=running.known,
        )

    def _warm(self, tests: Sequence[AbstractTest]) -> None:
        """Repeat a test here that came to its end in a fork: what it imports and computes once, later forks have."""
        if tests:
            self._observed(min(tests, key=lambda test: len(test.lines)))
            self._is_warm = True

    def _files(self) -> tuple[str, ...]:
        root = self._collection.config.rootpath
        found = {str(getattr(module, "__file__", None) or "") for module in [*sys.modules.values()]}
        installed = ("site-packages", "dist-packages")
        own = (Path(name) for name in found if name.endswith(".py"))
        return tuple(
            sorted(
                path.relative_to(root).as_posix()
                for path in own
                if path.is_relative_to(root) and not set(installed) & set(path.parts)
            )
        )


def main() -> None:
    """Serve: the first line of standard input is a `Job`, the others are generations."""
    preload()
    with session() as (messages, write):
        job = msgspec.json.decode(messages.readline(), type=Job)
        status = in_session(job.arguments, lambda running: _Serving(job, write, running).serve(messages))
    sys.exit(status or 1)


if __name__ == "__main__":
    main()
