"""`EarlyEnd`: ends a session early on SIGTERM or Ctrl-C, also while its suites are still being generated.

`plugin` registers it in the controlling process. It creates the session's `Signals`, and tells them how to hurry and
how to end without pytest.
"""

from __future__ import annotations

import _thread
import atexit
import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest

from pytest_hricdv._base.command_line import UnreadStream
from pytest_hricdv.runtime.redirection import original, redirect
from pytest_hricdv.session.aggregation import Aggregation
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.signals import REBUILT_WITHIN_S, WORKERS_END_WITHIN_S, Signals


class EarlyEnd:
    """Handles signals from the start of a session on, and shortens what would take longer than SIGTERM allows."""

    def __init__(self, context: RunContext, aggregation: Aggregation) -> None:
        self._config = context.collection.config
        self._context = context
        self._aggregation = aggregation
        self._signals = context.signals = Signals(self._hurry, self._end_without)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_sessionstart(self) -> Iterator[None]:
        """Begins before all other hooks: a feature that generates a suite may take long."""
        self._signals.begin()
        if self._config.pluginmanager.hasplugin("terminalreporter"):
            writer = self._config.get_terminal_writer()
            writer._file = UnreadStream(writer._file)
        return (yield)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Keeps the status of the session from what code under test does when Python ends."""
        atexit.register(_keep_status, int(exitstatus), os.getpid())

    @pytest.hookimpl(tryfirst=True)
    def pytest_keyboard_interrupt(self) -> None:
        """End the session, once: nothing is running that a signal could interrupt."""
        self._signals.let_go()

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_setupnodes(self, specs: list[object]) -> None:
        """A hook of xdist: a session that is about to end starts no workers."""
        if self._signals.pending or self._signals.terminated:
            specs.clear()

    def pytest_unconfigure(self) -> None:
        """Restores the previous handlers, however the session ended."""
        self._signals.end()

    def _hurry(self) -> None:
        """Give workers no time to finish their tests after SIGTERM; by default, xdist waits up to 10 s."""
        scheduling = self._config.pluginmanager.get_plugin("dsession")
        manager = getattr(scheduling, "nodemanager", None)
        if manager is not None:
            manager.EXIT_TIMEOUT = WORKERS_END_WITHIN_S

    def _end_without(self) -> None:
        """Ends the process while code that ignores the signal runs, with a report made from the journal.

        Another process makes the report: the main thread may hold any lock, for example that of an import.
        """
        try:
            folder = self._context.options.report
            self._aggregation.journaling.abandon()
            self._context.collection.say("")
            self._context.collection.say(
                "hricdv: SIGTERM: the running code does not stop; the report is made without it"
            )
            making = [sys.executable, "-m", "pytest_hricdv.report", "rebuild", str(folder)]
            subprocess.run(making, stdin=subprocess.DEVNULL, capture_output=True, timeout=REBUILT_WITHIN_S, check=False)
        except subprocess.TimeoutExpired:
            pass
        finally:  # also where something of this raises: the code that does not stop may have replaced it
            _EXIT(pytest.ExitCode.INTERRUPTED)


_KEPT, _EXIT = os._exit, original(os._exit)

AT_EXIT_WITHIN_S = 30.0
"""Time limit for functions registered with `atexit` (s, chosen): all results are out, and a service would wait."""


def _keep_status(ours: int, pid: int) -> None:
    """Make `os._exit(0)` no success of a failed session; called first when Python ends."""
    if os.getpid() == pid:
        redirect(_KEPT, lambda status: _EXIT(status or ours))  # the code may have registered it, and not only call it
        with contextlib.suppress(RuntimeError):  # it is too late for a thread
            _thread.start_new_thread(_end_unfinished, (ours,))


def _end_unfinished(ours: int) -> None:
    waiting = _thread.allocate_lock()
    waiting.acquire()
    waiting.acquire(timeout=AT_EXIT_WITHIN_S)
    said = f"hricdv: functions registered with atexit take more than {AT_EXIT_WITHIN_S:g} s: Python exits without them"
    for stream, text in ((sys.stdout, ""), (sys.stderr, f"{said}\n")):
        with contextlib.suppress(Exception):  # it may be closed, or anything
            stream.write(text)
            stream.flush()
    _EXIT(ours)
