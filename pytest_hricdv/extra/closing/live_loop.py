"""The progress of a running loop, for viewers: a small file in the report folder, written after each generation."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

from pytest_hricdv.extra.closing.archive import GIVEN, Archive, ArchivedRun
from pytest_hricdv.extra.closing.targets import by_kind, count_texts
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.loop_progress import LoopProgress, remove_progress, write_progress


class LiveLoop:
    """Counts verdicts and violations of runs as they come.

    Args:
        folder: of the report.
        runs: budget of the loop.
        workers: processes that run tests.
    """

    def __init__(self, folder: Path, runs: int, workers: int) -> None:
        self._folder, self._runs, self._workers = folder, runs, workers
        self._began_s = time.monotonic()
        self._seen = 0
        self._verdicts: dict[str, Counter[str]] = {}
        self._violated: dict[str, ArchivedRun] = {}

    def show(self, archive: Archive) -> None:
        """Show the progress after a generation."""
        for entry in archive.entries[self._seen :]:
            for kind, *rest in entry.observation.points:
                if kind == "verdict":
                    self._verdicts.setdefault(rest[0], Counter())[rest[1]] += 1
            for name in entry.observation.failed:
                shortest = self._violated.setdefault(name, entry)
                self._violated[name] = min(shortest, entry, key=lambda run: len(run.test.lines))
        self._seen = len(archive.entries)
        counts = [(name, self._verdicts[name]) for name in sorted(self._verdicts, key=natural)]
        progress = LoopProgress(
            done=sum(entry.strategy != GIVEN for entry in archive.entries),
            most=self._runs,
            workers=self._workers,
            wall_s=round(time.monotonic() - self._began_s, 3),
            verdicts=tuple(
                (name, count["Passed"], count["Failed"], self._seen - count["Passed"] - count["Failed"])
                for name, count in counts
            ),
            causes=tuple(f"{name}: {'; '.join(entry.test.lines)}" for name, entry in self._violated.items()),
            open=tuple(count_texts(by_kind(archive.open))),
        )
        write_progress(self._folder, progress)

    def end(self) -> None:
        """The loop has ended."""
        remove_progress(self._folder)
