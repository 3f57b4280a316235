"""Trials: a session is killed until it has ended, and what it leaves is compared with a session without a break."""

from __future__ import annotations

import random
import shutil
import signal
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.kills.victim import ARRIVED, MODES, Victim
from pytest_hricdv.report.__main__ import rebuild_report
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, load
from pytest_hricdv.results.derivation import derive
from pytest_hricdv.results.journal import NAME, Journal, StartRecord, read
from pytest_hricdv.results.model import Report

KILLS = 8
"""At most so many kills of the controlling process in a trial: with more, hardly a trial gets to its end."""
MOST_OUTPUT = 20_000
"""Bytes: pytest captures output in files, which have room."""
RESUMES = 20
"""A session that is not killed needs one or two, after kills of its workers a few more."""


@dataclass
class KillCounts:
    """What trials have shown."""

    killed: Counter[str] = field(default_factory=Counter)
    counts: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


@dataclass
class Trial:
    """One trial.

    Args:
        folder: of the project.
        mode: of `MODES`.
        whole: the report of a session without a break.
        wall_s: the duration of that session.
        seed: of all moments.
        tally: takes what is found.
    """

    folder: Path
    mode: str
    whole: Report
    wall_s: float
    seed: str
    tally: KillCounts

    def __post_init__(self) -> None:
        self.report = self.folder / "hri-report"
        self.rng = random.Random(self.seed)
        self.victim = Victim(self.folder, MODES[self.mode], self.rng, self.tally.killed)
        self.workers_s = 0.5 if self.mode == "two workers" else 0.0

    def kill(self) -> None:
        """SIGKILL, again and again."""
        self._clear()
        for number in range(self.rng.randint(1, KILLS)):
            resume = ("--hri-resume",) if number else ()
            after_s = self.rng.uniform(0.2, self.wall_s)
            self.victim.run(*resume, numbers=[signal.SIGKILL], after_s=after_s, workers_s=self.workers_s)
            self._check_lost()
            if self.rng.random() < 0.3:
                self._check_rebuilt()
        self._finish()

    def end(self, numbers: Sequence[int]) -> None:
        """Signals after which a session is to end in an orderly way."""
        self._clear()
        status, _ = self.victim.run(numbers=numbers, after_s=self.rng.uniform(self.wall_s / 3, self.wall_s))
        journal = self._check_lost()
        if journal is not None and journal.declared is not None:
            self.tally.counts["ended after the first test had begun"] += 1
            try:
                load(self.report)
            except ReportError as error:
                self._fault(f"no report: {error}")
            if status == 0 and len(journal.results) < self.whole.selected:
                self._fault("exit status 0 with fewer results than tests")
        self._finish()

    def fill(self, lengths: Sequence[int]) -> None:
        """A session whose disk is full at some moment; there is room again when it is resumed.

        Args:
            lengths: of the lines of the journal of a session without a break, in bytes.
        """
        self._clear()
        room = self.rng.randint(MOST_OUTPUT, sum(lengths))
        status, _ = self.victim.run(room=room)
        self.tally.counts["full disks"] += 1
        journal = self.report / NAME
        written = read(journal) if journal.is_file() else Journal()
        # The first two lines are long, and say what the session is; without them there is no result.
        needed = max(written.size, sum(lengths[:2])) + max(lengths[2:])
        if len(written.results) < self.whole.selected and needed < room:
            self._fault(f"{written.size} bytes are written, and there is room for {room}")
        if status == 0:
            self._fault("exit status 0, and the report cannot have been written")
        self.victim.keep(written.results)  # for the others there was no room
        self._finish()

    def _clear(self) -> None:
        shutil.rmtree(self.report, ignore_errors=True)
        (self.folder / ARRIVED).unlink(missing_ok=True)

    def _check_lost(self) -> Journal | None:
        """Every result that has arrived is in the journal, and is the right one."""
        arrived = self.victim.arrived
        self.tally.counts["finished results"] += len(arrived)
        if not (self.report / NAME).is_file():
            if arrived:
                self._fault(f"{len(arrived)} results lost: there is no journal")
            return None
        journal = read(self.report / NAME)
        lost = arrived - journal.results.keys()
        if lost:
            self.tally.counts["lost"] += len(lost)
            self._fault(f"{len(lost)} results lost: {min(lost)}")
        return journal

    def _check_rebuilt(self) -> None:
        """The report that is rebuilt has the right results and totals."""
        journal = read(self.report / NAME) if (self.report / NAME).is_file() else None
        if journal is None or journal.declared is None or journal.is_ended:
            return
        copy = self.folder / "rebuilt"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(self.report, copy)
        report, problem = rebuild_report(copy)
        self.tally.counts["rebuilt"] += 1
        right = {test.nodeid: test for test in self.whole.tests}
        tests = [right[test.nodeid] if test.nodeid in journal.results else test for test in report.tests]
        expected = derive(msgspec.structs.replace(report, tests=tuple(tests)))
        counted = (report.selected, report.reported) == (self.whole.selected, len(journal.results))
        if problem or not counted or timeless(report) != timeless(expected) or load(copy) != report:
            self._fault(f"wrong totals in a rebuilt report {problem}")

    def _finish(self) -> None:
        """Resume until every test has a result, and a session came to its own end, at which it judges its gates.

        This report is that of the session without a break.
        """
        for number in range(RESUMES):
            report = self._resumed(self.workers_s if number < 2 else 0.0)
            if report is not None and not report.not_run and report.gates is not None:
                self.tally.counts["resumed to the end"] += 1
                if timeless(report) != timeless(self.whole):
                    self._fault(f"the final report differs in {differing(timeless(report), timeless(self.whole))}")
                return
        self._fault(f"not at its end after {RESUMES} resumed sessions")

    def _resumed(self, workers_s: float) -> Report | None:
        """The report of a resumed session, which nobody kills; None where no test began, as xdist had no worker."""
        before = self._begun()
        status, output = self.victim.run("--hri-resume", workers_s=workers_s)
        journal = self._check_lost()
        if journal is None or journal.declared is None or self._begun() == before:
            return None
        try:
            report = load(self.report)
        except ReportError as error:
            self._fault(f"status {status}, no report: {error}\n{output}")
            return None
        if status == 0 and report.not_run:
            self._fault(f"exit status 0, and {report.not_run} tests were not run")
        return report

    def _begun(self) -> list[StartRecord]:
        journal = self.report / NAME
        return read(journal).began if journal.is_file() else []

    def _fault(self, text: str) -> None:
        self.tally.faults.append(f"{self.mode}, trial {self.seed}: {text}")


def timeless(report: Report) -> dict[str, Any]:
    """A report without wall times and its origin; a suite that came from the cache took no time."""
    plain: dict[str, Any] = msgspec.to_builtins(report)
    plain.pop("origin", None)
    for timed in (plain, *plain["tests"], *(suite["generation"] for suite in plain["suites"])):
        timed.pop("wall_s")
        timed.pop("cached", None)
    return plain


def differing(first: dict[str, Any], other: dict[str, Any]) -> str:
    """The keys in which two reports differ."""
    return ", ".join(sorted(key for key in first.keys() | other.keys() if first.get(key) != other.get(key)))


def whole(folder: Path, mode: str) -> Report:
    """The report of a session without a break. Raises ReportError where there is none."""
    shutil.rmtree(folder / "hri-report", ignore_errors=True)
    Victim(folder, MODES[mode], random.Random(0)).run()
    return load(folder / "hri-report" / REPORT_NAME)
