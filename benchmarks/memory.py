"""What a process occupies while it runs many tests, and whether that grows: without workers, and each of two workers.

    python -m benchmarks.memory [--tests N]

Every process runs N learned tests (default 1000: some ten minutes each for the one and for the two) through the whole
plugin. This module is also the pytest plugin that watches there.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

from benchmarks.end_to_end import ROOT, machine

FIRST = 100
SUITE = 100
"""More different tests than this has every learned suite; with so many concretizations each, N are there."""

FIGURES = "HRICDV_MEMORY_FIGURES"
"""Environment variable: the folder that watched processes write their figures to, a file each."""

TESTS = "HRICDV_MEMORY_TESTS"
"""Environment variable: how many tests are watched in each process."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=1000, metavar="N", help="tests of each process (default 1000)")
    count = max(FIRST, parser.parse_args().tests)
    print(
        f"machine: {machine()}\nmemory after so many tests, and the most, which is when the report is written:",
        flush=True,
    )
    for workers in (0, 2):
        for name, figures in watched(count, workers).items():
            print(f"{name:12} {figures}", flush=True)


def watched(count: int, workers: int) -> dict[str, str]:
    """Process -> its figures, of a session in which each process that runs tests runs so many."""
    processes = max(1, workers)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "benchmarks.memory", "-o", f"cache_dir={folder}/cache"]
        command += ["--hri-suite=rl", f"--hri-concretizations={-(-count * processes // SUITE)}"]
        command += [f"--hri-report={folder}/report", *(["-n", str(workers)] if workers else [])]
        environment = {**os.environ, FIGURES: folder, TESTS: str(count)}
        process = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        files = sorted(Path(folder).glob("*.figures"))
        if len(files) < processes:
            sys.exit(process.stdout + process.stderr)
        return {file.stem: file.read_text(encoding="utf-8") for file in files}


class Watch:
    """Notes the memory of a process that runs tests: after the first ones, half-way, after the last; and the most."""

    def __init__(self, name: str, count: int, folder: Path) -> None:
        self._file = folder / f"{name}.figures"
        self._count = count
        self._done = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logfinish(self) -> None:
        """Called once a test."""
        self._done += 1
        if self._done in (FIRST, self._count // 2, self._count):
            self._note(f"{self._done}: {memory_mb('VmRSS'):.0f} MB  ")

    def pytest_unconfigure(self) -> None:
        """Called when all is over."""
        self._note(f"most: {memory_mb('VmHWM'):.0f} MB")

    def _note(self, text: str) -> None:
        with self._file.open("a", encoding="utf-8") as file:
            file.write(text)


class Stop:
    """Ends the session when each process has run its tests; for the controlling process, or the only one."""

    def __init__(self, count: int, folder: Path, processes: int) -> None:
        self._done = f"{count}: "
        self._folder = folder
        self._processes = processes
        self._session: Any = None

    def pytest_sessionstart(self, session: Any) -> None:
        """The session that is to be ended."""
        self._session = session

    def pytest_runtest_logfinish(self) -> None:
        """Called once a test."""
        done = [file for file in self._folder.glob("*.figures") if self._done in file.read_text(encoding="utf-8")]
        if len(done) == self._processes:
            self._session.shouldstop = "measured"


def memory_mb(kind: str) -> float:
    """Memory of this process (MB; Linux): `VmRSS`, what it occupies now, or `VmHWM`, the most that it did so far."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith(f"{kind}:")) * 1024 / 1e6


def pytest_configure(config: Any) -> None:
    """Watch, in the processes that the command started."""
    if FIGURES not in os.environ:
        return
    count, folder, workers = int(os.environ[TESTS]), Path(os.environ[FIGURES]), config.getoption("numprocesses", None)
    if hasattr(config, "workerinput"):
        config.pluginmanager.register(Watch(f"worker {config.workerinput['workerid']}", count, folder))
        return
    if not workers:
        config.pluginmanager.register(Watch("one process", count, folder))
    config.pluginmanager.register(Stop(count, folder, workers or 1))


if __name__ == "__main__":
    main()
