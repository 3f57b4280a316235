"""`Progress`: counts tests and draws the terminal's status line; `plugin` registers it in the controlling process."""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.report.formatting import fit_list

if TYPE_CHECKING:
    from pytest_hricdv.execution.hri_case import HriCase

_MINUTE_S, _HOUR_S = 60, 3600

# Index and reverse index make room for a line below: they scroll at the bottom of the screen. Then: save the cursor,
# next line, erase it, text, restore the cursor.
_DRAW = "\x1bD\x1bM\x1b7\x1bE\x1b[2K{}\x1b8"
_ERASE_BELOW = "\x1b[J"

ENOUGH = 2
"""Number of tests that must have ended before the remaining time is estimated."""

PERIOD_S = 1.0
"""Interval (s) at which the line is redrawn while no test begins or ends, as the time left goes down."""


@dataclass(frozen=True)
class Status:
    """The progress of a session.

    Args:
        done: tests that have ended.
        total: selected tests.
        failed: number of those that failed.
        left_s: estimated seconds to the end of the last test; None as long as too few have ended.
        running: ids of the tests that are running.
    """

    done: int
    total: int
    failed: int
    left_s: float | None
    running: tuple[str, ...]

    def text(self, columns: int) -> str:
        """`hri: 37 of 134, 2 failed, about 40 s left: rl-leg1-0f3a9c21 and 1 more`, within a number of columns."""
        return fit_list(self._texts(), columns)

    def _texts(self) -> Iterator[str]:
        """The fullest first: then without one test that runs after the other, the time left, and how many failed."""
        parts = [f"hri: {self.done} of {self.total}"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        if self.left_s is not None and self.done < self.total:
            parts.append(time_left(self.left_s))
        start, shown = ", ".join(parts), [visible(test) for test in self.running]
        for count in range(len(shown), 0, -1):
            more = f" and {len(shown) - count} more" if count < len(shown) else ""
            yield f"{start}: {', '.join(shown[:count])}{more}"
        yield from (", ".join(parts[:count]) for count in range(len(parts), 0, -1))


def time_left(seconds: float) -> str:
    """`about 40 s left`, `about 3 min left`, `about 2 h 10 min left`: rounded, as it is an estimate."""
    if seconds < 10:
        return "a few seconds left"
    if seconds < 1.5 * _MINUTE_S:
        return f"about {round(seconds / 5) * 5} s left"
    minutes = round(seconds / _MINUTE_S)
    if seconds < _HOUR_S:
        return f"about {minutes} min left"
    return f"about {minutes // 60} h {minutes % 60} min left"


class StatusLine:
    """One line below the cursor, where pytest writes next. It has to be erased before anything else is written.

    Args:
        descriptor: the descriptor of the terminal; `close` closes it.
        encoding: the encoding of the terminal.
    """

    def __init__(self, descriptor: int, encoding: str) -> None:
        self._descriptor = descriptor
        self._encoding = encoding

    @classmethod
    def open(cls) -> StatusLine | None:
        """Open it on standard output; None if that is not a terminal, or one without control sequences.

        Call it while pytest does not capture output. The descriptor is a duplicate, so that the line can be drawn while
        the output of a test is captured.
        """
        if os.name != "posix" or os.environ.get("TERM", "dumb") == "dumb" or not sys.stdout.isatty():
            return None
        return cls(os.dup(sys.stdout.fileno()), sys.stdout.encoding)

    def draw(self, text: str) -> None:
        """Show a text in place of the one before; the cursor stays where it is."""
        self._write(_DRAW.format(text))

    def erase(self) -> None:
        """Remove the line."""
        self._write(_ERASE_BELOW)

    def close(self) -> None:
        """Release the terminal."""
        os.close(self._descriptor)

    def _write(self, text: str) -> None:
        os.write(self._descriptor, text.encode(self._encoding, errors="replace"))


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
        with self._hide_line():
            if not self._actions:
                self._began_s = time.monotonic()
                self._actions = {chosen: 1 + len(case.abstract.lines) for chosen, case in self._chosen.items()}
                self._actions_left = sum(self._actions.values())
            self._running[nodeid] = None
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Iterator[None]:
        """A phase of a test ended; of a test whose worker crashed there is no other hook."""
        with self._hide_line():
            if report.failed:
                self._failed.add(report.nodeid)
            if report.when not in ("setup", "call"):
                self._end(report.nodeid)
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logfinish(self, nodeid: str) -> Iterator[None]:
        """A test ended."""
        with self._hide_line():
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
    def _hide_line(self) -> Iterator[None]:
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
    """Whether the options of pytest leave room for a status line; without its terminal there is none."""
    if not config.pluginmanager.hasplugin("terminal"):  # its reporter is registered later than this is asked
        return False
    style, option = config.getini("console_output_style"), config.option
    others = ("collectonly", "usepdb", "trace", "setupshow")
    return (
        config.get_verbosity() >= 0
        and style != "classic"
        and (getattr(option, "capture", "no") != "no" or style == "progress-even-when-capture-no")
        and not any(getattr(option, name, False) for name in others)
    )
