"""Starts the sessions that are hit while a part of theirs works, and finds all processes that belong to them.

A session is a fork of this process, which has imported what sessions import: that takes most of the time of a short
session. What a session starts itself (workers, processes that run tests) it starts as ever.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import importlib
import os
import select
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn

PR_SET_CHILD_SUBREAPER = 36
"""Of linux/prctl.h."""

_LISTING = """
import contextlib, sys, pytest
with contextlib.redirect_stdout(None), contextlib.suppress(SystemExit):
    pytest.main(sys.argv[1:])
print(*sorted(name for name, module in sys.modules.items() if ".venv" in str(getattr(module, "__file__", ""))
    or name.split(".")[0] == "pytest_hricdv"))
"""


class PartSession:
    """A session that was started here.

    Args:
        arguments: of pytest.
        folder: where it runs.
        variables: its environment.
        log: takes its output.
        forked: it is a fork of this process; else an interpreter of its own.
    """

    def __init__(
        self, arguments: Sequence[str], folder: Path, variables: Mapping[str, str], log: Path, *, forked: bool
    ) -> None:
        self._status: int | None = None
        with log.open("wb") as output:
            if forked:
                sys.stdout.flush()
                self.pid = os.fork()
                if not self.pid:
                    _be_pytest(arguments, folder, variables, output.fileno())
            else:
                self.pid = subprocess.Popen(
                    [sys.executable, "-m", "pytest", *arguments],
                    cwd=folder,
                    env=dict(variables),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                ).pid
        self._ended = os.pidfd_open(self.pid)

    def ends(self, within_s: float) -> bool:
        """Wait until it has ended, but not longer than this; whether it has."""
        if self._status is None and select.select([self._ended], [], [], max(0.0, within_s))[0]:
            self._status = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
            os.close(self._ended)
        return self._status is not None

    @property
    def status(self) -> int:
        """Exit status; minus the number of the signal that ended it; it has ended."""
        assert self._status is not None
        return self._status

    def kill(self) -> None:
        """End whatever is left of it."""
        for pid in descendants():
            sent(pid, signal.SIGKILL)
        self.ends(60.0)


def prepare(arguments: Sequence[str], folder: Path, variables: Mapping[str, str]) -> None:
    """Import what such a session imports, and adopt whatever it leaves behind.

    Args:
        arguments: of pytest.
        folder: where it runs.
        variables: its environment.
    """
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    listed = subprocess.run(
        [sys.executable, "-c", _LISTING, "--collect-only", *arguments],
        cwd=folder,
        env=dict(variables),
        capture_output=True,
        text=True,
        check=True,
    )
    for name in listed.stdout.split():
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def descendants() -> list[int]:
    """All processes that sessions of here have started, themselves or through others; what has ended is reaped."""
    parents = {int(name): _parent(int(name)) for name in os.listdir("/proc") if name.isdigit()}
    own, pids = {os.getpid()}, set[int]()
    while own:
        own = {pid for pid, (parent, _) in parents.items() if parent in own} - pids
        pids |= own
    ended = {pid for pid in pids if parents[pid][1] == "Z"}
    for pid in ended:
        if parents[pid][0] == os.getpid():
            with contextlib.suppress(ChildProcessError):
                os.waitpid(pid, os.WNOHANG)
    return sorted(pids - ended)


def sent(pid: int, number: int) -> bool:
    """Send a signal; whether there was such a process."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)
        return True
    return False


def command_line(pid: int) -> str:
    """Of a process; empty where it has ended."""
    return _read(f"/proc/{pid}/cmdline").replace("\0", " ")


def still_there(within_s: float) -> str:
    """The process that goes on although its session has ended, after this time; empty where all end."""
    until_s = time.monotonic() + within_s
    while True:
        pids = descendants()
        if not pids or time.monotonic() > until_s:
            return f"process {pids[0]} ({command_line(pids[0])[:200]})" if pids else ""
        time.sleep(0.05)  # it only looks again: nobody tells when a process that is no child ends


def _be_pytest(arguments: Sequence[str], folder: Path, variables: Mapping[str, str], output: int) -> NoReturn:
    """Do what `python -m pytest` does with these arguments, to the end of the process."""
    status = 1
    try:
        os.setsid()
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(variables)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(output, 1)
        os.dup2(output, 2)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.argv[:] = ["pytest", *arguments]
        sys.path.insert(0, str(folder))
        import pytest

        status = pytest.console_main()
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 1
    except BaseException:  # as the interpreter does with what nobody takes
        traceback.print_exc()
    finally:
        with contextlib.suppress(BaseException):
            threading._shutdown()  # type: ignore[attr-defined]
            atexit._run_exitfuncs()
            sys.stdout.flush()
        os._exit(int(status))


def _parent(pid: int) -> tuple[int, str]:
    """Parent and state of a process; (0, "") where it has ended."""
    after = _read(f"/proc/{pid}/stat").rpartition(") ")[2].split()
    return (int(after[1]), after[0]) if after else (0, "")


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:  # it has ended
        return ""
