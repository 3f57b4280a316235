"""Kills sessions of a small project at random moments, resumes or rebuilds them, and counts what was lost.

    python -m benchmarks.kills [--kills N] [--signals N] [--full N] [--parts N] [--seed N]

Killed are controlling processes, workers, the replacements of workers, and processes that run tests for optional parts,
all of sessions that this command started. A fault is printed with the seed of its trial; one of the first kinds is run
again by `--trial`: with the same moments, but perhaps on a machine that is busier. Ctrl-C prints what was found until
then.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.kills.parts import KINDS, PartTrials
from benchmarks.kills.trial import KillCounts, Trial, whole
from benchmarks.kills.victim import MODES, make_project
from pytest_hricdv.results.journal import NAME
from pytest_hricdv.results.model import Report
from studies.session import machine

ENDS = {"SIGTERM": [signal.SIGTERM], "SIGINT": [signal.SIGINT], "double SIGINT": [signal.SIGINT, signal.SIGINT]}


def main() -> int:
    """Run trials and print what they have shown; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100, metavar="N", help="go on until so many were killed (100)")
    parser.add_argument("--signals", type=int, default=5, metavar="N", help="sessions ended by each signal (5)")
    parser.add_argument(
        "--full", type=int, default=5, metavar="N", help="sessions whose disk is full at some moment (5)"
    )
    parser.add_argument(
        "--parts", type=int, default=5, metavar="N", help=f"signals while {', '.join(KINDS)}: so many each (5)"
    )
    parser.add_argument("--part", action="append", choices=[*KINDS], help="only while it does this; repeatable")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--trial", metavar="SEED", help="run this trial only")
    options = parser.parse_args()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
    print(f"machine: {machine()}\nseed: {options.seed}", flush=True)
    began_s = time.monotonic()
    folder = Path(tempfile.mkdtemp())  # sessions are forks of this process, and a TemporaryDirectory ends with each
    try:
        run = Run(folder / "tests", options.seed)
        tally = run.run(options.kills, options.signals, options.full, options.trial)
        if not options.trial and "interrupted" not in tally.counts:
            run.run_parts(folder / "parts", options.parts, options.part or [*KINDS])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    for name, count in sorted({**tally.killed, **tally.counts}.items()):
        print(f"{name:40} {count:7}")
    print(f"{'faults':40} {len(tally.faults):7}\n{time.monotonic() - began_s:.0f} s")
    for fault in tally.faults:
        print(f"FAULT {fault}")
    return int(bool(tally.faults))


class Run:
    """All trials, on one project.

    Args:
        folder: an empty one.
        seed: of all trials.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        folder.mkdir(exist_ok=True)
        make_project(folder)
        self._folder = folder
        self._seed = seed
        self._tally = KillCounts()
        self._whole: dict[str, tuple[Report, float]] = {}

    def run(self, kills: int, signals: int, full: int, only: str | None = None) -> KillCounts:
        """Run trials until there were so many kills, sessions ended by each signal, and full disks."""
        if not (kills or signals or full or only):
            return self._tally
        whole(self._folder, "plain")  # writes bytecode, and the suite into the cache
        for mode in MODES:
            began_s = time.monotonic()
            self._whole[mode] = (whole(self._folder, mode), time.monotonic() - began_s)
        journal = self._folder / "hri-report" / NAME
        self._lengths = [len(line) for line in journal.read_bytes().splitlines(keepends=True)]
        try:
            self._trials(kills, signals, full, only)
        except KeyboardInterrupt:
            self._tally.counts["interrupted"] += 1
        return self._tally

    def run_parts(self, folder: Path, signals: int, kinds: Sequence[str] = tuple(KINDS)) -> KillCounts:
        """Run trials on another project until so many signals have reached each of these kinds of parts."""
        folder.mkdir()
        try:
            PartTrials(folder, self._seed, self._tally, kinds).run(signals)
        except KeyboardInterrupt:
            self._tally.counts["interrupted"] += 1
        return self._tally

    def _trials(self, kills: int, signals: int, full: int, only: str | None) -> None:
        number = 0
        while only is None and self._tally.killed["worker"] + self._tally.killed["SIGKILL"] < kills:
            self._trial(f"{self._seed}-{number}").kill()
            number += 1
        if only is not None:
            self._trial(only).kill()
        for name, numbers in ENDS.items():
            for number in range(0 if only else signals):
                self._trial(f"{self._seed}-{name}-{number}").end(numbers)
        for number in range(0 if only else full):
            self._trial(f"{self._seed}-full-{number}").fill(self._lengths)

    def _trial(self, seed: str) -> Trial:
        mode = random.Random(seed).choice(list(MODES))
        report, wall_s = self._whole[mode]
        return Trial(self._folder, mode, report, wall_s, seed, self._tally)


if __name__ == "__main__":
    sys.exit(main())
