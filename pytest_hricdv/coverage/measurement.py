"""Measures the code under test while it runs inside its own greenlet, and nowhere else.

A session gets its `Measurement` from `choose`; each run of a test calls `measure` for the code under test. The tracer
starts in the greenlet of the code under test and is limited to it. So every line and branch of the code is recorded,
and the rest of the process (world, human, monitors) runs at full speed. With `--cov` the session shares the measurement
of pytest-cov (`JoinedMeasurement`), since a second one would silently pause the first.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import greenlet

from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.greenlet_settrace import forget_left_greenlets, keep_to_this_greenlet
from pytest_hricdv.coverage.import_coverage import ImportCoverage, users_data
from pytest_hricdv.coverage.own_coverage import (
    FilesOf,
    OwnCoverage,
    debugger,
    exactly,
    is_coverages,
    literally,
    users_tracer,
)

if TYPE_CHECKING:
    import coverage
    from coverage.sqldata import CoverageData

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

TAKEN_OVER = "a debugger took the trace function over while the code under test ran"
"""Why such a run has no coverage (`Measurement.reason`)."""


class Measurement(Protocol):
    """Measures one test at a time, in one greenlet or several."""

    @property
    def reason(self) -> str:
        """Why nothing can be measured; empty if it can."""

    def watch_imports(self, context: str) -> AbstractContextManager[None]:
        """Within the block: notes which modules are imported by the test that is measured under `context`."""

    def measure(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, measured under `context` when it is run in a greenlet of its own."""

    def take(self, context: str) -> Bits | None:
        """The coverage of `context`, including that of importing its modules; None when unmeasured."""

    def settle(self) -> None:
        """A run is over: greenlets that are still measured were left where they are, and will not continue."""


@dataclass(frozen=True)
class NoMeasurement:
    """Measures nothing, and says why. A measurement of the user still records all of the code under test."""

    reason: str

    def watch_imports(self, context: str) -> AbstractContextManager[None]:
        """Notes nothing."""
        return nullcontext()

    def measure(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, with the user's tracer limited to it; otherwise greenlet switches drop covered lines."""
        tracer = users_tracer()

        def run_body() -> None:
            with keep_to_this_greenlet():
                sys.settrace(tracer)
                return body()

        return body if tracer is None else run_body

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()


class OwnMeasurement:
    """The plugin's own `Coverage`: one for the process, reused for every test."""

    def __init__(self, code: CodeMap, imports: ImportCoverage, own: OwnCoverage) -> None:
        self.reason = ""
        self._code = code
        self._imports = imports
        self._own = own
        self._asked: dict[str, set[str]] = {}

    @contextmanager
    def watch_imports(self, context: str) -> Iterator[None]:
        """See `Measurement`."""
        with self._imports.watch.note_imports() as self._asked[context]:
            yield

    def begin(self) -> None:
        """Measure nothing: what coverage does at its first start, forks of this process then need not do again."""
        greenlet.greenlet(self.measure("", lambda: None)).switch()
        self.take("")

    def measure(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def run_body() -> None:
            with self._own.record(context):
                return body()

        return run_body

    def take(self, context: str) -> Bits | None:
        """See `Measurement`. A run that a debugger interrupted is unmeasured: its data would be incomplete."""
        take_over, asked = self._own.take_over(), self._asked.pop(context, set())
        self.reason = TAKEN_OVER if take_over else ""
        self._imports.collect()
        data = self._own.data()
        try:
            return None if take_over else self._imports.with_imports(*read(data, self._code, exactly(context)), asked)
        finally:
            data.erase()  # it is not needed again, and the lines of thousands of tests need memory

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()
        self._own.settle()


class JoinedMeasurement:
    """The user's running `Coverage`; contexts give the share of each test.

    Args:
        current: the running measurement.
        contexts_by_test: whether the user's options already switch contexts (`--cov-context=test`).
    """

    def __init__(
        self, code: CodeMap, imports: ImportCoverage, current: coverage.Coverage, *, contexts_by_test: bool
    ) -> None:
        self.reason = ""
        self._code = code
        self._imports = imports
        self._asked: dict[str, set[str]] = {}
        self._current = current
        self._contexts_by_test = contexts_by_test
        self._tracer = users_tracer()
        self._taken_over = False
        self._greenlets = 0  # that are measured now
        self._users_context: str | None = None

    @contextmanager
    def watch_imports(self, context: str) -> Iterator[None]:
        """See `Measurement`."""
        self._imports.begin()
        with self._imports.watch.note_imports() as self._asked[context]:
            yield

    def measure(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def run_body() -> None:
            self._greenlets += 1
            if self._greenlets == 1 and not self._contexts_by_test:
                self._users_context = self._switch(context)
            with keep_to_this_greenlet():
                sys.settrace(self._tracer)
                try:
                    return body()
                finally:
                    self._taken_over |= not is_coverages(sys.gettrace())
                    self._greenlets -= 1
                    if self._greenlets == 0 and not self._contexts_by_test:
                        self._switch(self._users_context)

        return run_body

    def take(self, context: str) -> Bits | None:
        """See `Measurement`."""
        take_over, self._taken_over = self._taken_over, False
        asked = self._asked.pop(context, set())
        if take_over:
            self.reason = TAKEN_OVER
            return None
        nodeid = context.partition("|")[2]
        pattern = f"{exactly(context)}|{exactly(nodeid + '|run')}"
        bits, files = read(users_data(self._current), self._code, pattern)
        if bits.statements == 0:
            remedy = " ".join(f"--cov={package}" for package in self._code.packages)
            self.reason = f"the running measurement (--cov) does not measure the code under test: add {remedy}"
            return None
        if bits.branches is None:
            self.reason = "the running measurement (--cov) counts no branches: add --cov-branch"
        return self._imports.with_imports(bits, files, asked)

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()
        if self._greenlets:
            self._greenlets = 0
            if not self._contexts_by_test:
                self._switch(self._users_context)

    def _switch(self, context: str | None) -> str | None:
        return self._current.switch_context(context or "")


def read(data: CoverageData, code: CodeMap, pattern: str) -> tuple[Bits, tuple[str, ...]]:
    """The lines and arcs of the code under test under the contexts that match `pattern`, and the files with any."""
    names = [str(file.path) for file in code.files]
    files = FilesOf(data)
    data.set_query_contexts([pattern])
    try:
        lines = {name: files.lines(name) for name in names}
        arcs = {name: files.arcs(name) for name in names} if data.has_arcs() else None
    finally:
        data.set_query_contexts(None)
    return code.translate(lines, arcs), tuple(name for name, executed in lines.items() if executed)


def choose(
    code: CodeMap, *, contexts_by_test: bool, before: tuple[str, ...] = (), imports: ImportCoverage | None = None
) -> Measurement:
    """The measurement that fits the process as it is now: our own, the user's, or none (with the reason).

    Args:
        contexts_by_test: see `JoinedMeasurement`.
        before: functions without arguments, as "package.module:name", that a process calls before it imports the code.
        imports: follow the imports of this process already; None: from now on.
    """
    import coverage

    current = coverage.Coverage.current()
    if code.nothing:
        return NoMeasurement(code.nothing)
    if reason := debugger():
        return NoMeasurement(reason)
    if current is not None and users_tracer() is None:
        return NoMeasurement("the running measurement uses sys.monitoring: set core = 'ctrace' for coverage")
    if imports is None:
        imports = ImportCoverage()
        imports.watch.install()
    own = OwnCoverage([literally(str(file.path)) for file in code.files])
    imports.follow(code, own, before)
    if current is None:
        return OwnMeasurement(code, imports, own)
    return JoinedMeasurement(code, imports, current, contexts_by_test=contexts_by_test)
