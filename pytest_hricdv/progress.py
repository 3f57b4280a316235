"""Progress on a terminal: the line below the dots. Registered in the controlling process; elsewhere than on a terminal
it does nothing, so that files and pipes get no control characters."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.report.live import Below, Standing, line

if TYPE_CHECKING:
    from pytest_hricdv.case import HriCase

_ENOUGH = 2  # tests that have to be over before time is guessed from them


class Progress:
    """Counts what is over and what is running, and says so after each event; `-q`, `-s` and `--pdb` switch it off.

    Args:
        chosen: node id -> test, of the session; filled while tests are collected.
    """

    def __init__(self, config: pytest.Config, chosen: Mapping[str, HriCase]) -> None:
        self._config = config
        self._chosen = chosen
        self._reporter: pytest.TerminalReporter | None = None
        self._below: Below | None = None
        self._running: dict[str, None] = {}  # in the order in which they began
        self._over: set[str] = set()
        self._failed: set[str] = set()
        self._began_s = 0.0
        self._done_work = self._whole_work = self._counted = 0  # actions; counted once, as tests may be many

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtestloop(self) -> Iterator[None]:
        """Puts the line below the dots for as long as tests run."""
        self._reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if self._reporter is None or not self._wanted(self._reporter):
            return (yield)
        writer = self._reporter._tw
        before = writer._file
        self._below = Below(before, lambda: min(writer.width_of_current_line, writer.fullwidth - 1))
        writer._file = self._below
        try:
            return (yield)
        finally:
            self._below.clear()
            writer._file, self._below = before, None

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logstart(self, nodeid: str) -> Iterator[None]:
        """With and without xdist: a test began."""
        self._began_s = self._began_s or time.monotonic()  # workers take a while to start: that is no test's time
        self._running[nodeid] = None
        yield
        self._show()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Iterator[None]:
        """A part of a test is over; of one whose worker crashed, this is the last that is heard."""
        if report.failed:
            self._failed.add(report.nodeid)
        if report.when not in ("setup", "call"):
            self._end(report.nodeid)
        yield
        self._show()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logfinish(self, nodeid: str) -> Iterator[None]:
        """A test is over."""
        self._end(nodeid)
        yield
        self._show()

    def pytest_enter_pdb(self) -> None:
        """A debugger wants the terminal for itself."""
        if self._below is not None:
            self._below.clear()
            self._below = None

    def _wanted(self, reporter: pytest.TerminalReporter) -> bool:
        option = self._config.option
        return (
            bool(getattr(reporter, "isatty", False))
            and os.name == "posix"
            and os.environ.get("TERM", "dumb") != "dumb"
            and self._config.get_verbosity() >= 0
            and bool(getattr(reporter, "_show_progress_info", False))  # off with -s, and where the user wants none
            and not (option.collectonly or getattr(option, "usepdb", False) or getattr(option, "trace", False))
        )

    def _end(self, nodeid: str) -> None:
        self._running.pop(nodeid, None)
        if nodeid in self._chosen and nodeid not in self._over:
            self._over.add(nodeid)
            self._done_work += self._work(nodeid)

    def _show(self) -> None:
        if self._below is None or self._reporter is None or not self._chosen:
            return
        writer = self._reporter._tw
        self._below.show(writer.markup(line(self._standing(), writer.fullwidth - 1), light=True))

    def _standing(self) -> Standing:
        running = tuple(self._chosen[nodeid].abstract.id for nodeid in self._running if nodeid in self._chosen)
        failed = len(self._failed & self._over)
        return Standing(len(self._over), len(self._chosen), failed, self._left_s(), running)

    def _left_s(self) -> float | None:
        """From how long the actions took that are over: a test takes as long as its human has things to do."""
        if len(self._over) < _ENOUGH:
            return None
        if self._counted != len(self._chosen):
            self._counted, self._whole_work = len(self._chosen), sum(map(self._work, self._chosen))
        spent_s = time.monotonic() - self._began_s
        return spent_s / self._done_work * (self._whole_work - self._done_work)

    def _work(self, nodeid: str) -> int:
        return 1 + len(self._chosen[nodeid].abstract.lines)
