"""Measures the code under test while it runs inside its own greenlet, and nowhere else.

The tracer is started *inside* the greenlet of the code under test. greenlet keeps the tracing state per greenlet, so
the rest of the process (world, human, monitors) runs untraced at full speed, while every line and branch is found.
Where the user measures already (`--cov`), that measurement is joined instead of starting a second one, which would
silently pause the user's.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pytest_hricdv.cover.source import Bits, CodeMap, parse

if TYPE_CHECKING:
    import coverage
    from coverage.sqldata import CoverageData

IMPORT_CONTEXT = "hricdv|import"


class Measurement(Protocol):
    """Measures one test at a time. `reason` says why nothing can be measured; empty when all is well."""

    reason: str

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, measured under `context` when it is run in a greenlet of its own."""

    def take(self, context: str) -> Bits | None:
        """What `context` covered, together with what importing the code covers; None when unmeasured."""


@dataclass
class NoMeasurement:
    """Stands aside, and says why."""

    reason: str

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body` as it is."""
        return body

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None


class OwnMeasurement:
    """A `Coverage` of our own: one for the process, used again for every test."""

    def __init__(self, code: CodeMap) -> None:
        import coverage

        self.reason = ""
        self._reader = Reader(code)
        self._coverage = coverage.Coverage(
            data_file=None,
            config_file=False,
            branch=True,
            include=[str(file.path) for file in code.files],
            concurrency=["greenlet"],
        )
        # Dynamic contexts come back empty from the sys.monitoring core.
        self._coverage.set_option("run:core", "ctrace")
        self.measured(IMPORT_CONTEXT, lambda: import_all(code.packages))()

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def traced() -> None:
            self._coverage.start()
            try:
                self._coverage.switch_context(context)
                body()
            finally:
                self._coverage.stop()

        return traced

    def take(self, context: str) -> Bits | None:
        """See `Measurement`."""
        return self._reader.read(self._coverage.get_data(), (exactly(context), exactly(IMPORT_CONTEXT)))


class JoinedMeasurement:
    """The user's own running `Coverage`, asked for each test's share through contexts.

    Args:
        current: the running measurement.
        contexts_by_test: the user switches contexts himself (`--cov-context=test`), so they are left alone.
    """

    def __init__(self, code: CodeMap, current: coverage.Coverage, *, contexts_by_test: bool) -> None:
        self.reason = ""
        self._reader = Reader(code)
        self._current = current
        self._contexts_by_test = contexts_by_test
        previous = self._switch(IMPORT_CONTEXT)
        import_all(code.packages)
        self._switch(previous)

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def traced() -> None:
            previous = None if self._contexts_by_test else self._switch(context)
            # A new greenlet is untraced; coverage offers the start of its tracer to new threads, and so to us.
            sys.settrace(threading.gettrace())
            try:
                body()
            finally:
                sys.settrace(None)
                if not self._contexts_by_test:
                    self._switch(previous)

        return traced

    def take(self, context: str) -> Bits | None:
        """See `Measurement`."""
        nodeid = context.partition("|")[2]
        patterns = (exactly(context), exactly(f"{nodeid}|run"), exactly(IMPORT_CONTEXT))
        bits = self._reader.read(self._current.get_data(), patterns)
        if bits.statements == 0:
            self.reason = "the running measurement (--cov) does not look at the code under test: add it with --cov=NAME"
            return None
        return bits

    def _switch(self, context: str | None) -> str | None:
        return self._current.switch_context(context or "")


def exactly(context: str) -> str:
    """A pattern for `CoverageData.set_query_contexts`."""
    return f"^{re.escape(context)}$"


def import_all(packages: tuple[str, ...]) -> None:
    """Import every module under test, so that import lines do not land on whichever test runs first."""
    for package in packages:
        module = importlib.import_module(package)
        for found in pkgutil.walk_packages(getattr(module, "__path__", ()), f"{package}."):
            if not found.name.endswith("__main__"):
                importlib.import_module(found.name)


class Reader:
    """Turns measured data into bits; keeps the parsed sources, which are read once for many tests."""

    def __init__(self, code: CodeMap) -> None:
        self._code = code
        self._parsers = {str(file.path): parse(file.path.read_text(encoding="utf-8"), file.path) for file in code.files}

    def read(self, data: CoverageData, patterns: tuple[str, ...]) -> Bits:
        """The lines and arcs of the code under test under the given context patterns."""
        data.set_query_contexts(list(patterns))
        try:
            lines = {name: p.translate_lines(data.lines(name) or ()) for name, p in self._parsers.items()}
            arcs = {name: p.translate_arcs(data.arcs(name) or ()) for name, p in self._parsers.items()}
        finally:
            data.set_query_contexts(None)
        return self._code.bits(lines, arcs if data.has_arcs() else None)


def choose(code: CodeMap, *, contexts_by_test: bool) -> Measurement:
    """The measurement that fits the process as it is now: our own, the user's, or none (with the reason)."""
    import coverage

    current = coverage.Coverage.current()
    if current is not None:
        if threading.gettrace() is None:
            return NoMeasurement("the running measurement uses sys.monitoring: set core = 'ctrace' for coverage")
        return JoinedMeasurement(code, current, contexts_by_test=contexts_by_test)
    if sys.gettrace() is not None:
        return NoMeasurement("a debugger holds the trace function")
    loaded = [name for name in sys.modules if name.partition(".")[0] in code.packages]
    if loaded:
        return NoMeasurement(f"{min(loaded)} was imported before the measurement: import it inside the testbench's run")
    return OwnMeasurement(code)
