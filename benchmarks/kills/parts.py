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
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.kills.part_session import PartSession, command_line, descendants, prepare, sent, still_there
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

LEFT_S = 60.0
"""So long somebody may go on after the session, on the busiest machine (s; chosen)."""


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
MODES = {
    "without xdist": ((), "pytest_hricdv.plugin"),
    "two workers": (("-n", "2"), "pytest_hricdv.plugin,xdist.plugin"),
}
"""Options of pytest, and the plugins that it loads."""
WEIGHTS = (2, 1)
"""Of the modes: a session with two workers takes three times the processor time (chosen)."""
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
        kinds: names of those that are hit.
    """

    def __init__(self, folder: Path, seed: int, tally: KillCounts, kinds: Sequence[str] = tuple(KINDS)) -> None:
        make_project(folder)
        self._folder = folder
        self._seed = seed
        self._tally = tally
        self._kinds = kinds
        self._whole: dict[tuple[str, str], Report] = {}
        self._takes_s: dict[tuple[str, str], float] = {}
        prepare([SUITE, *MODES["without xdist"][0]], folder, _variables(KINDS["closing"], "two workers"))

    def run(self, signals: int) -> None:
        """Go on until so many signals have reached sessions of each kind, one kind after the other."""
        for number in range(3 * signals):
            for kind in self._kinds:
                if self._tally.killed[f"signals while {kind}"] < signals:
                    self._trial(kind, f"{self._seed}-{kind}-{number}")
            hit = {kind: self._tally.killed[f"signals while {kind}"] for kind in self._kinds}
            print(", ".join(f"{count} {kind}" for kind, count in hit.items()), flush=True)

    def _trial(self, name: str, seed: str) -> None:
        rng = random.Random(seed)
        mode = rng.choices([*MODES], WEIGHTS)[0]
        ends = [end for end in ENDS if end != "SIGKILL" or KINDS[name].process]
        end = ends[int(seed.rpartition("-")[2]) % len(ends)]
        whole = self._unharmed(name, mode)
        after_s, everybody = rng.uniform(0.0, self._takes_s[name, mode]), rng.random() < 0.5
        ended = self._session(name, mode, seed, ENDS[end], after_s, everybody=everybody)
        if not ended.hit:
            self._tally.counts["over before the signal came"] += 1
            self._takes_s[name, mode] = ended.begun_s  # the machine may have less to do now
            return
        self._tally.killed[f"signals while {name}"] += 1
        self._tally.killed[f"signals {mode}"] += 1
        self._tally.killed[end] += 1
        fault = self._fault_of(name, end, ended, whole)
        if end == "SIGTERM" and ended.after_s > ENDS_WITHIN_S:
            self._tally.counts[f"SIGTERM: ended after more than {ENDS_WITHIN_S:g} s"] += 1
        if fault:
            self._add(f"{name}, {mode}, {end}, trial {seed}: {fault}\n{ended.output[-3000:]}")

    def _unharmed(self, name: str, mode: str) -> Report:
        """The report of a session that is left alone: one of an interpreter of its own, as a user starts it."""
        if (name, mode) not in self._whole:
            ended = self._session(name, mode, "unharmed")
            self._whole[name, mode], self._takes_s[name, mode] = load(self._folder / "hri-report"), ended.begun_s
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
        kind, log = KINDS[name], self._folder / "output"
        shutil.rmtree(self._folder / "hri-report", ignore_errors=True)
        arguments = ["-p", "no:cacheprovider", "--tb=no", SUITE, *kind.options, *MODES[mode][0]]
        session = PartSession(arguments, self._folder, _variables(kind, mode), log, forked=bool(numbers))
        try:
            begun_s = _begun(session, log, kind.begun)
            hit, sent_s = self._hit(session, kind, numbers, after_s, trial, everybody=everybody), time.monotonic()
            ended = session.ends(PATIENCE_S)
            now_s = time.monotonic()
            left = still_there(LEFT_S) if ended else "the session"
        finally:
            session.kill()
        text = log.read_text(encoding="utf-8", errors="replace")
        if left:
            self._add(f"{name}, {mode}, {numbers}, trial {trial}: {left} goes on\n{text[-3000:]}")
        return Ended(session.status, text, hit, now_s - sent_s, now_s - begun_s)

    def _hit(
        self,
        session: PartSession,
        kind: Kind,
        numbers: Sequence[int],
        after_s: float,
        trial: str,
        *,
        everybody: bool,
    ) -> bool:
        """Send the signals; whether they came in time."""
        if session.ends(after_s) or not numbers:
            return False
        if signal.SIGKILL in numbers:
            return any(sent(pid, signal.SIGKILL) for pid in descendants() if kind.process in command_line(pid))
        if signal.SIGSTOP in numbers:
            stopped = [pid for pid in descendants() if sent(pid, signal.SIGSTOP)]
            time.sleep(random.Random(trial).uniform(*STOPPED_S))  # for how long they are stopped is what is tried
            for pid in stopped:
                sent(pid, signal.SIGCONT)
            return bool(stopped)
        for number in numbers:
            with contextlib.suppress(ProcessLookupError):
                (os.killpg if everybody else os.kill)(session.pid, number)
        return True

    def _add(self, fault: str) -> None:
        self._tally.faults.append(fault)
        print(f"fault {len(self._tally.faults)}: {fault.splitlines()[0]}", flush=True)

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


def _variables(kind: Kind, mode: str) -> dict[str, str]:
    """The environment of a session: only those plugins that it needs, which workers import quickly."""
    more = {"PYTHONUNBUFFERED": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_PLUGINS": MODES[mode][1]}
    return {**environment(), **(kind.environment or {}), **more}


def _begun(session: PartSession, log: Path, pattern: str) -> float:
    """When the output had this (by `time.monotonic`)."""
    until_s = time.monotonic() + PATIENCE_S
    while not re.search(pattern, log.read_text(encoding="utf-8", errors="replace")):
        if session.ends(0.01) or time.monotonic() > until_s:  # it only looks again: what it waits for is in the output
            break
    return time.monotonic()
