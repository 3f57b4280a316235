"""Forked processes: their lines arrive, and those that do not end are ended."""

from __future__ import annotations

import os
import signal
import sys
from collections import deque
from collections.abc import Generator

import pytest

from pytest_hricdv.execution.forks import End, OutputLine, ProcessPool, Send

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


def test_a_child_of_a_process_that_keeps_its_pipe_open_keeps_nobody_waiting() -> None:
    def work(item: str, send: Send) -> None:
        pid = os.fork()
        if pid == 0:
            signal.pause()
        send(str(pid))

    line, end = ProcessPool(work, processes=1, silent_s=LONG_S).run(deque(["leaves"]))
    assert isinstance(line, OutputLine)
    assert end == End("leaves", "")
    os.kill(int(line.text), signal.SIGKILL)
