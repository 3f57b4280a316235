"""Progress on a terminal: the line below the dots. Registered in the controlling process; elsewhere than on a terminal
it does nothing, so that files and pipes get no control characters."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.report.live import Below, Standing, line, still

if TYPE_CHECKING:
    from pytest_hricdv.case import HriCase

_ENOUGH = 2  # tests that have to be over before time is guessed from them
_EVERY_S = 1.0


class Progress:
    """Counts what is over and what is running, and says so after each event and every second; `-q`, `-s` and `--pdb`
    switch it off.

    pytest writes to the terminal within the hooks below, which hold the lock: the line never gets in between.

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
        self._lock = threading.RLock()
        self._began_s = self._guessed_s = 0.0
        self._left_s: float | None = None  # as guessed when the last test was over
        self._done_work = self._whole_work = self._counted = 0  # actions; counted once, as tests may be many

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtestloop(self) -> Iterator[None]:
        """Puts the line below the dots for as long as tests run."""
        self._reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if self._reporter is None or not self._wanted(self._reporter):
            return (yield)
        writer = self._reporter._tw
        before = writer._file
        # While a test runs, what is written to the terminal's own file is captured: the line has another way there.
        aside = os.fdopen(os.dup(before.fileno()), "w", encoding=before.encoding, errors="replace")
        self._below = below = Below(before, aside, lambda: min(writer.width_of_current_line, writer.fullwidth - 1))
        writer._file = below
        over = threading.Event()
        ticks = threading.Thread(target=self._tick, args=(over,), name="hricdv-progress", daemon=True)
        ticks.start()
        try:
            return (yield)
        finally:
            over.set()
            ticks.join()
            below.clear()
            aside.close()
            writer._file, self._below = before, None

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logstart(self, nodeid: str) -> Iterator[None]:
        """With and without xdist: a test began."""
        with self._lock:
            self._began_s = self._began_s or time.monotonic()  # workers take a while to start: that is no test's time
            self._running[nodeid] = None
            yield
            self._flushed()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Iterator[None]:
        """A part of a test is over; of one whose worker crashed, this is the last that is heard."""
        with self._lock:
            if report.failed:
                self._failed.add(report.nodeid)
            if report.when not in ("setup", "call"):
                self._end(report.nodeid)
            yield
            self._flushed()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logfinish(self, nodeid: str) -> Iterator[None]:
        """A test is over."""
        with self._lock:
            self._end(nodeid)
            yield
            self._flushed()

    def pytest_enter_pdb(self) -> None:
        """A debugger wants the terminal for itself."""
        with self._lock:
            if self._below is not None:
                self._below.clear()
                self._below = None

    def _tick(self, over: threading.Event) -> None:
        """Time goes on during a long test, too."""
        while not over.wait(_EVERY_S):
            with self._lock:
                self._show()

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
            self._guess()

    def _flushed(self) -> None:
        if self._below is not None:
            self._below.flush()
        self._show()

    def _show(self) -> None:
        if self._below is None or self._reporter is None or not self._chosen:
            return
        writer = self._reporter._tw
        self._below.show(writer.markup(line(self._standing(), writer.fullwidth - 1), light=True))

    def _standing(self) -> Standing:
        running = tuple(self._chosen[nodeid].abstract.id for nodeid in self._running if nodeid in self._chosen)
        failed = len(self._failed & self._over)
        left_s = None if self._left_s is None else still(self._left_s, self._waiting_s(), self._passed_s())
        return Standing(len(self._over), len(self._chosen), failed, left_s, running)

    def _guess(self) -> None:
        """From how long the actions took that are over: a test takes as long as its human has things to do."""
        if len(self._over) < _ENOUGH:
            return
        if self._counted != len(self._chosen):
            self._counted, self._whole_work = len(self._chosen), sum(map(self._work, self._chosen))
        self._guessed_s = time.monotonic()
        self._left_s = self._pace_s() * (self._whole_work - self._done_work)

    def _pace_s(self) -> float:
        return (self._guessed_s - self._began_s) / self._done_work

    def _passed_s(self) -> float:
        return time.monotonic() - self._guessed_s

    def _waiting_s(self) -> float:
        """How long those will take that have not begun."""
        begun = sum(self._work(nodeid) for nodeid in self._running if nodeid in self._chosen)
        return self._pace_s() * (self._whole_work - self._done_work - begun)

    def _work(self, nodeid: str) -> int:
        return 1 + len(self._chosen[nodeid].abstract.lines)
