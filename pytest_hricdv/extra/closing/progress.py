"""What a closing loop tells while it runs, and at its end."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.extra.closing.archive import GIVEN, Archive
from pytest_hricdv.extra.closing.records import ClosingEnd
from pytest_hricdv.extra.closing.targets import by_kind
from pytest_hricdv.session.collection import Collection

STEPS = 10
"""Where there is no terminal to rewrite a line on, progress is told so many times. Chosen: a log has ten lines of it;
no result depends on it."""


def listed(archive: Archive) -> str:
    """`12 statements, 3 branches`: what is open."""
    counts = by_kind(archive.open)
    named = (f"{count} {kind if count == 1 else _PLURAL.get(kind, f'{kind}s')}" for kind, count in counts.items())
    return ", ".join(named) or "nothing"


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
        text = f"hricdv: {done} of {self._runs} runs, {archive.sim_s:.0f} s simulated, open: {listed(archive)}"
        if not self._collection.rewrite(text) and done * STEPS // self._runs > self._told:
            self._told = done * STEPS // self._runs
            self._collection.say(text)

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
