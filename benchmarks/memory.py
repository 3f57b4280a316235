"""What a process occupies while it runs many tests, and whether that grows: without workers, and each of two workers.

    python -m benchmarks.memory [--tests N]

Every process runs N learned tests (default 1000: some ten minutes each for the one and for the two) through the whole
plugin. This module is also the pytest plugin that watches there.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

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
    print(f"machine: {machine()}\nmemory after so many tests, and at most while the report was written:")
    for name, figures in {**watched(count, []), **watched(2 * count, ["-n", "2"])}.items():
        print(f"{name:12} {figures}", flush=True)


def watched(count: int, workers: list[str]) -> dict[str, str]:
    """Process -> its figures, of a session with at least so many tests."""
    processes = 2 if workers else 1
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "benchmarks.memory", "-o", f"cache_dir={folder}/cache"]
        command += ["--hri-suite=rl", f"--hri-concretizations={-(-count // SUITE)}", f"--hri-report={folder}/report"]
        environment = {**os.environ, FIGURES: folder, TESTS: str(count // processes)}
        process = subprocess.run(
            [*command, *workers], cwd=ROOT, env=environment, capture_output=True, text=True, check=False
        )
        files = sorted(Path(folder).glob("*.figures"))
        if len(files) < processes:
            sys.exit(process.stdout + process.stderr)
        return {file.stem: file.read_text(encoding="utf-8") for file in files}


class Watch:
    """Notes the resident memory after the first tests, half-way, and after the last; then ends the session."""

    def __init__(self, name: str, count: int, folder: Path) -> None:
        self._file = folder / f"{name}.figures"
        self._count = count
        self._done = 0
        self._session: Any = None

    def pytest_sessionstart(self, session: Any) -> None:
        """Called in each process."""
        self._session = session

    def pytest_runtest_logfinish(self) -> None:
        """Called once a test, in the process that ran it."""
        self._done += 1
        if self._done == self._count:
            self._session.shouldstop = "measured"
        if self._done in (FIRST, self._count // 2, self._count):
            self._note(f"{self._done}: {resident_mb():.0f} MB  ")

    def pytest_unconfigure(self) -> None:
        """Called when all is over."""
        self._note(f"most: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000 * 1.024:.0f} MB")

    def _note(self, text: str) -> None:
        with self._file.open("a", encoding="utf-8") as file:
            file.write(text)


def resident_mb() -> float:
    """Resident memory of this process (MB; Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def pytest_configure(config: Any) -> None:
    """Watch, in each process of the session that runs tests."""
    name = "one process" if not config.getoption("numprocesses", None) else ""
    name = f"worker {config.workerinput['workerid']}" if hasattr(config, "workerinput") else name
    if FIGURES in os.environ and name:
        config.pluginmanager.register(Watch(name, int(os.environ[TESTS]), Path(os.environ[FIGURES])))


if __name__ == "__main__":
    main()
