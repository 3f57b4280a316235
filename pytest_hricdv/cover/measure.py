"""Measures the code under test while it runs inside its own greenlet, and nowhere else.

The tracer is started inside the greenlet of the code under test and kept to it, so the rest of the process (world,
human, monitors) runs untraced at full speed, while every line and branch is found.
Where the user measures already (`--cov`), that measurement is joined instead of starting a second one, which would
silently pause the user's.
"""

from __future__ import annotations

import re
import sys
import threading
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from pytest_hricdv.cover.debugger import debugger
from pytest_hricdv.cover.imports import import_bits
from pytest_hricdv.cover.source import Bits, CodeMap, CoverError
from pytest_hricdv.cover.tracing import kept_to_this_greenlet

if TYPE_CHECKING:
    import coverage
    from coverage.sqldata import CoverageData

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

TAKEN_OVER = "a debugger took the trace function over while the code under test ran"


class Measurement(Protocol):
    """Measures one test at a time. `reason` says why nothing can be measured; empty when all is well."""

    reason: str

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, measured under `context` when it is run in a greenlet of its own."""

    def take(self, context: str) -> Bits | None:
        """What `context` covered, together with what importing the code covers; None when unmeasured."""


@dataclass
class NoMeasurement:
    """Stands aside, and says why. A measurement of the user's own still sees all of the code under test."""

    reason: str

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, with the user's tracer kept to it if he measures: else switching greenlets loses him lines."""
        tracer = users_tracer()

        def traced() -> None:
            with kept_to_this_greenlet():
                sys.settrace(tracer)
                body()

        return body if tracer is None else traced

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None


class OwnMeasurement:
    """A `Coverage` of our own: one for the process, used again for every test."""

    def __init__(self, code: CodeMap, imported: Bits) -> None:
        import coverage

        self.reason = ""
        self._code = code
        self._imported = imported
        self._coverage = coverage.Coverage(
            data_file=None,
            config_file=False,
            branch=True,
            include=[str(file.path) for file in code.files],
            concurrency=["greenlet"],
        )
        # Dynamic contexts come back empty from the sys.monitoring core.
        self._coverage.set_option("run:core", "ctrace")
        self._taken_over = False

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""
        self._taken_over = False

        def traced() -> None:
            with kept_to_this_greenlet():
                self._coverage.start()
                try:
                    self._coverage.switch_context(context)
                    body()
                finally:
                    self._taken_over |= not _is_coverages(sys.gettrace())
                    self._coverage.stop()

        return traced

    def take(self, context: str) -> Bits | None:
        """See `Measurement`. Half a measurement is none: of a run that a debugger was in, nothing is taken."""
        self.reason = TAKEN_OVER if self._taken_over else ""
        data = self._coverage.get_data()
        try:
            return None if self._taken_over else self._imported | read(data, self._code, exactly(context))
        finally:
            data.erase()  # what was taken is not asked for again, and thousands of tests' lines need memory


class JoinedMeasurement:
    """The user's own running `Coverage`, asked for each test's share through contexts.

    Args:
        current: the running measurement.
        contexts_by_test: the user switches contexts himself (`--cov-context=test`), so they are left alone.
    """

    def __init__(self, code: CodeMap, imported: Bits, current: coverage.Coverage, *, contexts_by_test: bool) -> None:
        self.reason = ""
        self._code = code
        self._imported = imported
        self._current = current
        self._contexts_by_test = contexts_by_test
        self._tracer = users_tracer()
        self._taken_over = False

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""
        self._taken_over = False

        def traced() -> None:
            previous = None if self._contexts_by_test else self._switch(context)
            with kept_to_this_greenlet():
                sys.settrace(self._tracer)
                try:
                    body()
                finally:
                    self._taken_over |= not _is_coverages(sys.gettrace())
                    if not self._contexts_by_test:
                        self._switch(previous)

        return traced

    def take(self, context: str) -> Bits | None:
        """See `Measurement`."""
        if self._taken_over:
            self.reason = TAKEN_OVER
            return None
        nodeid = context.partition("|")[2]
        pattern = f"{exactly(context)}|{exactly(nodeid + '|run')}"
        bits = read(self._data(), self._code, pattern)
        if bits.statements == 0:
            remedy = " ".join(f"--cov={package}" for package in self._code.packages)
            self.reason = f"the running measurement (--cov) does not look at the code under test: add {remedy}"
            return None
        if bits.branches is None:
            self.reason = "the running measurement (--cov) counts no branches: add --cov-branch"
        return self._imported | bits

    def _data(self) -> CoverageData:
        from coverage.exceptions import CoverageWarning

        with warnings.catch_warnings():
            # What it says of the user's settings it says at the end of the session; here it would be once a test.
            warnings.simplefilter("ignore", CoverageWarning)
            return self._current.get_data()

    def _switch(self, context: str | None) -> str | None:
        return self._current.switch_context(context or "")


def users_tracer() -> Any:
    """The trace function of the user's running measurement, to be set in a greenlet; None if there is none.

    Coverage offers the start of a tracer to each new thread, and so to us. Told that there are greenlets and no
    threads (`concurrency = greenlet`), it has one tracer for all.
    """
    control = sys.modules.get("coverage")
    if control is None or control.Coverage.current() is None:
        return None
    return threading.gettrace() or sys.gettrace()


def _is_coverages(tracer: Any) -> bool:
    """Whether a trace function is coverage's: its tracer in C, or a function or method of its package."""
    module = getattr(tracer, "__module__", None) or type(tracer).__module__
    return str(module).partition(".")[0] == "coverage"


def exactly(context: str) -> str:
    """A pattern for `CoverageData.set_query_contexts`."""
    return f"^{re.escape(context)}$"


def read(data: CoverageData, code: CodeMap, pattern: str) -> Bits:
    """The lines and arcs of the code under test under the contexts that match `pattern`."""
    names = [str(file.path) for file in code.files]
    data.set_query_contexts([pattern])
    try:
        lines = {name: data.lines(name) or () for name in names}
        arcs = {name: data.arcs(name) or () for name in names} if data.has_arcs() else None
    finally:
        data.set_query_contexts(None)
    return code.translated(lines, arcs)


def choose(code: CodeMap, *, contexts_by_test: bool) -> Measurement:
    """The measurement that fits the process as it is now: our own, the user's, or none (with the reason)."""
    import coverage

    current = coverage.Coverage.current()
    if reason := debugger():
        return NoMeasurement(reason)
    if current is not None and users_tracer() is None:
        return NoMeasurement("the running measurement uses sys.monitoring: set core = 'ctrace' for coverage")
    try:
        imported = import_bits(code)
    except CoverError as error:
        return NoMeasurement(str(error))
    if current is None:
        return OwnMeasurement(code, imported)
    return JoinedMeasurement(code, imported, current, contexts_by_test=contexts_by_test)
