"""What a closing loop tells while it runs, and at its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_hricdv.extra.closing.archive import GIVEN, Archive
from pytest_hricdv.extra.closing.records import ClosingEnd
from pytest_hricdv.extra.closing.targets import by_kind
from pytest_hricdv.session.collection import Collection

STEPS = 10
"""Where there is no terminal to rewrite a line on, progress is told so many times. Chosen: a log has ten lines of it;
no result depends on it."""


def listed(archive: Archive) -> str:
    """`12 statements, 3 branches`: what is open."""
    return ", ".join(_named(by_kind(archive.open))) or "nothing"


def progress_texts(done: int, runs: int, sim_s: float, open_counts: Mapping[str, int]) -> list[str]:
    """How far a loop is, the fullest text first: for a narrow terminal, each leaves out what matters less.

    First the simulated time, then one kind of open point after the other, of which the number stays.
    """
    start, named = f"hricdv: {done} of {runs} runs", _named(open_counts)
    if not named:
        return [f"{start}, {sim_s:.0f} s simulated, open: nothing", f"{start}, open: nothing", start]
    counts = list(open_counts.values())
    fewer = [", ".join([*named[:shown], f"{sum(counts[shown:])} more"]) for shown in range(len(named) - 1, 0, -1)]
    whole = ", ".join(named)
    opened = [f"{start}, open: {text}" for text in (whole, *fewer, str(sum(counts)))]
    return [f"{start}, {sim_s:.0f} s simulated, open: {whole}", *opened, start]


def _named(counts: Mapping[str, int]) -> list[str]:
    return [f"{count} {kind if count == 1 else _PLURAL.get(kind, f'{kind}s')}" for kind, count in counts.items()]


_PLURAL = {"branch": "branches"}


class ClosingProgress:
    """Tells how far the loop is."""

    def __init__(self, collection: Collection, runs: int) -> None:
        self._collection = collection
        self._runs = runs
        self._told = 0

    def show(self, archive: Archive) -> None:
        """After a generation."""
        done = sum(entry.way != GIVEN for entry in archive.entries)
        texts = progress_texts(done, self._runs, archive.sim_s, by_kind(archive.open))
        if not self._collection.rewrite(texts) and done * STEPS // self._runs > self._told:
            self._told = done * STEPS // self._runs
            self._collection.say(texts[0])

    def end(self, archive: Archive, ended: ClosingEnd, faults: Sequence[str], tests: int, *, goes_on: bool) -> None:
        """At the end. `goes_on`: its tests run now."""
        done = sum(entry.way != GIVEN for entry in archive.entries)
        self._collection.say(
            f"hricdv: closing ended ({ended}) after {done} runs, {archive.sim_s:.0f} s simulated; "
            f"open: {listed(archive)}; {tests} tests"
        )
        for fault in faults:
            self._collection.say(f"hricdv: {fault}")
        if ended == "interrupted" and goes_on:
            self._collection.say("hricdv: what was reached until Ctrl-C is kept and runs now; Ctrl-C again ends all")
