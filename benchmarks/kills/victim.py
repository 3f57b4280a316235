"""The sessions that are killed: of the plugin's small test project, with a log of the results that have arrived."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from studies.session import ROOT
from tests.plugin import project

MODES = {"plain": (), "without xdist": ("-p", "no:xdist"), "two workers": ("-n", "2", "--max-worker-restart=1000")}
ARRIVED = "arrived.txt"
PATIENCE_S = 120.0
"""No session takes so long, unless it hangs."""

# The plugin's own hook for a report comes first: what is in this log has finished for certain. A test takes a moment,
# so that kills come between all tests.
LOGGING = """

import os, resource, time

if "ROOM" in os.environ:
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(os.environ["ROOM"]), resource.RLIM_INFINITY))

def pytest_runtest_setup():
    time.sleep(0.02)  # so that kills also come between two tests

def pytest_runtest_logreport(report):
    if report.when == "call" and "PYTEST_XDIST_WORKER" not in os.environ:
        with open("arrived.txt", "a", buffering=1) as log:
            log.write(report.nodeid + "\\n")
"""
_WORKER = b"exec(eval(sys.stdin.readline()))"
"""What the command line of xdist's workers contains."""


def make_project(folder: Path) -> None:
    """Write the project into an empty folder."""
    project.write(folder)
    conftest = folder / "conftest.py"
    conftest.write_text(conftest.read_text(encoding="utf-8") + LOGGING, encoding="utf-8")


def environment() -> dict[str, str]:
    """Of sessions: without what a test that starts them has from pytest."""
    own = {name: text for name, text in os.environ.items() if not name.startswith("PYTEST_")}
    return own | {"PYTHONPATH": str(ROOT)}


@dataclass
class Victim:
    """Runs sessions and kills them, or their workers: processes that it has started itself, and no others.

    Args:
        folder: of the project.
        options: of pytest.
        rng: draws the moments.
    """

    folder: Path
    options: Sequence[str]
    rng: random.Random
    killed: Counter[str] = field(default_factory=Counter)
    """How many of which kind."""

    @property
    def arrived(self) -> set[str]:
        """Node ids of the results that have arrived since the log was removed."""
        log = self.folder / ARRIVED
        return set(log.read_text(encoding="utf-8").split("\n")) - {""} if log.exists() else set()

    def keep(self, nodeids: Collection[str]) -> None:
        """Forget that other results have arrived."""
        (self.folder / ARRIVED).write_text("".join(f"{nodeid}\n" for nodeid in nodeids), encoding="utf-8")

    def run(
        self,
        *more: str,
        numbers: Sequence[int] = (),
        after_s: float = 0.0,
        workers_s: float = 0.0,
        room: int | None = None,
    ) -> tuple[int, str]:
        """Run a session to its end.

        Args:
            more: options.
            numbers: signals for its controlling process, one right after the other.
            after_s: when they come.
            workers_s: mean time between kills of a worker; 0: none is killed.
            room: no file can have more bytes, as on a full disk; None: they can.

        Returns:
            Exit status and output.
        """
        variables = environment() | ({} if room is None else {"ROOM": str(room)})
        command = [sys.executable, "-m", "pytest", "--hri-suite=rl", "-q", "--tb=no", *self.options, *more]
        with subprocess.Popen(
            command,
            cwd=self.folder,
            env=variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        ) as process:
            try:
                self._kill(process, numbers, after_s, workers_s)
                output, _ = process.communicate(timeout=PATIENCE_S)
            finally:
                if process.poll() is None:
                    process.kill()
        return process.returncode, output

    def _kill(self, process: subprocess.Popen[str], numbers: Sequence[int], after_s: float, workers_s: float) -> None:
        began_s = time.monotonic()
        while workers_s:
            wait_s = self.rng.expovariate(1 / workers_s)
            left_s = after_s - (time.monotonic() - began_s) if numbers else PATIENCE_S
            if left_s < wait_s or _ends(process, wait_s):
                break
            self._kill_worker(process.pid)
        if numbers and not _ends(process, max(0.0, after_s - (time.monotonic() - began_s))):
            # A terminal, and many a CI system, signals all processes of the session.
            everybody = signal.SIGKILL not in numbers and self.rng.random() < 0.5
            for number in numbers:
                if process.poll() is None:
                    (os.killpg if everybody else os.kill)(process.pid, number)
            self.killed[" ".join(signal.Signals(number).name for number in numbers)] += 1

    def _kill_worker(self, controller: int) -> None:
        """Kill a worker, whatever it does just now; every second time the newest, which may be starting."""
        workers = [pid for pid in _children(controller) if _WORKER in _read(f"/proc/{pid}/cmdline")]
        if workers:
            pid = max(workers) if self.rng.random() < 0.5 else self.rng.choice(workers)
            os.kill(pid, signal.SIGKILL)
            self.killed["worker"] += 1


def _ends(process: subprocess.Popen[str], within_s: float) -> bool:
    try:
        process.wait(within_s)
    except subprocess.TimeoutExpired:
        return False
    return True


def _children(pid: int) -> list[int]:
    return [int(child) for child in _read(f"/proc/{pid}/task/{pid}/children").split()]


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError:  # it has ended
        return b""
