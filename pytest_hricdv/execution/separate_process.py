"""A process beside this one, to which lines are sent and which answers in lines: how it is started, and how it ends.

A fresh process, because a fork needs that there are no threads, which xdist's and a cluster's processes have, and
because code under test that is to be changed must not have been imported. What it does itself is in `session.serving`.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

import msgspec

from pytest_hricdv._base.hash_seed import environment_of_child

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Libraries for numbers start threads of their own, which a fork would not have, unless these variables say 1."""


class ProcessError(Exception):
    """The process failed; the text is the last line that it wrote about it, or how it ended."""


class SeparateProcess:
    """The process, as the one sees it that started it.

    Args:
        process: started, with pipes.
        errors: what it writes to its standard error.
    """

    def __init__(self, process: subprocess.Popen[bytes], errors: IO[str]) -> None:
        self._process = process
        self._errors = errors

    def send(self, message: object) -> None:
        """Send a line: a message, which is encoded as JSON, or the bytes of one."""
        assert self._process.stdin is not None, "it is a pipe"
        line = message if isinstance(message, bytes) else msgspec.json.encode(message)
        with suppress(BrokenPipeError):  # how it ended says more
            self._process.stdin.write(line + b"\n")
            self._process.stdin.flush()

    def lines(self) -> Iterator[bytes]:
        """The lines that it writes, up to its end.

        Raises:
            ProcessError: it failed.
        """
        assert self._process.stdout is not None, "it is a pipe"
        for line in self._process.stdout:  # noqa: UP028  a generator that is left in `yield from` closes the pipe
            yield line
        if self._process.wait() != 0:
            raise ProcessError(self._failure())

    def answer(self) -> Iterator[bytes]:
        """The lines that it writes up to an empty one, which ends its answer to a message.

        Raises:
            ProcessError: it ended before.
        """
        for line in self.lines():
            if line == b"\n":
                return
            yield line
        raise ProcessError("it ended before its work was done")

    def kill(self) -> None:
        """End it at once, with the processes that it has started."""
        if self._process.poll() is not None:
            return
        if hasattr(os, "killpg"):
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
def started(
    module: str,
    directory: Path,
    variables: Mapping[str, str] | None = None,
    path: tuple[str, ...] | None = None,
    hash_seed: str | None = None,
    inherited: Mapping[str, str] | None = None,
) -> Iterator[SeparateProcess]:
    """Start a module in a process in this directory; in the end, it and what it started are ended.

    Args:
        module: its name.
        variables: of its environment, beside those of this process.
        path: where modules are found; None: as in this process.
        hash_seed: decimal digits; None: as all that this process starts (see `pytest_hricdv._base.hash_seed`).
        inherited: the variables that it has in place of those of this process, and of `ONE_THREAD`.
    """
    further = ({} if inherited is not None else dict.fromkeys(ONE_THREAD, "1")) | dict(variables or {})
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment_of_child(further, path=path, hash_seed=hash_seed, inherited=inherited),
            cwd=directory,
            start_new_session=True,  # Ctrl-C is for the session, which then ends all of these processes
        )
        assert process.stdin is not None, "it is a pipe"
        assert process.stdout is not None, "it is a pipe"
        running = SeparateProcess(process, errors)
        try:
            yield running
        finally:
            running.kill()
            process.wait()
            process.stdout.close()
            with suppress(BrokenPipeError):
                process.stdin.close()
