"""Forked processes: their lines arrive, and those that do not end are ended."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Generator

import pytest

from pytest_hricdv.execution.process_pool import End, OutputLine, ProcessPool, Send

LONG_S = 60
"""Longer than anything here takes: a process that is ended after it fails its test."""


def _work(item: str, send: Send) -> None:
    send(f"{item} begins")
    if item == "silent":
        signal.pause()
    if item == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if item == "exits":
        sys.exit(3)
    send(f"{item} {'x' * 100_000}")


@pytest.mark.parametrize(
    ("item", "problem"),
    [
        ("good", ""),
        ("silent", "no sign of life for 0.3 s"),
        ("killed", "ended by SIGKILL"),
        ("exits", "ended with status 1"),
    ],
)
def test_a_process_tells_lines_and_how_it_ended(item: str, problem: str) -> None:
    silent_s = 0.3 if item == "silent" else LONG_S
    *lines, end = ProcessPool(_work, processes=1, silent_s=silent_s).run(deque([item]))
    texts = [line.text.rstrip("x") for line in lines if isinstance(line, OutputLine)]
    assert texts == [f"{item} begins", *([f"{item} "] if item == "good" else [])]
    assert end == End(item, problem)


def test_items_may_be_added_and_removed_while_others_are_worked_on() -> None:
    queue = deque(["a", "b", "c"])
    ended = []
    pool: ProcessPool[str] = ProcessPool(lambda item, send: None, processes=1, silent_s=LONG_S)
    for event in pool.run(queue):
        ended.append(event.item)
        if event.item == "a":
            queue.appendleft("again")
            queue.remove("c")
    assert ended == ["a", "again", "b"]


PAUSED = """
import time
from collections import deque
from pytest_hricdv.execution.process_pool import ProcessPool

def work(item, send):
    for number in range(12):
        send(str(number))
        time.sleep(0.2)  # what is tried: a process that gives a sign of life each 0.2 s

for event in ProcessPool(work, processes=1, silent_s=1.5).run(deque("a")):
    print(event, flush=True)
"""


@pytest.mark.slow
def test_a_pause_of_pool_and_processes_is_no_silence() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PAUSED], stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as pool:
        assert pool.stdout is not None
        lines = [pool.stdout.readline()]
        os.killpg(pool.pid, signal.SIGSTOP)
        with contextlib.suppress(subprocess.TimeoutExpired):
            pool.wait(3.0)  # the pause
        os.killpg(pool.pid, signal.SIGCONT)
        lines += pool.stdout.readlines()
    assert lines == [
        *(f"OutputLine(item='a', text='{number}')\n" for number in range(12)),
        "End(item='a', problem='')\n",
    ]


def test_no_process_outlives_an_abandoned_pool() -> None:
    pids = []

    def tell_pid(item: int, send: Send) -> None:
        send(str(os.getpid()))
        signal.pause()

    events = ProcessPool(tell_pid, processes=2, silent_s=LONG_S).run(deque([1, 2]))
    for _ in range(2):
        event = next(events)
        assert isinstance(event, OutputLine)
        pids.append(int(event.text))
    assert isinstance(events, Generator)
    events.close()
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
