"""`OwnCoverage`: coverage.py's `Coverage`, limited to selected parts of a process, each recorded under a context.

`Measurement` and `ImportCoverage` record tests and imports with it; `debugger` says why nothing can be measured. The
tracer is set in one greenlet at a time and limited to some files. So the rest of the process (world, human, monitors)
runs untraced at full speed, while every line and branch of these files is recorded.
"""

from __future__ import annotations

import os
import re
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from pytest_hricdv.coverage.greenlet_settrace import keep_to_this_greenlet
from pytest_hricdv.runtime.random_numbers import spare_run

if TYPE_CHECKING:
    from coverage.sqldata import CoverageData

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class OwnCoverage:
    """A measurement of some files, running while the body of `record` does.

    Args:
        include: paths of files, or patterns of coverage.py.
    """

    def __init__(self, include: Sequence[str], omit: Sequence[str] = ()) -> None:
        import coverage

        self._coverage = coverage.Coverage(
            data_file=None,
            config_file=False,
            branch=True,
            include=list(include) or ["no such file"],  # of nothing, coverage would make everything
            omit=list(omit),
            concurrency=["greenlet"],
        )
        # Dynamic contexts come back empty from the sys.monitoring core.
        self._coverage.set_option("run:core", "ctrace")
        # Where warnings are errors, this one would hide why a node failed before its first line.
        self._coverage.set_option("run:disable_warnings", ["no-data-collected"])
        self._taken_over = False
        self._greenlets = 0  # that are recorded now
        self._settled = 0  # times
        self._context = ""
        self._tracer: Any = None

    @contextmanager
    def record(self, context: str) -> Iterator[None]:
        """Record what the body runs in this greenlet.

        It may be entered in several greenlets at once, under the same context; and within itself, under another one.
        """
        if self._greenlets and self._tracer is not None and sys.gettrace() is self._tracer:
            with self._on_switch(context):
                yield
            return
        with keep_to_this_greenlet():
            if self._greenlets:
                sys.settrace(self._tracer)
            else:
                with spare_run():  # the first start in a process draws the name of its data
                    self._coverage.start()
                self._coverage.switch_context(context)
                self._context, self._tracer = context, sys.gettrace()
            self._greenlets += 1
            began = self._settled
            try:
                with self._on_switch(context):
                    yield
            finally:
                if began == self._settled:  # otherwise it was left where it was, and is cleared away now
                    self._taken_over |= not is_coverages(sys.gettrace())
                    self._greenlets -= 1
                    if self._greenlets == 0:
                        self._coverage.stop()

    def settle(self) -> None:
        """Abandon the present recording: its code was left where it is, and will not continue."""
        if self._greenlets:
            self._greenlets, self._settled = 0, self._settled + 1
            self._coverage.stop()

    @contextmanager
    def _on_switch(self, context: str) -> Iterator[None]:
        outer, began = self._context, self._settled
        if outer == context:
            yield
            return
        self._coverage.switch_context(context)
        self._context = context
        try:
            yield
        finally:
            if self._greenlets and began == self._settled:
                self._coverage.switch_context(outer)
                self._context = outer

    def is_running(self, current: object) -> bool:
        """Whether this is the running measurement `current`."""
        return current is self._coverage

    def take_over(self) -> bool:
        """Whether somebody else set his trace function in what was recorded since this was asked last."""
        take_over, self._taken_over = self._taken_over, False
        return take_over

    def data(self) -> CoverageData:
        """All records since the last erasure."""
        return self._coverage.get_data()


def users_tracer() -> Any:
    """The trace function of the user's running measurement, to be set in a greenlet; None if there is none.

    Coverage registers a function that starts a tracer in each new thread, which serves a greenlet as well. With
    `concurrency = greenlet` it has one tracer for all.
    """
    control = sys.modules.get("coverage")
    if control is None or control.Coverage.current() is None:
        return None
    return threading.gettrace() or sys.gettrace()


def is_coverages(tracer: Any) -> bool:
    """Whether a trace function is coverage's: its tracer in C, or a function or method of its package."""
    module = getattr(tracer, "__module__", None) or type(tracer).__module__
    return str(module).partition(".")[0] == "coverage"


def literally(path: str) -> str:
    """A pattern of coverage.py for a path: what it would take for more than a letter stands for any one letter."""
    return re.sub(r"[*?\[\]{}+]", "?", path)


class FilesOf:
    """Lines and arcs of a measurement by the path of a file; with `relative_files` it has relative ones."""

    def __init__(self, data: CoverageData) -> None:
        from coverage.files import relative_directory

        self._data = data
        folder = relative_directory()
        self._names = {os.path.realpath(os.path.join(folder, name)): name for name in data.measured_files()}

    def lines(self, path: str) -> list[int]:
        """The lines of a file that were recorded, in the contexts that are queried."""
        return (self._data.lines(self._names[path]) or []) if path in self._names else []

    def arcs(self, path: str) -> list[tuple[int, int]]:
        """The arcs of a file that were recorded, in the contexts that are queried."""
        return (self._data.arcs(self._names[path]) or []) if path in self._names else []


def exactly(context: str) -> str:
    """A pattern for `CoverageData.set_query_contexts`; a static context of the user's stands before a context."""
    return f"(^|\\|){re.escape(context)}$"


def debugger() -> str:
    """The debugger attached to this process, in words for people; empty without one.

    Python has one trace function a thread. A tracer that sets its own removes the debugger's, so breakpoints would no
    longer stop: measuring gives way to a debugger.

    A trace function counts as a debugger's unless coverage is running, whose own it then may be.
    """
    if _pydevd():
        return "the IDE's debugger (pydevd) is attached"
    tool = _monitor()
    if tool:
        return f"a debugger is attached ({tool})"
    control = sys.modules.get("coverage")
    # The code under test may have replaced its class: then it is not known whether one measures.
    kind = vars(control).get("Coverage") if control is not None else None
    measuring = isinstance(kind, type) and kind.current() is not None  # type: ignore[attr-defined]
    return "a debugger holds the trace function" if sys.gettrace() is not None and not measuring else ""


def _pydevd() -> bool:
    """PyCharm's and VS Code's debugger; its fast mode hooks into the interpreter and sets no trace function at all."""
    if "pydevd" not in sys.modules:
        return False
    constants = sys.modules.get("_pydevd_bundle.pydevd_constants")
    get_debugger = getattr(constants, "get_global_debugger", None)
    return get_debugger is not None and get_debugger() is not None


def _monitor() -> str:
    """The tool that is registered as a debugger with `sys.monitoring` (Python 3.12, PEP 669)."""
    monitoring = getattr(sys, "monitoring", None)
    return str(monitoring.get_tool(monitoring.DEBUGGER_ID) or "") if monitoring is not None else ""
