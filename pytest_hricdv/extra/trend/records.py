"""The history of sessions: a line of JSON each, in a file that outlives reports."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import msgspec

from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, read_bytes
from pytest_hricdv._base.record import Count, Names, NotNegative, Percent, PlainRecord
from pytest_hricdv.results.section import Section

MOST_NAMED = 200
"""So many failing tests of a session are named: more than people read."""

MOST_SHOWN = 60
"""So many sessions are on the page of a report."""


class HistoryVerdicts(PlainRecord, frozen=True, kw_only=True):
    """Tests by verdict of a requirement, over all suites, and how often it was triggered."""

    passed: Count
    failed: Count
    nc: Count
    triggers: Count


class HistoryEntry(PlainRecord, frozen=True, kw_only=True):
    """One session.

    Args:
        began: date and time (UTC, ISO 8601).
        revision: of the project's repository; empty where there is none.
        dirty: tracked files were changed.
        compared_by: what has to be the same for sessions to be compared: testbench, suites with seeds, and options.
        whole: all tests of the suites ran.
        tests: how many ran.
        outcomes: how many tests had each outcome.
        causes: what tests fail for, beside known violations: id -> words; None where nobody looked for it.
        failing: ids of tests that failed or could not be run, at most `MOST_NAMED`.
        statements: covered by all suites together, per cent of the reachable ones; None: unmeasured. So are branches.
        plans: per cent, of the first suite.
        cross: per cent of possible bins, of the first suite.
    """

    began: str
    revision: str = ""
    dirty: bool = False
    compared_by: str = ""
    whole: bool = True
    tests: Count = 0
    outcomes: Mapping[str, Count] = {}
    causes: Mapping[str, str] | None = None
    failing: Names = ()
    requirements: Mapping[str, HistoryVerdicts] = {}
    statements: Percent | None = None
    branches: Percent | None = None
    plans: Percent | None = None
    cross: Percent | None = None
    sim_s: NotNegative = 0.0
    wall_s: NotNegative = 0.0


def append(path: Path, entry: HistoryEntry) -> None:
    """Add a line, at once: sessions at the same time do not mix theirs.

    Raises:
        OSError: the file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    line = msgspec.json.encode(entry) + b"\n"
    if _is_torn(path):
        line = b"\n" + line
    file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    try:
        os.write(file, line)
    finally:
        os.close(file)


def read(path: Path) -> tuple[list[HistoryEntry], list[int]]:
    """The entries of a history, in order, and the lines (from 1) that are none.

    Raises:
        OSError, MalformedError: the file cannot be read.
    """
    if not path.exists():
        return [], []
    entries: list[HistoryEntry] = []
    damaged: list[int] = []
    for number, line in enumerate(read_bytes(path, MAX_REPORT_BYTES).splitlines(), 1):
        if line.strip():
            try:
                entries.append(msgspec.json.decode(line, type=HistoryEntry))
            except (msgspec.MsgspecError, RecursionError):
                damaged.append(number)
    return entries, damaged


def comparable(entries: Iterable[HistoryEntry], entry: HistoryEntry) -> tuple[HistoryEntry, ...]:
    """Earlier whole sessions of the same suites and options, the last `MOST_SHOWN`."""
    same = [earlier for earlier in entries if earlier.whole and earlier.compared_by == entry.compared_by]
    return tuple(same[-MOST_SHOWN:])


def changes(entries: Sequence[HistoryEntry]) -> list[str]:
    """What is otherwise in the last session than in the one before, a sentence each."""
    if len(entries) < 2:
        return []
    before, now = entries[-2], entries[-1]
    sentences = changed_causes(entries)
    new, gone = set(now.failing) - set(before.failing), set(before.failing) - set(now.failing)
    sentences += [f"fails now: {name}" for name in sorted(new)] + [f"fails no longer: {name}" for name in sorted(gone)]
    for kind in ("statements", "branches", "plans", "cross"):
        old, value = getattr(before, kind), getattr(now, kind)
        if old is not None and value is not None and round(old, 1) != round(value, 1):
            sentences.append(f"{'cross products' if kind == 'cross' else kind}: {old:.1f} % -> {value:.1f} %")
    for name in sorted(before.requirements.keys() | now.requirements.keys()):
        then, here = before.requirements.get(name), now.requirements.get(name)
        if then is None or here is None:
            sentences.append(f"{name} is {'new' if then is None else 'gone'}")
        elif (then.failed, then.nc) != (here.failed, here.nc):
            sentences.append(f"{name}: failed {then.failed} -> {here.failed}, not checked {then.nc} -> {here.nc}")
    if before.tests != now.tests:
        sentences.append(f"tests: {before.tests} -> {now.tests}")
    return sentences


def changed_causes(entries: Sequence[HistoryEntry]) -> list[str]:
    """The causes that are new in the last session, those that it has as before, and those that are gone."""
    if len(entries) < 2 or (now := entries[-1].causes) is None:
        return []
    earlier = [entry for entry in entries[:-1] if entry.causes is not None]
    before = (earlier[-1].causes if earlier else None) or {}
    sentences: list[str] = []
    for name, words in now.items() if earlier else ():
        had = [entry for entry in earlier if name in (entry.causes or {})]
        if name in before:
            sentences.append(f"cause {name} since {had[0].began[:10]}: {words}")
        else:
            sentences.append(f"{'again' if had else 'new'}: cause {name}: {words}")
    return sentences + [f"gone: cause {name}: {words}" for name, words in before.items() if name not in now]


def _is_torn(path: Path) -> bool:
    """Whether the last line has no end: its session was killed."""
    try:
        with path.open("rb") as file:
            if file.seek(0, os.SEEK_END) == 0:
                return False
            file.seek(-1, os.SEEK_END)
            return file.read(1) != b"\n"
    except FileNotFoundError:
        return False


HISTORY: Section[tuple[HistoryEntry, ...]] = Section("history", tuple[HistoryEntry, ...], ())
"""Earlier sessions of the same suites and options, and this one; a merged report has none."""

SECTIONS = (HISTORY,)
