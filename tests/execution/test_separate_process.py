"""A process beside this one: its lines, and how it is noticed that it was lost."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from pytest_hricdv.execution.separate_process import LostError, ProcessError, SeparateProcess

LONG_S = 60.0
"""Longer than anything here takes."""

pytestmark = pytest.mark.skipif(not hasattr(os, "waitid"), reason="this system cannot wait for a pipe")


@contextmanager
def running(program: str) -> Iterator[SeparateProcess]:
    """A process with this program of Python."""
    command = [sys.executable, "-I", "-S", "-c", program]
    with tempfile.TemporaryFile("w+", encoding="utf-8") as errors:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": errors}
        with subprocess.Popen(command, **pipes, start_new_session=True) as process:  # type: ignore[call-overload]
            made = SeparateProcess(process, errors)
            try:
                yield made
            finally:
                made.kill()


def test_lines_that_follow_an_answer_are_those_of_the_next_one() -> None:
    with running(r"print('a\nb\n\nc\n', flush=True); print('d' * 200_000); input()") as process:
        assert [*process.answer()] == [b"a\n", b"b\n"]
        assert [*process.answer()] == [b"c\n"]
        process.send(b"")
        assert [*process.lines()] == [b"d" * 200_000 + b"\n"]


@pytest.mark.parametrize(
    ("program", "kind", "text"),
    [
        ("import os; os.kill(os.getpid(), 9)", LostError, "ended by SIGKILL"),
        ("raise SystemExit(3)", ProcessError, "it ended with status 3"),
        ("raise SystemExit('ERROR: no testbench')", ProcessError, "ERROR: no testbench"),
        ("pass", ProcessError, "it ended before its work was done"),
    ],
)
def test_how_it_ended_is_told(program: str, kind: type[ProcessError], text: str) -> None:
    with running(f"print('begun', flush=True); {program}") as process, pytest.raises(ProcessError) as error:
        list(process.answer())
    assert (type(error.value), str(error.value)) == (kind, text)


def test_that_it_was_killed_is_noticed_though_what_it_started_holds_its_pipe_open() -> None:
    forks = "import os, signal; pid = os.fork(); pid or signal.pause(); print(pid, flush=True); os.kill(os.getpid(), 9)"
    with running(forks) as process:
        lines = process.lines()
        orphan = int(next(lines))
        with pytest.raises(LostError):
            next(lines)
    until_s = time.monotonic() + LONG_S
    while _runs(orphan):  # what it has started is ended, too: the system may take a moment for that
        assert time.monotonic() < until_s
        os.sched_yield()


def _runs(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as stat:
            return stat.read().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


def test_one_that_was_stopped_and_is_silent_is_lost() -> None:
    with running("import os, signal; print(1, flush=True); os.kill(os.getpid(), signal.SIGSTOP)") as process:
        lines = process.lines(0.6)
        assert next(lines) == b"1\n"
        with pytest.raises(LostError, match=r"no sign of life for 0\.6 s"):
            next(lines)
