"""Signals at random moments of what optional parts do: a loop that closes, shrinking, searching, auditing, mutating.

After Ctrl-C or SIGTERM there is a report with what was reached; after a kill of the process that runs tests for the
part, or where all processes were stopped for a while, the report of a session that was left alone. Nobody goes on after
the session.
"""

from __future__ import annotations

import contextlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.kills.trial import KillCounts, differing
from benchmarks.kills.victim import environment
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import Report
from tests.plugin import project

SUITE = "--hri-suite=by-hand"

ENDS_WITHIN_S = 5.0
"""What docs/interrupted-sessions.md promises for SIGTERM, of a machine that has nothing else to do."""

PATIENCE_S = 600.0
"""No session takes so long, on the busiest machine, unless it hangs."""

MARK = "KILLS_TRIAL"
"""Of the environment: all processes of a trial have it."""


@dataclass(frozen=True)
class Kind:
    """What a session does that is hit.

    Args:
        options: of pytest.
        begun: what its output has from where it does that on.
        process: part of the command line of the process that runs tests for it; empty where the session does.
        environment: further variables.
    """

    options: Sequence[str]
    begun: str
    process: str = ""
    environment: Mapping[str, str] | None = None


KINDS = {
    "closing": Kind(("--hri-close", "--hri-close-runs=24"), r"hricdv: closing \d", "closing.process"),
    "shrinking": Kind(("--hri-shrink",), "hricdv: shrinking"),
    "searching": Kind(("--hri-search=20",), "hricdv: searching"),
    "auditing": Kind(("-o", "hri_audit=2"), "came otherwise", "audit.process", {"UNREPEATABLE": "1"}),
    "mutating": Kind(
        ("--hri-mutate", "--hri-mutate-tests=1", "--hri-mutate-faults=8"), "hricdv: trying", "mutation.process"
    ),
}
MODES = {"without xdist": ("-p", "no:xdist"), "two workers": ("-n", "2")}
ENDS = {
    "SIGINT": (signal.SIGINT,),
    "SIGTERM": (signal.SIGTERM,),
    "double SIGINT": (signal.SIGINT, signal.SIGINT),
    "SIGKILL": (signal.SIGKILL,),
    "SIGSTOP": (signal.SIGSTOP,),
}

STOPPED_S = (0.1, 3.0)
"""So long all processes of a session are stopped before they go on (s; chosen)."""

STATE = """    lamp = Lamp()
    import os
    if "UNREPEATABLE" in os.environ:
        RUNS.append(1)
        lamp.set(float(len(RUNS)))
"""


def make_project(folder: Path) -> None:
    """Write the project; with a variable of the environment, a run depends on how many there were in its process."""
    project.write(folder)
    project.change(folder, "conftest.py", "    lamp = Lamp()\n", STATE)
    project.change(folder, "conftest.py", "LIMIT_S = 60.0\n", "LIMIT_S = 60.0\nRUNS = []\n")


@dataclass
class Ended:
    """A session that has ended: exit status, output, whether signals reached it, and how long it took from there."""

    status: int
    output: str
    hit: bool
    after_s: float
    begun_s: float
    """From where it did what is hit, to its end."""


class PartTrials:
    """Trials on one project.

    Args:
        folder: an empty one.
        seed: of all moments.
        tally: takes what is found.
    """

    def __init__(self, folder: Path, seed: int, tally: KillCounts) -> None:
        make_project(folder)
        self._folder = folder
        self._seed = seed
        self._tally = tally
        self._whole: dict[tuple[str, str], tuple[Report, float]] = {}

    def run(self, signals: int) -> None:
        """Go on until so many signals have reached sessions of each kind."""
        for kind in KINDS:
            number = 0
            while self._tally.killed[f"signals while {kind}"] < signals and number < 3 * signals:
                self._trial(kind, f"{self._seed}-{kind}-{number}")
                number += 1

    def _trial(self, name: str, seed: str) -> None:
        rng = random.Random(seed)
        mode = rng.choice([*MODES])
        ends = [end for end in ENDS if end != "SIGKILL" or KINDS[name].process]
        end = ends[int(seed.rpartition("-")[2]) % len(ends)]
        whole, begun_s = self._unharmed(name, mode)
        after_s, everybody = rng.uniform(0.0, begun_s), rng.random() < 0.5
        ended = self._session(name, mode, seed, ENDS[end], after_s, everybody=everybody)
        if not ended.hit:
            self._tally.counts["over before the signal came"] += 1
            return
        self._tally.killed[f"signals while {name}"] += 1
        self._tally.killed[end] += 1
        fault = self._fault_of(name, end, ended, whole)
        if end == "SIGTERM" and ended.after_s > ENDS_WITHIN_S:
            self._tally.counts[f"SIGTERM: ended after more than {ENDS_WITHIN_S:g} s"] += 1
        if fault:
            self._tally.faults.append(f"{name}, {mode}, {end}, trial {seed}: {fault}\n{ended.output[-3000:]}")

    def _unharmed(self, name: str, mode: str) -> tuple[Report, float]:
        if (name, mode) not in self._whole:
            ended = self._session(name, mode, "unharmed")
            self._whole[name, mode] = load(self._folder / "hri-report"), ended.begun_s
        return self._whole[name, mode]

    def _session(
        self,
        name: str,
        mode: str,
        trial: str,
        numbers: Sequence[int] = (),
        after_s: float = 0.0,
        *,
        everybody: bool = False,
    ) -> Ended:
        kind = KINDS[name]
        shutil.rmtree(self._folder / "hri-report", ignore_errors=True)
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "no:cacheprovider",
            "--tb=no",
            SUITE,
            *kind.options,
            *MODES[mode],
        ]
        log = self._folder / "output"
        with log.open("w", encoding="utf-8") as output:
            process = subprocess.Popen(
                command,
                cwd=self._folder,
                env={**environment(), **(kind.environment or {}), MARK: _mark(trial), "PYTHONUNBUFFERED": "1"},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            begun_s = _begun(process, log, kind.begun)
            hit, sent_s = self._hit(process, kind, numbers, after_s, trial, everybody=everybody), time.monotonic()
            status = process.wait(PATIENCE_S)
            now_s = time.monotonic()
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        text = log.read_text(encoding="utf-8", errors="replace")
        left = _left(trial)
        if left:
            self._tally.faults.append(f"{name}, {mode}, trial {trial}: {left} goes on after the session")
        return Ended(status, text, hit, now_s - sent_s, now_s - begun_s)

    def _hit(
        self,
        process: subprocess.Popen[bytes],
        kind: Kind,
        numbers: Sequence[int],
        after_s: float,
        trial: str,
        *,
        everybody: bool,
    ) -> bool:
        """Send the signals; whether they came in time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(after_s)
        if process.poll() is not None or not numbers:
            return False
        if signal.SIGKILL in numbers:
            pids = [pid for pid, line in _processes(process.pid) if kind.process in line]
            return any(_sent(pid, signal.SIGKILL) for pid in pids[:1])
        if signal.SIGSTOP in numbers:
            stopped = [pid for pid in _of_trial(trial) if _sent(pid, signal.SIGSTOP)]
            time.sleep(random.Random(trial).uniform(*STOPPED_S))  # for how long they are stopped is what is tried
            for pid in stopped:
                _sent(pid, signal.SIGCONT)
            return bool(stopped)
        for number in numbers:
            with contextlib.suppress(ProcessLookupError):
                (os.killpg if everybody else os.kill)(process.pid, number)
        return True

    def _fault_of(self, name: str, end: str, ended: Ended, whole: Report) -> str:
        """What is wrong with how a session has ended; empty where nothing is."""
        if "INTERNALERROR" in ended.output:
            return "an internal error"
        try:
            report = load(self._folder / "hri-report")
        except ReportError as error:
            return f"status {ended.status}, no report: {error}"
        if timeless(report) == timeless(whole):
            self._tally.counts["the report is that of a session left alone"] += 1
            return ""
        if end in ("SIGKILL", "SIGSTOP"):
            return f"the report differs in {differing(timeless(report), timeless(whole))}"
        self._tally.counts["a report with what was reached"] += 1
        if ended.status != 2:
            return f"exit status {ended.status}"
        right = {test.nodeid: test.record_sha256 for test in whole.tests}
        wrong = [test.nodeid for test in report.tests if test.record_sha256 not in (None, right.get(test.nodeid))]
        if wrong and name != "closing":
            return f"another result of {wrong[0]}"
        if name != "closing" and report.not_run:
            return f"{report.not_run} of the tests that had ended are not run"
        return (
            "" if name != "closing" or getattr(report, "closing", None) is not None else "nothing is said of the loop"
        )


def timeless(report: Report) -> dict[str, Any]:
    """A report without wall times, its origin, and where suites came from."""
    plain: dict[str, Any] = _without_times(msgspec.to_builtins(report))
    return plain


def _without_times(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_times(below) for name, below in value.items() if name not in _TIMED}
    return [_without_times(below) for below in value] if isinstance(value, (list, tuple)) else value


_TIMED = ("wall_s", "cached", "origin")


def _begun(process: subprocess.Popen[bytes], log: Path, pattern: str) -> float:
    """When the output had this (by `time.monotonic`)."""
    until_s = time.monotonic() + PATIENCE_S
    while process.poll() is None and not re.search(pattern, log.read_text(encoding="utf-8", errors="replace")):
        if time.monotonic() > until_s:
            break
        time.sleep(0.01)  # it only looks again: what it waits for is in the output
    return time.monotonic()


def _processes(parent: int) -> list[tuple[int, str]]:
    """The children of a process, with their command lines."""
    try:
        pids = [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text(encoding="utf-8").split()]
    except OSError:
        return []
    return [(pid, _read(pid, "cmdline")) for pid in pids]


def _sent(pid: int, number: int) -> bool:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)
        return True
    return False


def _mark(trial: str) -> str:
    """Of a trial of this process: several may run at the same time."""
    return f"{os.getpid()}-{trial}"


def _of_trial(trial: str) -> list[int]:
    """All processes that a trial has started, itself or through others."""
    pids = [int(name) for name in os.listdir("/proc") if name.isdigit()]
    return [pid for pid in pids if f"{MARK}={_mark(trial)}\0" in _read(pid, "environ")]


def _left(trial: str) -> str:
    """Who of a trial goes on 5 s after its session; its command line."""
    until_s = time.monotonic() + ENDS_WITHIN_S
    while True:
        left = _of_trial(trial)
        if not left or time.monotonic() > until_s:
            return f"process {left[0]} ({_read(left[0], 'cmdline')[:200]})" if left else ""
        time.sleep(0.05)  # it only looks again: nobody tells when a process that is no child ends


def _read(pid: int, name: str) -> str:
    try:
        return Path(f"/proc/{pid}/{name}").read_text(encoding="utf-8", errors="replace")
    except OSError:  # it has ended
        return ""
