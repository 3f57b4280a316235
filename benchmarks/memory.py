"""Memory of processes that run many tests, and whether it grows: without workers, and with two workers.

    python -m benchmarks.memory [--tests N]

Every process runs about N learned tests (default 1000: some ten minutes without workers and the same with two). This
module is also the pytest plugin that measures in these processes.
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

from studies.session import ROOT, machine

FIRST = 100  # tests after which caches are filled; growth counts from there
SUITE = 100
"""Every learned suite has more tests than this; the number of concretizations is chosen to give N tests."""

FIGURES = "HRICDV_MEMORY_FIGURES"
"""Environment variable: the folder to which each measured process writes its figures."""

TESTS = "HRICDV_MEMORY_TESTS"
"""Environment variable: number of tests for each process, and number of processes."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tests", type=int, default=1000, metavar="N", help="tests of each process (default 1000)")
    count = max(FIRST, parser.parse_args().tests)
    print(
        f"machine: {machine()}\nmemory after a number of tests, and its maximum (when the report is written):",
        flush=True,
    )
    for workers in (0, 2):
        for name, figures in watched(count, workers).items():
            print(f"{name:12} {figures}", flush=True)


def watched(count: int, workers: int) -> dict[str, str]:
    """Process -> its figures, in a session in which each process runs `count` tests."""
    processes = max(1, workers)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "benchmarks.memory", "-o", f"cache_dir={folder}/cache"]
        command += ["--hri-suite=rl", f"--hri-concretizations={-(-count * processes // SUITE)}"]
        command += [f"--hri-report={folder}/report", *(["-n", str(workers)] if workers else [])]
        environment = {**os.environ, FIGURES: folder, TESTS: f"{count} {processes}"}
        process = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        files = sorted(Path(folder).glob("*.figures"))
        if len(files) < processes:
            sys.exit(process.stdout + process.stderr)
        return {file.stem: file.read_text(encoding="utf-8") for file in files}


class Watch:
    """Records the memory of a process after the first tests, half of them, the last one; and the maximum."""

    def __init__(self, name: str, count: int, folder: Path) -> None:
        self._file = folder / f"{name}.figures"
        self._count = count
        self._done = 0

    def pytest_runtest_logfinish(self) -> None:
        """Called after each test."""
        self._done += 1
        if self._done in (FIRST, self._count // 2):
            self._note(f"{self._done}: {memory_mb('VmRSS'):.0f} MB  ")

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self) -> None:
        """Called after the last test; workers run slightly different numbers of tests."""
        self._note(f"{self._done}: {memory_mb('VmRSS'):.0f} MB  ")

    def pytest_unconfigure(self) -> None:
        """Called at the end of the process."""
        self._note(f"maximum: {memory_mb('VmHWM'):.0f} MB")

    def _note(self, text: str) -> None:
        with self._file.open("a", encoding="utf-8") as file:
            file.write(text)


def memory_mb(kind: str) -> float:
    """Memory of this process (MB; Linux): `VmRSS`, the present value, or `VmHWM`, the maximum so far."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith(f"{kind}:")) * 1024 / 1e6


class Selection:
    """Selects the first tests: every process has to select the same ones."""

    def __init__(self, count: int) -> None:
        self._count = count

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Called after collection."""
        del items[self._count :]


def pytest_configure(config: Any) -> None:
    """Measure in the processes that the command started."""
    if FIGURES not in os.environ:
        return
    tests, processes = map(int, os.environ[TESTS].split())
    folder, worker = Path(os.environ[FIGURES]), getattr(config, "workerinput", None)
    config.pluginmanager.register(Selection(tests * processes))
    if worker is not None:
        config.pluginmanager.register(Watch(f"worker {worker['workerid']}", tests, folder))
    elif processes == 1:
        config.pluginmanager.register(Watch("one process", tests, folder))


if __name__ == "__main__":
    main()
