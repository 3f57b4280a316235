"""Progress: counts tests and keeps the status line up to date. Registered in the controlling process."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.session.status_line import Status, StatusLine

if TYPE_CHECKING:
    from pytest_hricdv.case import HriCase

ENOUGH = 2
"""So many tests must have ended before the time left is estimated."""

PERIOD_S = 1.0
"""The line is redrawn so often while no test begins or ends: the time left goes down."""


class Progress:
    """Draws the status line while tests run, on a terminal; off with `-q`, `-s`, `--pdb`, `--trace` and classic output.

    pytest writes to the terminal within the hooks below: the line is erased before and drawn after, under a lock.

    Args:
        chosen: node id -> test, of the session; filled while tests are collected.
    """

    def __init__(self, config: pytest.Config, chosen: Mapping[str, HriCase]) -> None:
        self._config = config
        self._chosen = chosen
        self._line = StatusLine.open() if _is_wanted(config) else None
        self._lock = threading.RLock()
        self._running: dict[str, None] = {}  # a set in the order in which tests began
        self._ended: set[str] = set()
        self._failed: set[str] = set()
        self._actions: dict[str, int] = {}  # of each test, and one more: a test takes as long as its person acts
        self._actions_done = self._actions_left = 0
        self._began_s = self._last_end_s = 0.0  # of the first test: workers take a while to start

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtestloop(self) -> Iterator[None]:
        """Redraws the line every second while tests run."""
        over = threading.Event()
        clock = threading.Thread(target=self._redraw, args=(over,), name="hricdv-progress", daemon=True)
        clock.start()
        try:
            return (yield)
        finally:
            over.set()
            clock.join()
            self._close()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logstart(self, nodeid: str) -> Iterator[None]:
        """A test began, here or in a worker."""
        with self._writing():
            if not self._actions:
                self._began_s = time.monotonic()
                self._actions = {each: 1 + len(case.abstract.lines) for each, case in self._chosen.items()}
                self._actions_left = sum(self._actions.values())
            self._running[nodeid] = None
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Iterator[None]:
        """A phase of a test ended; of a test whose worker crashed there is no other hook."""
        with self._writing():
            if report.failed:
                self._failed.add(report.nodeid)
            if report.when not in ("setup", "call"):
                self._end(report.nodeid)
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logfinish(self, nodeid: str) -> Iterator[None]:
        """A test ended."""
        with self._writing():
            self._end(nodeid)
            return (yield)

    @pytest.hookimpl(optionalhook=True, tryfirst=True)
    def pytest_testnodedown(self) -> None:
        """xdist writes about a worker that crashed."""
        with self._lock:
            self._erase()

    def pytest_enter_pdb(self) -> None:
        """The terminal belongs to the debugger from now on."""
        self._close()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """While pytest may write to the terminal."""
        with self._lock:
            self._erase()
            yield
            if self._line is not None:
                self._config.pluginmanager.getplugin("terminalreporter").flush()
                self._draw()

    def _redraw(self, over: threading.Event) -> None:
        while not over.wait(PERIOD_S):
            with self._lock:
                self._draw()

    def _draw(self) -> None:
        if self._line is not None and self._actions:
            self._line.draw(self._status().text(shutil.get_terminal_size().columns - 1))

    def _erase(self) -> None:
        if self._line is not None:
            self._line.erase()

    def _close(self) -> None:
        with self._lock:
            if self._line is not None:
                self._line.erase()
                self._line.close()
                self._line = None

    def _end(self, nodeid: str) -> None:
        self._running.pop(nodeid, None)
        if nodeid in self._chosen and nodeid not in self._ended:
            self._ended.add(nodeid)
            self._actions_done += self._actions[nodeid]
            self._actions_left -= self._actions[nodeid]
            self._last_end_s = time.monotonic()

    def _status(self) -> Status:
        running = tuple(self._chosen[nodeid].abstract.id for nodeid in self._running if nodeid in self._chosen)
        failed = len(self._failed & self._ended)
        return Status(len(self._ended), len(self._chosen), failed, self._left_s(), running)

    def _left_s(self) -> float | None:
        """Estimated from the mean duration of an action; at least the time of the tests that have not begun."""
        if len(self._ended) < ENOUGH:
            return None
        action_s = (self._last_end_s - self._began_s) / self._actions_done
        waiting = self._actions_left - sum(self._actions.get(nodeid, 0) for nodeid in self._running)
        return max(action_s * self._actions_left - (time.monotonic() - self._last_end_s), action_s * waiting)


def _is_wanted(config: pytest.Config) -> bool:
    """Whether the options of pytest leave room for a status line."""
    style, option = config.getini("console_output_style"), config.option
    others = ("collectonly", "usepdb", "trace", "setupshow")
    return (
        config.get_verbosity() >= 0
        and style != "classic"
        and (option.capture != "no" or style == "progress-even-when-capture-no")
        and not any(getattr(option, name, False) for name in others)
    )
