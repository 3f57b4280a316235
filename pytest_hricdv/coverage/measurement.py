"""Measures the code under test while it runs inside its own greenlet, and nowhere else.

The tracer is started inside the greenlet of the code under test and limited to it. So the rest of the process (world,
human, monitors) runs untraced at full speed, while every line and branch is recorded.
Where the user measures already (`--cov`), that measurement is joined: a second one would silently pause the user's.
"""

from __future__ import annotations

import re
import sys
import threading
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import greenlet

from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError
from pytest_hricdv.coverage.greenlet_settrace import forget_left_greenlets, kept_to_this_greenlet
from pytest_hricdv.coverage.import_coverage import import_bits

if TYPE_CHECKING:
    import coverage
    from coverage.sqldata import CoverageData

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

TAKEN_OVER = "a debugger took the trace function over while the code under test ran"


class Measurement(Protocol):
    """Measures one test at a time, in one greenlet or several."""

    @property
    def reason(self) -> str:
        """Why nothing can be measured; empty where it can."""

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, measured under `context` when it is run in a greenlet of its own."""

    def take(self, context: str) -> Bits | None:
        """What `context` covered, together with what importing the code covers; None when unmeasured."""

    def settle(self) -> None:
        """A run is over: greenlets that are still measured were left where they are, and will not go on."""


@dataclass(frozen=True)
class NoMeasurement:
    """Measures nothing, and says why. A measurement of the user still records all of the code under test."""

    reason: str

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """`body`, with the user's tracer limited to it; otherwise greenlet switches drop covered lines."""
        tracer = users_tracer()

        def traced() -> None:
            with kept_to_this_greenlet():
                sys.settrace(tracer)
                body()

        return body if tracer is None else traced

    def take(self, context: str) -> Bits | None:
        """Nothing."""
        return None

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()


class OwnMeasurement:
    """The plugin's own `Coverage`: one for the process, reused for every test."""

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
        # Where warnings are errors, this one would hide why a node failed before its first line.
        self._coverage.set_option("run:disable_warnings", ["no-data-collected"])
        self._taken_over = False
        self._greenlets = 0  # that are measured now
        self._tracer: Any = None

    def begin(self) -> None:
        """Measure nothing: what coverage does at its first start, forks of this process then need not do again."""
        greenlet.greenlet(self.measured("", lambda: None)).switch()
        self.take("")

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def traced() -> None:
            with kept_to_this_greenlet():
                self._enter(context)
                try:
                    body()
                finally:
                    self._leave()

        return traced

    def _enter(self, context: str) -> None:
        """Trace the current greenlet: the first one starts the measurement, and its tracer serves the others, too."""
        self._greenlets += 1
        if self._greenlets > 1:
            sys.settrace(self._tracer)
            return
        self._coverage.start()
        self._coverage.switch_context(context)
        self._tracer = sys.gettrace()

    def _leave(self) -> None:
        self._taken_over |= not _is_coverages(sys.gettrace())
        self._greenlets -= 1
        if self._greenlets == 0:
            self._coverage.stop()

    def take(self, context: str) -> Bits | None:
        """See `Measurement`. A run that a debugger interrupted is unmeasured: its data would be incomplete."""
        taken_over, self._taken_over = self._taken_over, False
        self.reason = TAKEN_OVER if taken_over else ""
        data = self._coverage.get_data()
        try:
            return None if taken_over else self._imported | read(data, self._code, exactly(context))
        finally:
            data.erase()  # it is not needed again, and the lines of thousands of tests need memory

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()
        if self._greenlets:
            self._greenlets = 0
            self._coverage.stop()


class JoinedMeasurement:
    """The user's running `Coverage`; contexts give the share of each test.

    Args:
        current: the running measurement.
        contexts_by_test: the user's options switch contexts already (`--cov-context=test`), so this does not.
    """

    def __init__(self, code: CodeMap, imported: Bits, current: coverage.Coverage, *, contexts_by_test: bool) -> None:
        self.reason = ""
        self._code = code
        self._imported = imported
        self._current = current
        self._contexts_by_test = contexts_by_test
        self._tracer = users_tracer()
        self._taken_over = False
        self._greenlets = 0  # that are measured now
        self._users_context: str | None = None

    def measured(self, context: str, body: Callable[[], None]) -> Callable[[], None]:
        """See `Measurement`."""

        def traced() -> None:
            self._greenlets += 1
            if self._greenlets == 1 and not self._contexts_by_test:
                self._users_context = self._switch(context)
            with kept_to_this_greenlet():
                sys.settrace(self._tracer)
                try:
                    body()
                finally:
                    self._taken_over |= not _is_coverages(sys.gettrace())
                    self._greenlets -= 1
                    if self._greenlets == 0 and not self._contexts_by_test:
                        self._switch(self._users_context)

        return traced

    def take(self, context: str) -> Bits | None:
        """See `Measurement`."""
        taken_over, self._taken_over = self._taken_over, False
        if taken_over:
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

    def settle(self) -> None:
        """See `Measurement`."""
        forget_left_greenlets()
        if self._greenlets:
            self._greenlets = 0
            if not self._contexts_by_test:
                self._switch(self._users_context)

    def _data(self) -> CoverageData:
        from coverage.exceptions import CoverageWarning

        with warnings.catch_warnings():
            # Coverage repeats its warnings at the end of the session; here there would be one for each test.
            warnings.simplefilter("ignore", CoverageWarning)
            return self._current.get_data()

    def _switch(self, context: str | None) -> str | None:
        return self._current.switch_context(context or "")


def users_tracer() -> Any:
    """The trace function of the user's running measurement, to be set in a greenlet; None if there is none.

    Coverage registers a function that starts a tracer in each new thread, which serves a greenlet as well. With
    `concurrency = greenlet` it has one tracer for all.
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


def choose(code: CodeMap, *, contexts_by_test: bool, before: tuple[str, ...] = ()) -> Measurement:
    """The measurement that fits the process as it is now: our own, the user's, or none (with the reason).

    Args:
        code: what is measured.
        contexts_by_test: see `JoinedMeasurement`.
        before: see `import_bits`.
    """
    import coverage

    current = coverage.Coverage.current()
    if reason := debugger():
        return NoMeasurement(reason)
    if current is not None and users_tracer() is None:
        return NoMeasurement("the running measurement uses sys.monitoring: set core = 'ctrace' for coverage")
    try:
        imported = import_bits(code, before=before)
    except CoverageError as error:
        return NoMeasurement(str(error))
    if current is None:
        return OwnMeasurement(code, imported)
    return JoinedMeasurement(code, imported, current, contexts_by_test=contexts_by_test)


def debugger() -> str:
    """Which debugger is attached to this process now, in words for people; empty where there is none.

    Python has one trace function a thread. A tracer that sets its own removes the debugger's, so breakpoints would no
    longer stop: measuring gives way to a debugger.

    A trace function counts as a debugger's unless coverage is running, whose own it then may be.
    """
    if _pydevd():
        return "the IDE's debugger (pydevd) is attached"
    tool = _monitoring()
    if tool:
        return f"a debugger is attached ({tool})"
    control = sys.modules.get("coverage")
    measuring = control is not None and control.Coverage.current() is not None
    return "a debugger holds the trace function" if sys.gettrace() is not None and not measuring else ""


def _pydevd() -> bool:
    """PyCharm's and VS Code's debugger; its fast mode hooks into the interpreter and sets no trace function at all."""
    if "pydevd" not in sys.modules:
        return False
    constants = sys.modules.get("_pydevd_bundle.pydevd_constants")
    get_debugger = getattr(constants, "get_global_debugger", None)
    return get_debugger is not None and get_debugger() is not None


def _monitoring() -> str:
    """The tool that is registered as a debugger with `sys.monitoring` (Python 3.12, PEP 669)."""
    monitoring = getattr(sys, "monitoring", None)
    return str(monitoring.get_tool(monitoring.DEBUGGER_ID) or "") if monitoring is not None else ""
