"""What a worker's process occupies, and whether it grows: after 100 tests, and after many.

    python -m benchmarks.memory [--tests N]

One process runs N learned tests (default 1000: seven minutes) through the whole plugin. This module is also the pytest
plugin that watches there.
"""

from __future__ import annotations

import argparse
import os
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
"""Environment variable: the file that the watched process writes its figures to."""

TESTS = "HRICDV_MEMORY_TESTS"
"""Environment variable: how many tests are watched."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=1000, metavar="N", help="tests to run (default 1000)")
    count = max(FIRST, parser.parse_args().tests)
    with tempfile.TemporaryDirectory() as folder:
        figures = Path(folder) / "figures"
        command = [sys.executable, "-m", "pytest", "-q", "-p", "benchmarks.memory", "-o", f"cache_dir={folder}/cache"]
        command += ["--hri-suite=rl", f"--hri-concretizations={-(-count // SUITE)}", f"--hri-report={folder}/report"]
        environment = {**os.environ, FIGURES: str(figures), TESTS: str(count)}
        process = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        if not figures.exists():
            sys.exit(process.stdout + process.stderr)
        print(f"machine: {machine()}\nmemory of one process after so many tests: {figures.read_text().strip()}")


class Watch:
    """Notes the resident memory after the first tests, half-way, and after the last; then ends the session."""

    def __init__(self, count: int, file: Path) -> None:
        self._count = count
        self._file = file
        self._done = 0

    def pytest_runtest_teardown(self, item: Any) -> None:
        """Called once a test."""
        self._done += 1
        if self._done == self._count:
            item.session.shouldstop = "measured"
        if self._done in (FIRST, self._count // 2, self._count):
            with self._file.open("a", encoding="utf-8") as file:
                file.write(f"{self._done}: {resident_mb():.0f} MB  ")


def resident_mb() -> float:
    """Resident memory of this process (MB; Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def pytest_configure(config: Any) -> None:
    """Watch, in the process that the command started."""
    if FIGURES in os.environ:
        config.pluginmanager.register(Watch(int(os.environ[TESTS]), Path(os.environ[FIGURES])))


if __name__ == "__main__":
    main()
