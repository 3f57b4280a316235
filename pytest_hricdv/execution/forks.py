"""Runs work in forks of this process, where it cannot change the state of the session.

`call_in_fork` calls one function, as for a film or an experiment of the diagnosis. `fork` returns a `Fork` or, in the
fork, an `InFork`, which sends it messages, as for the audit. `ProcessPool` works on items in parallel, as for mutants.

A fork has only the thread that forked; what other threads had locked stays locked there. So a process with threads,
such as a worker of xdist, must not use in a fork what its threads use. The pool is only for processes without threads.

The time-out of the pool does not count time in which this process was stopped (a machine that sleeps, a suspended job,
SIGSTOP), since its children were then probably stopped, too. Setting the system's clock has no effect.
"""

from __future__ import annotations

import ctypes
import gc
import os
import select
import selectors
import signal
import sys
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, field
from typing import Generic, NoReturn, TypeVar

_HEAD = 8
"""Size (bytes) of the length in front of a message."""

_PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl (linux/prctl.h): the signal that a process gets when its parent dies."""

_LOOK_AFTER_S = 0.5
"""Interval (s) of checks that a silent process is alive: its pipe may be held open by a child of its own."""


class ForkError(Exception):
    """The fork ended without sending its message; the error says how."""


class Fork:
    """A forked process, as seen by the one that forked it.

    Args:
        reading: the end of the pipe from which its message is read.
    """

    def __init__(self, pid: int, reading: int) -> None:
        self.pid = pid
        self._reading = reading
        self._status: int | None = None

    def message(self) -> bytes:
        """Wait for its message.

        Raises:
            ForkError: it ended without one.
        """
        head = self._read(_HEAD)
        return self._read(int.from_bytes(head, "big"))

    def _read(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            if self._has_data(_LOOK_AFTER_S):
                part = os.read(self._reading, min(size - len(data), 1 << 20))
                if not part:
                    raise ForkError(self._how_it_ended())
                data += part
            elif self._has_ended() and not self._has_data(0.0):
                raise ForkError(self._how_it_ended())
        return data

    def _has_data(self, patience_s: float) -> bool:
        return bool(select.select([self._reading], [], [], patience_s)[0])

    def _has_ended(self) -> bool:
        if self._status is None:
            try:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
            except ChildProcessError:  # somebody ignores SIGCHLD: the system has waited for it
                pid, status = self.pid, 0
            self._status = status if pid else None
        return self._status is not None

    def _how_it_ended(self) -> str:
        if self._status is None:
            try:
                _, self._status = os.waitpid(self.pid, 0)
            except ChildProcessError:  # as above
                self._status = 0
        code = os.waitstatus_to_exitcode(self._status)
        return f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with status {code}"

    def close(self) -> None:
        """End it, where it has not ended."""
        os.close(self._reading)
        if not self._has_ended():
            os.kill(self.pid, signal.SIGKILL)
            self._how_it_ended()


@dataclass(frozen=True)
class InFork:
    """The forked process, as it sees itself; `writing` is where its messages go."""

    writing: int

    def send(self, message: bytes) -> None:
        """Send a message, and continue."""
        data = len(message).to_bytes(_HEAD, "big") + message
        while data:
            data = data[os.write(self.writing, data) :]

    def send_and_end(self, message: bytes) -> NoReturn:
        """Send the message, and end: what the other process is to do at its own end is not done here."""
        try:
            for stream in (sys.stdout, sys.stderr):
                with suppress(Exception):  # they may be whatever a test has made of them
                    stream.flush()
            self.send(message)
        finally:
            os._exit(0)


def fork() -> Fork | InFork:
    """Fork this process: the one gets a `Fork`, the other, with the main thread only, an `InFork`."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # what waits in them would be written by both
            stream.flush()
    reading, writing = os.pipe()
    parent = os.getpid()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # from Python 3.12 on, where there are threads: see above
        pid = os.fork()
    if pid:
        os.close(writing)
        return Fork(pid, reading)
    os.close(reading)
    die_with(parent)
    gc.freeze()  # looking through what was there before would copy all of it, page by page
    return InFork(writing)


def call_in_fork(
    work: Callable[[], bytes], let_through: Callable[[], AbstractContextManager[None]] = nullcontext
) -> bytes:
    """What a function returns, called in a fork; `null` if it raises there.

    Args:
        work: the function.
        let_through: while the fork is waited for, a signal may raise.

    Raises:
        ForkError: the process ended without it.
    """
    process = fork()
    if isinstance(process, InFork):
        message = b"null"
        with suppress(BaseException):  # whatever it is: what stands above is for the process that was forked
            message = work()
        process.send_and_end(message)
    try:
        with let_through():
            return process.message()
    finally:
        process.close()


def die_with(parent: int) -> None:
    """Make a fork end with its parent.

    Otherwise nobody would end an endless run whose session was killed. Only Linux can.
    """
    with suppress(OSError, AttributeError):  # a C library without it
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
            if os.getppid() != parent:
                os._exit(1)


LOOKS_EACH_S = 0.5
"""Interval (s; chosen) at which a waiting process reads the clock."""

_LONGEST_S = 2 * LOOKS_EACH_S
"""A look that comes later (s; chosen: on a busy machine a look is late, too) ends a pause."""


class AwakeClock:
    """Counts the time (s) during which this process was awake, from 0."""

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
            if descriptor in ready:
                continue
            if now_s - child.silent_since_s > self.silent_s:
                child.problem = f"no sign of life for {self.silent_s:g} s"
                os.kill(child.pid, signal.SIGKILL)
            elif not _has_ended(child.pid) or select.select([descriptor], [], [], 0.0)[0]:
                continue
            yield End(child.item, _wait(children.pop(descriptor), descriptor))

    def _patience_s(self, children: dict[int, _Child[T]]) -> float:
        first_s = min(child.silent_since_s for child in children.values())
        return min(max(0.0, first_s + self.silent_s - self._clock.look()) + 0.01, LOOKS_EACH_S)


def _has_ended(pid: int) -> bool:
    """Whether a child has ended, whose own children may hold its pipe open; False where nobody can look."""
    if not hasattr(os, "waitid"):  # macOS before Python 3.13
        return False
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


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
