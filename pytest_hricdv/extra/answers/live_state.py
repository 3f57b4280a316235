"""How far a session, a loop or a campaign is, from what it has written up to now; nothing of it notices."""

from __future__ import annotations

import datetime
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from msgspec.structs import replace

from pytest_hricdv.registry import offers
from pytest_hricdv.report import html
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.formatting import natural, plural
from pytest_hricdv.report.verdict import verdict
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, load
from pytest_hricdv.results.journal import NAME, Journal, ResultRecord, records
from pytest_hricdv.results.loop_progress import NAME as LOOP
from pytest_hricdv.results.loop_progress import LoopProgress, told
from pytest_hricdv.results.model import Report
from pytest_hricdv.results.report_builder import rebuild
from pytest_hricdv.session.progress import ENOUGH, time_left

SHARE = 0.1
"""Of the time: so much is spent on looking, at most, where a session is so large that its report takes long."""


@dataclass(frozen=True)
class LiveState:
    """How far it is.

    Args:
        what: session, loop or campaign.
        is_over: whether it has ended.
        report: of what it has done; None where it has no result yet.
        done: tests, or runs.
        total: number of all.
        workers: processes that run them.
        left_s: estimated time to the end; None where nobody knows.
        silent_s: since it wrote something; None where it has ended.
        loop: of a loop.
    """

    what: str
    is_over: bool
    report: Report | None
    done: int
    total: int
    workers: int
    left_s: float | None
    silent_s: float | None = None
    loop: LoopProgress | None = None

    def data(self) -> dict[str, Any]:
        """As the page reads it."""
        return {
            "what": self.what,
            "over": self.is_over,
            "done": self.done,
            "total": self.total,
            "workers": plural(self.workers, "worker") if self.workers else "",
            "left": "" if self.left_s is None or self.is_over else time_left(self.left_s),
            "silent": "" if self.silent_s is None or self.silent_s < 30 else f"silent for {self.silent_s:.0f} s",
            "verdicts": self._verdicts(),
            "causes": [*self._causes()],
            "open": [] if self.loop is None else [plural(count, kind) for kind, count in self.loop.open.items()],
            "has_page": self.report is not None,
        }

    def _verdicts(self) -> list[tuple[str, int, int, int]]:
        """Requirement, how often it passed, failed, and was not checked."""
        if self.loop is not None:
            counts: Mapping[str, Mapping[str, int]] = self.loop.verdicts
            rows = [(name, count.get("Passed", 0), count.get("Failed", 0)) for name, count in counts.items()]
            return [(name, passed, failed, self.done - passed - failed) for name, passed, failed in rows]
        if self.report is None:
            return []
        tallies = [(name, suite.requirements.get(name)) for suite in self.report.suites for name in suite.requirements]
        sums: dict[str, list[int]] = {}
        for name, tally in tallies:
            if tally is not None:
                had = sums.setdefault(name, [0, 0, 0])
                had[0] += tally.passed
                had[1] += tally.failed
                had[2] += max(0, tally.nc)
        return [(name, *sums[name]) for name in sorted(sums, key=natural)]  # type: ignore[misc]

    def _causes(self) -> Iterator[str]:
        if self.loop is not None:
            for name, lines in self.loop.violated.items():
                yield f"{name}: {'; '.join(lines)}"
        elif self.report is not None:
            found = verdict(self.report)
            if found.causes is not None and found.causes.causes:
                yield from (cause.title for cause in found.causes.causes if not cause.is_known)
            else:
                for group in found.new:
                    situation = f" ({group.situation})" if group.situation else ""
                    yield f"{group.requirement}{situation}: {plural(len(group.tests), 'test')}"


class LiveSource:
    """Looks at a report folder, or at the file of a campaign.

    Args:
        path: of it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.version = 0
        self._scratch = TemporaryDirectory(prefix="hricdv-live-")
        self._stamp: object = None
        self._next_s = 0.0
        self._state: LiveState | None = None
        self._files: tuple[int, dict[str, str]] = (0, {})

    def close(self) -> None:
        """Remove what was needed meanwhile."""
        self._scratch.cleanup()

    def state(self) -> LiveState | None:
        """How far it is, read again where it has written something; None where it has not begun.

        Raises:
            ReportError: what it has written cannot be read.
        """
        began_s = time.monotonic()
        stamp = _stamp(self.path)
        if stamp != self._stamp and began_s >= self._next_s:
            self._state = self._look()
            self._stamp = stamp
            self.version += 1
            self._next_s = time.monotonic() + (time.monotonic() - began_s) / SHARE
        return self._state

    def files(self) -> dict[str, str]:
        """The page of what it has done, and the files beside it; empty where there is none."""
        state = self.state()
        if state is None or state.report is None:
            return {}
        if self._files[0] != self.version:
            began_s = time.monotonic()
            page, packs = html.page(state.report)
            self._files = self.version, {**packs, PAGE_NAME: page}
            self._next_s = max(self._next_s, time.monotonic() + (time.monotonic() - began_s) / SHARE)
        return self._files[1]

    def _look(self) -> LiveState | None:
        if not self.path.is_dir():
            for look in offers("live", "look"):
                found = look(self.path, Path(self._scratch.name))
                return LiveState(**found)
            raise ReportError(f"{self.path}: no such report folder")
        loop = told(self.path)
        if loop is not None and not _is_newer(self.path / NAME, self.path / LOOP):
            done_s = loop.wall_s / loop.done if loop.done else None
            left_s = None if done_s is None else done_s * (loop.most - loop.done)
            return LiveState("loop", False, None, loop.done, loop.most, loop.workers, left_s, None, loop)
        try:
            written = records(self.path / NAME)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise ReportError(f"{self.path / NAME}: cannot be read: {error.strerror or error}") from None
        journal = Journal()
        for record in written:
            journal.add(record)
        if journal.is_ended and (self.path / REPORT_NAME).is_file():
            report = load(self.path)
            return LiveState("session", True, report, report.reported, report.selected, report.workers, None)
        finished = [record.at_s for record in written if isinstance(record, ResultRecord)]
        return _of_journal(journal, finished)


def _is_newer(file: Path, other: Path) -> bool:
    """Whether a file is newer, as of a session after a loop that was killed."""
    try:
        return file.stat().st_mtime_ns > other.stat().st_mtime_ns
    except OSError:
        return False


def _of_journal(journal: Journal, finished: Sequence[float]) -> LiveState | None:
    if journal.declared is None:
        return None
    try:
        report, _ = rebuild(journal)
    except ValueError as error:
        raise ReportError(f"{NAME}: no report can be made of it: {error}") from None
    for of_part in offers("merging", "rebuilt"):
        report = of_part(report, journal.kept)
    if not journal.is_ended:
        report = replace(report, problems=())  # it lacks what comes after the tests: that is none yet
    silent_s = _silent_s(journal)
    return LiveState(
        what="session",
        is_over=journal.is_ended,
        report=report,
        done=report.reported,
        total=report.selected,
        workers=report.workers,
        left_s=_left_s(report, [*journal.results], finished, silent_s or 0.0),
        silent_s=silent_s,
    )


def _left_s(report: Report, done: Sequence[str], finished: Sequence[float], since_s: float) -> float | None:
    """As the status line estimates it: a test takes as long as its person acts.

    Args:
        report: of what was done.
        done: node ids of the tests that have a result, in their order.
        finished: when tests got it (s), likewise.
        since_s: time since then.
    """
    if len(finished) < ENOUGH + 1 or len(done) < ENOUGH + 1:  # nobody knows when the first one began
        return None
    actions = {test.nodeid: 1 + len(test.abstract) for test in report.tests}
    rate_s = (finished[-1] - finished[0]) / sum(actions[name] for name in done[1:])
    return max(0.0, rate_s * sum(actions[name] for name in report.not_run_tests) - since_s)


def _silent_s(journal: Journal) -> float | None:
    if journal.is_ended or not journal.began:
        return None
    began = datetime.datetime.fromisoformat(journal.began[-1].utc)
    elapsed_s = (datetime.datetime.now(datetime.UTC) - began).total_seconds()
    return max(0.0, elapsed_s - (journal.wall_s - journal.earlier_s))


def _stamp(path: Path) -> tuple[tuple[str, int, int], ...]:
    """Changes when something was written, and when files come and go."""
    found = []
    names = ("", NAME, LOOP, REPORT_NAME) if path.is_dir() else ("", "-wal")
    for name in names:
        file = path / name if path.is_dir() and name else Path(f"{path}{name}") if name else path
        try:
            status = os.stat(file)
        except OSError:
            continue
        found.append((name, status.st_mtime_ns, status.st_size))
    return tuple(found)
