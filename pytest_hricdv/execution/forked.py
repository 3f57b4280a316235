"""A fork of this process that runs one function, sends one message, and ends.

Other threads of this process are not in the fork, and what they had locked stays locked there. So whoever forks a
process with threads, such as a worker of xdist, whose other thread only waits for its controller, does not use in the
fork what those threads use.
"""

from __future__ import annotations

import ctypes
import gc
import os
import select
import signal
import sys
import warnings
from contextlib import suppress
from dataclasses import dataclass
from typing import NoReturn

from pytest_hricdv.runtime.random_numbers import find_names

_HEAD = 8
"""Bytes before a message: its length."""

_PR_SET_PDEATHSIG = 1
"""Option of Linux's prctl (linux/prctl.h): the signal that a process gets when its parent dies."""

_LOOK_AFTER_S = 0.5
"""Interval (s) at which a silent process is checked for being alive: a child of its own may hold its pipe open."""


class ForkError(Exception):
    """The process ended without its message; the text says how."""


class Fork:
    """A process that was forked, as the one sees it that forked it.

    Args:
        pid: of the process.
        reading: where its message comes.
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
        """Send a message, and go on."""
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
    find_names()
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


def die_with(parent: int) -> None:
    """Make a fork end with its parent.

    Otherwise nobody would end an endless run whose session was killed. Only Linux can.
    """
    with suppress(OSError, AttributeError):  # a C library without it
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
            if os.getppid() != parent:
                os._exit(1)
