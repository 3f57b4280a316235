"""A pool of forked processes that write lines; each is ended when silent for too long, all with the session.

Only for a process without threads: a fork has no other thread, and what another one had locked stays locked.

Time-outs count only time in which the pool is polled. A machine sleeps, a job is suspended, a process is stopped
(SIGSTOP) and resumes: other processes, and messages to them, had no usable time meanwhile. Setting a clock has no
effect on it either.
"""

from __future__ import annotations

import os
import selectors
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Generic, NoReturn, TypeVar

from pytest_hricdv.execution.forked import die_with

LOOKS_EACH_S = 0.5
"""Interval (s; chosen) at which a waiting process reads the clock."""

_LONGEST_S = 2 * LOOKS_EACH_S
"""A look that comes later (s; chosen: on a busy machine a look is late, too) ends a pause."""


class AwakeClock:
    """Begins with 0."""

    def __init__(self) -> None:
        self._seen_s = time.monotonic()
        self._now_s = 0.0

    def look(self) -> float:
        """The time during which the clock was polled (s of wall time)."""
        now_s = time.monotonic()
        self._now_s += min(now_s - self._seen_s, _LONGEST_S)
        self._seen_s = now_s
        return self._now_s


KILLED = f"ended by {signal.Signals.SIGKILL.name}" if hasattr(signal, "SIGKILL") else ""
"""How a process ended that somebody else has killed, as a system without memory does."""

MAX_ATTEMPTS = 3
"""Work whose process is killed this many times is at fault itself. Chosen: a system without memory kills what is large
just then, which a repetition need not be."""

T = TypeVar("T")
Send = Callable[[str], None]


@dataclass(frozen=True)
class OutputLine(Generic[T]):
    """A line that the process of an item wrote."""

    item: T
    text: str


@dataclass(frozen=True)
class End(Generic[T]):
    """The process of an item ended; `problem` says why where it did not end by itself."""

    item: T
    problem: str


@dataclass
class _Child(Generic[T]):
    item: T
    pid: int
    silent_since_s: float
    rest: bytes = b""
    problem: str = ""


@dataclass
class ProcessPool(Generic[T]):
    """Works on items, each in a process of its own.

    Args:
        work: works on an item, in its process; what it sends is a line.
        processes: number of processes at a time.
        silent_s: a process that writes nothing for this time (s of wall time, without pauses of this one) is ended.
    """

    work: Callable[[T, Send], None]
    processes: int
    silent_s: float
    _clock: AwakeClock = field(default_factory=AwakeClock, init=False)

    def run(self, queue: deque[T]) -> Iterator[OutputLine[T] | End[T]]:
        """Work until the queue is empty, from left to right; items may be added and removed in the meantime."""
        children: dict[int, _Child[T]] = {}
        parent = os.getppid()
        try:
            while queue or children:
                if os.getppid() != parent:
                    raise SystemExit("what started this process has ended")  # nobody needs the lines
                while queue and len(children) < self.processes:
                    descriptor, child = self._start(queue.popleft())
                    children[descriptor] = child
                yield from self._progress(children)
        finally:
            for descriptor, child in children.items():
                os.kill(child.pid, signal.SIGKILL)
                _wait(child, descriptor)

    def _start(self, item: T) -> tuple[int, _Child[T]]:
        reading, writing = os.pipe()
        parent = os.getpid()
        pid = os.fork()
        if pid == 0:
            die_with(parent)
            os.close(reading)
            self._in_child(item, writing)
        os.close(writing)
        return reading, _Child(item, pid, self._clock.look())

    def _in_child(self, item: T, descriptor: int) -> NoReturn:
        status = 1
        try:
            self.work(item, lambda text: _write(descriptor, f"{text}\n".encode()))
            status = 0
        finally:
            os._exit(status)  # what the parent registered for its own end is not for its children

    def _progress(self, children: dict[int, _Child[T]]) -> Iterator[OutputLine[T] | End[T]]:
        with selectors.DefaultSelector() as selector:
            for descriptor in children:
                selector.register(descriptor, selectors.EVENT_READ)
            ready = [key.fd for key, _ in selector.select(self._patience_s(children))]
        now_s = self._clock.look()
        for descriptor in ready:
            child = children[descriptor]
            data = os.read(descriptor, 1 << 16)
            child.silent_since_s = now_s
            *lines, child.rest = (child.rest + data).split(b"\n")
            yield from (OutputLine(child.item, line.decode()) for line in lines)
            if not data:
                yield End(child.item, _wait(children.pop(descriptor), descriptor))
        for descriptor, child in [*children.items()]:
            if descriptor not in ready and now_s - child.silent_since_s > self.silent_s:
                child.problem = f"no sign of life for {self.silent_s:g} s"
                os.kill(child.pid, signal.SIGKILL)
                yield End(child.item, _wait(children.pop(descriptor), descriptor))

    def _patience_s(self, children: dict[int, _Child[T]]) -> float:
        first_s = min(child.silent_since_s for child in children.values())
        return min(max(0.0, first_s + self.silent_s - self._clock.look()) + 0.01, LOOKS_EACH_S)


def _write(descriptor: int, data: bytes) -> None:
    while data:
        data = data[os.write(descriptor, data) :]


def _wait(child: _Child[T], descriptor: int) -> str:
    """Release an ended process; returns why it ended where it did not by itself."""
    os.close(descriptor)
    _, status = os.waitpid(child.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    if child.problem or code == 0:
        return child.problem
    return f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with status {code}"
