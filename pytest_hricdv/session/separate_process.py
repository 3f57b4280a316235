"""A process beside the session, in which tests run in forks: how it is started, and how it is configured.

A fresh process, because a fork needs that there are no threads, which xdist's processes have, and because code under
test that is to be changed must not have been imported. pytest is configured in it as in the session, so that conftest
files, the testbench and the world are what they are there. What is sent to it and what it answers are lines of JSON.
"""

from __future__ import annotations

import importlib
import math
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import IO, TYPE_CHECKING, NoReturn

import msgspec
import pytest

try:
    import resource
except ImportError:
    resource = None  # type: ignore[assignment]  # not on Windows, where a run that does not end is not ended

if TYPE_CHECKING:
    from pytest_hricdv.session.running import Running

PRELOADED = (
    "pytest_hricdv.conformance.conformance_monitor",
    "pytest_hricdv.monitor.parser",
    *(f"pytest_hricdv.session.{name}" for name in ("aggregation", "exports", "preparation", "progress", "reporting")),
)
"""What the plugin imports when pytest is configured: done once here, and not again in each fork. By name, because what
starts this process is among them."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Libraries for numbers start threads of their own, which a fork would not have, unless these variables say 1."""


class ProcessError(Exception):
    """The process failed; the text is the last line that it wrote about it."""


class SeparateProcess:
    """The process, as the session sees it.

    Args:
        process: started, with pipes.
        errors: what it writes to its standard error.
    """

    def __init__(self, process: subprocess.Popen[bytes], errors: IO[str]) -> None:
        self._process = process
        self._errors = errors

    def send(self, message: object) -> None:
        """Send a line."""
        assert self._process.stdin is not None, "it is a pipe"
        with suppress(BrokenPipeError):  # how it ended says more
            self._process.stdin.write(msgspec.json.encode(message) + b"\n")
            self._process.stdin.flush()

    def lines(self) -> Iterator[bytes]:
        """The lines that it writes, up to its end.

        Raises:
            ProcessError: it failed.
        """
        assert self._process.stdout is not None, "it is a pipe"
        yield from self._process.stdout
        if self._process.wait() != 0:
            self._errors.seek(0)
            last = self._errors.read().strip().splitlines()[-1:]
            raise ProcessError("".join(last) or f"it ended with status {self._process.returncode}")


@contextmanager
def started(module: ModuleType, directory: Path) -> Iterator[SeparateProcess]:
    """Start a module in a process in this directory; in the end, it and what it started are ended."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("COV_", "COVERAGE_"))}
    environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    environment |= dict.fromkeys(ONE_THREAD, "1")
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", module.__name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment,
            cwd=directory,
            start_new_session=True,  # Ctrl-C is for the session, which then ends all of these processes
        )
        assert process.stdin is not None, "it is a pipe"
        assert process.stdout is not None, "it is a pipe"
        try:
            yield SeparateProcess(process, errors)
        finally:
            if process.poll() is None:
                _kill(process)
            process.wait()
            process.stdout.close()
            with suppress(BrokenPipeError):
                process.stdin.close()


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a process at once, with those that it has started."""
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()  # on Windows it starts none


def arguments_of(config: pytest.Config) -> tuple[str, ...]:
    """The arguments of the session; the modules of the plugin are imported before pytest can rewrite their asserts."""
    unmeasured = ["--no-cov"] if hasattr(config.option, "no_cov") else []  # of pytest-cov
    given = [os.fspath(each) for each in config.invocation_params.args]
    return (*given, *unmeasured, "-W", "ignore::pytest.PytestAssertRewriteWarning")


@contextmanager
def session() -> Iterator[tuple[IO[bytes], Callable[[bytes], None]]]:
    """Within the process: the lines that the session sends, and what sends it a line.

    pytest replaces standard input and output when it is configured. What anybody else prints goes nowhere.
    """
    with os.fdopen(os.dup(0), "rb") as messages, os.fdopen(os.dup(1), "wb") as output:
        silence(1)

        def write(line: bytes) -> None:
            output.write(line + b"\n")
            output.flush()

        yield messages, write


def preload() -> None:
    """Import what configuring pytest will import."""
    for name in PRELOADED:
        importlib.import_module(name)


def in_session(arguments: tuple[str, ...], work: Callable[[Running], None]) -> int:
    """Configure pytest as in the session, do the work, and end the process. Returns pytest's status where it could not.

    pytest's own end is left out: it takes longer than some tests.
    """
    return int(pytest.main([*arguments], plugins=[_Instead(work)]))


class _Instead:
    """A plugin of pytest that does something else than a session."""

    def __init__(self, work: Callable[[Running], None]) -> None:
        self._work = work

    def pytest_cmdline_main(self, config: pytest.Config) -> NoReturn:
        """Does the work in place of the session."""
        from pytest_hricdv.session.running import Running

        config._do_configure()  # as pytest's own --help does: the testbench may need what conftest files set up
        running = config.pluginmanager.get_plugin("hricdv-running")
        assert isinstance(running, Running), "the session has a suite"
        _ = running.collection.testbench, running.requirements, running.known_while
        self._work(running)
        os._exit(0)


def limit_time(run_s: float) -> None:
    """The kernel ends this process when it takes more processor time from now on (s), whatever it does.

    Without effect on Windows, and where runs do not begin in forks: there it would end them all.
    """
    if resource is None or not hasattr(os, "fork"):
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(used.ru_utime + used.ru_stime + run_s), hard))


def leave_no_core() -> None:
    """A process that the kernel ends writes no file about it."""
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def silence(descriptor: int) -> None:
    """What is written to it goes nowhere."""
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), descriptor)
