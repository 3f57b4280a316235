"""`SeparateProcess`: a subprocess that receives lines and answers in lines.

`start_process` starts one, for mutants, audits, closing loops, workers of a cluster and others. It does not fork:
forking is unsafe with threads, which processes of xdist and of a cluster have, and code under test that is to be
mutated must not have been imported yet. The child side is `session.child_process`.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import IO

import msgspec

from pytest_hricdv._base.hash_seed import environment_of_child
from pytest_hricdv.execution.forks import LOOKS_EACH_S, AwakeClock

_MOST_BYTES = 1 << 16
"""Number of bytes read at a time: the capacity of a Linux pipe (pipe(7))."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Numerical libraries start threads, which do not survive a fork, unless these variables are 1."""


LetThrough = Callable[[], AbstractContextManager[None]]
"""Returns a context manager within which a signal such as Ctrl-C may raise an exception."""

_EXECUTABLE = sys.executable
"""Saved on import: the code under test may change it."""

_HAS_WAITID = hasattr(os, "waitid")
"""False on Windows, where waiting for a pipe with a time-out is impossible, too."""


class ProcessError(Exception):
    """The process failed; the text is the last line of its output, or how it ended."""


class LostError(ProcessError):
    """The process was killed by a signal, for instance for lack of memory: a new one may succeed."""


class SilentError(LostError):
    """The process was ended because it was silent for too long."""


class SeparateProcess:
    """A subprocess, as its parent sees it.

    Args:
        process: started, with pipes.
        errors: what it writes to its standard error.
        let_through: while it is waited for, a signal may raise; what it has written by then is not lost.
    """

    def __init__(
        self, process: subprocess.Popen[bytes], errors: IO[str], let_through: LetThrough = nullcontext
    ) -> None:
        self._process = process
        self._errors = errors
        self._let_through = let_through
        self._whole: deque[bytes] = deque()
        """Lines that were read but not returned yet."""
        self._begun: list[bytes] = []
        """The parts of an incomplete line."""

    def send(self, message: object) -> None:
        """Send a line: a message, which is encoded as JSON, or the bytes of one."""
        assert self._process.stdin is not None, "it is a pipe"
        line = message if isinstance(message, bytes) else msgspec.json.encode(message)
        with suppress(BrokenPipeError), self._let_through():  # how it ended says more
            self._process.stdin.write(line + b"\n")
            self._process.stdin.flush()

    def lines(self, silent_s: float | None = None) -> Iterator[bytes]:
        """The lines that it writes, up to its end.

        Args:
            silent_s: after so long without a line (s of wall time) it is ended; None: never.

        Raises:
            ProcessError: it failed.
            LostError: it was ended by a signal.
            SilentError: it was ended for its silence.
        """
        while self._whole or (data := self._read(silent_s)):
            if self._whole:
                yield self._whole.popleft()
                continue
            *whole, rest = data.split(b"\n")
            for line in whole:
                self._whole.append(b"".join((*self._begun, line, b"\n")))
                self._begun.clear()
            self._begun.append(rest)
        self._end_all()
        if self._process.returncode != 0:
            raise (LostError if self._process.returncode < 0 else ProcessError)(self._failure())

    def answer(self, silent_s: float | None = None) -> Iterator[bytes]:
        """The lines that it writes up to an empty one, which ends its answer to a message.

        Args:
            silent_s: see `lines`.

        Raises:
            ProcessError: it ended before.
            LostError: it was ended by a signal.
            SilentError: it was ended for its silence.
        """
        for line in self.lines(silent_s):
            if line == b"\n":
                return
            yield line
        raise ProcessError("it ended before its work was done")

    def _read(self, silent_s: float | None) -> bytes:
        """Read what is available; nothing at its end, even if a child of it survives and keeps the pipe open."""
        assert self._process.stdout is not None, "it is a pipe"
        descriptor = self._process.stdout.fileno()
        if not _HAS_WAITID:
            with self._let_through():
                return os.read(descriptor, _MOST_BYTES)
        clock = AwakeClock()
        while not self._is_readable(descriptor, LOOKS_EACH_S):
            if self._has_ended():
                return os.read(descriptor, _MOST_BYTES) if self._is_readable(descriptor, 0.0) else b""
            if silent_s is not None and clock.look() > silent_s:
                self.kill()
                raise SilentError(f"no sign of life for {silent_s:g} s")
        return os.read(descriptor, _MOST_BYTES)

    def _is_readable(self, descriptor: int, within_s: float) -> bool:
        with self._let_through():
            return bool(select.select([descriptor], [], [], within_s)[0])

    def _has_ended(self) -> bool:
        """It stays a zombie meanwhile, so that no other process can have its number."""
        if self._process.returncode is not None:
            return True
        try:
            return os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:  # somebody ignores SIGCHLD: the system has waited for it
            return True

    def _end_all(self) -> None:
        """Wait for its end, and end its children."""
        if self._process.returncode is None and _HAS_WAITID:
            with suppress(ChildProcessError):  # as above
                os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOWAIT)
            self.kill()
        self._process.wait()

    def kill(self) -> None:
        """Kill it and its children."""
        if self._process.returncode is not None:
            return
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
        else:
            self._process.kill()  # on Windows it starts none

    def _failure(self) -> str:
        self._errors.seek(0)
        lines = self._errors.read().strip().splitlines()
        said = [line for line in lines if line.startswith("ERROR: ")] or lines[-1:]
        status = self._process.returncode
        ended = f"ended by {signal.Signals(-status).name}" if status < 0 else f"it ended with status {status}"
        return "".join(said[:1]) or ended


@contextmanager
def start_process(
    module: str,
    directory: Path,
    variables: Mapping[str, str] | None = None,
    path: tuple[str, ...] | None = None,
    hash_seed: str | None = None,
    inherited: Mapping[str, str] | None = None,
    let_through: LetThrough = nullcontext,
) -> Iterator[SeparateProcess]:
    """Start a module in a process in this directory; in the end, it and what it started are ended.

    Args:
        variables: the variables of its environment, besides those of this process.
        path: where modules are found; None: as in this process.
        hash_seed: decimal digits; None: as all that this process starts (see `pytest_hricdv._base.hash_seed`).
        inherited: the variables that it has in place of those of this process, and of `ONE_THREAD`.
        let_through: see `SeparateProcess`.
    """
    further = ({} if inherited is not None else dict.fromkeys(ONE_THREAD, "1")) | dict(variables or {})
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors:
        process = subprocess.Popen(
            [_EXECUTABLE, "-P", "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment_of_child(further, path=path, hash_seed=hash_seed, inherited=inherited),
            cwd=directory,
            start_new_session=True,  # Ctrl-C is for the session, which then ends all of these processes
        )
        assert process.stdin is not None, "it is a pipe"
        assert process.stdout is not None, "it is a pipe"
        running = SeparateProcess(process, errors, let_through)
        try:
            yield running
        finally:
            running.kill()
            process.wait()
            process.stdout.close()
            with suppress(BrokenPipeError):
                process.stdin.close()
