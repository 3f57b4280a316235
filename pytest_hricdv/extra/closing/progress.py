"""The progress of a closing loop: lines of the terminal, and a small file in the report folder for viewers.

`ClosureGenerator` makes a `ClosingProgress`, and calls it after each generation and at the end of the loop.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence

from pytest_hricdv.extra.closing.records import ClosingEnd
from pytest_hricdv.extra.closing.strategy import GIVEN, Archive, ArchivedRun
from pytest_hricdv.extra.closing.targets import by_kind
from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.folder_files import LoopProgress, write_progress
from pytest_hricdv.session.collection import Collection

STEPS = 10
"""Number of progress messages of a loop if the output is no terminal, where a line could be rewritten."""


def list_open(archive: Archive) -> str:
    """The numbers of open points by kind, as `12 statements, 3 branches`."""
    return ", ".join(count_texts(by_kind(archive.open))) or "nothing"


def progress_texts(done: int, runs: int, sim_s: float, open_counts: Mapping[str, int]) -> list[str]:
    """Texts on the progress of a loop, the longest first: each next one, for narrower terminals, leaves out one more
    part, first the simulated time, then the names of one kind of open points after the other.
    """
    start, named = f"hricdv: {done} of {runs} runs", count_texts(open_counts)
    if not named:
        return [f"{start}, {sim_s:.0f} s simulated, open: nothing", f"{start}, open: nothing", start]
    counts = list(open_counts.values())
    fewer = [", ".join([*named[:shown], f"{sum(counts[shown:])} more"]) for shown in range(len(named) - 1, 0, -1)]
    whole = ", ".join(named)
    opened = [f"{start}, open: {text}" for text in (whole, *fewer, str(sum(counts)))]
    return [f"{start}, {sim_s:.0f} s simulated, open: {whole}", *opened, start]


def count_texts(counts: Mapping[str, int]) -> list[str]:
    """`12 statements`, `1 branch`: the numbers of points by kind."""
    return [f"{count} {kind if count == 1 else _PLURAL.get(kind, f'{kind}s')}" for kind, count in counts.items()]


_PLURAL = {"branch": "branches"}


class ClosingProgress:
    """Shows the progress of a loop with a budget of runs, and counts verdicts and violations as runs end."""

    def __init__(self, collection: Collection, runs: int, workers: int) -> None:
        self._collection, self._runs, self._workers = collection, runs, workers
        self._began_s = time.monotonic()
        self._told = self._seen = 0
        self._verdicts: dict[str, Counter[str]] = {}
        self._violated: dict[str, ArchivedRun] = {}

    def show(self, archive: Archive) -> None:
        """Show the progress after a generation."""
        done = sum(entry.strategy != GIVEN for entry in archive.entries)
        texts = progress_texts(done, self._runs, archive.sim_s, by_kind(archive.open))
        if not self._collection.rewrite(texts) and done * STEPS // self._runs > self._told:
            self._told = done * STEPS // self._runs
            self._collection.say(texts[0])

    def write(self, archive: Archive) -> None:
        """Write the file for viewers."""
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
        write_progress(self._collection.options.report, progress)

    def end(self, archive: Archive, ended: ClosingEnd, faults: Sequence[str], tests: int, *, goes_on: bool) -> None:
        """End the display. `goes_on`: its tests run now."""
        done = sum(entry.strategy != GIVEN for entry in archive.entries)
        self._collection.say(
            f"hricdv: closing ended ({ended}) after {done} runs, {archive.sim_s:.0f} s simulated; "
            f"open: {list_open(archive)}; {tests} tests"
        )
        for fault in faults:
            self._collection.say(f"hricdv: {fault}")
        if ended == "interrupted" and goes_on:
            self._collection.say("hricdv: what was reached until Ctrl-C is kept and runs now; Ctrl-C again ends all")
