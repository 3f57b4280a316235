"""`--hri-history`: `TrendFeature` appends the figures of a session to a file (`append`).

It also reports what changed since the session before (`changes`); `TrendView` shows this and earlier sessions.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from pytest_hricdv._base.input_file import MAX_REPORT_BYTES, MalformedError, read_bytes
from pytest_hricdv._base.message import visible
from pytest_hricdv._base.record import Count, Names, NotNegative, Percent, PlainRecord
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.section import Section, failure_causes
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.report.formatting import Line
    from pytest_hricdv.results.model import Report

_MAX_NAMED = 200  # maximum number of failing tests to store of a session
_MAX_SHOWN = 60  # maximum number of sessions to show in a report


class HistoryVerdicts(PlainRecord, frozen=True, kw_only=True):
    """Tests by verdict of a requirement, over all suites, and how often it was triggered."""

    passed: Count
    failed: Count
    nc: Count
    triggers: Count


class HistoryEntry(PlainRecord, frozen=True, kw_only=True):
    """The figures of one session.

    Args:
        began: date and time (UTC, ISO 8601).
        revision: the revision of the project's repository; empty if there is none.
        dirty: whether tracked files were changed.
        compared_by: testbench, suites with seeds, and options, which are equal in sessions that are compared.
        complete: whether all tests of the suites ran.
        causes: why tests fail, except for known violations: id -> words; None if nobody looked for it.
        failing: ids of tests that failed or could not be run, the first of them.
        statements: covered by all suites together, per cent of the reachable ones; None: unmeasured. So are branches.
        plans: per cent, of the first suite.
        cross: per cent of possible bins, of the first suite.
    """

    began: str
    revision: str = ""
    dirty: bool = False
    compared_by: str = ""
    complete: bool = True
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

    @staticmethod
    def of(report: Report, *, is_whole: bool) -> HistoryEntry:
        """What a history keeps of a report, which has an origin.

        Args:
            is_whole: whether all tests of its suites ran.
        """
        from pytest_hricdv.results.derivation import code_covered

        origin, suites = report.origin, report.suites
        assert origin is not None
        seeds = (f"{suite.name}:{suite.seed}" for suite in suites)
        plans = [agent for suite in suites[:1] for agent in suite.plans.values()]
        cross = suites[0].cross if suites else None
        return HistoryEntry(
            began=origin.began,
            revision=origin.revision,
            dirty=origin.dirty,
            compared_by=" ".join([report.testbench, *seeds, *report.rerun_options.options, report.shard]),
            complete=is_whole,
            tests=report.reported,
            outcomes=dict(sorted(Counter(test.outcome for test in report.tests).items())),
            causes=failure_causes(report),
            failing=tuple(sorted(test.id for test in report.tests if test.fails))[:_MAX_NAMED],
            requirements={name: _verdicts(report, name) for name in report.requirements},
            statements=_percent(*code_covered(report, "statements")),
            branches=_percent(*code_covered(report, "branches")),
            plans=_percent(sum(len(agent.covered) for agent in plans), sum(agent.total for agent in plans)),
            cross=_percent(cross.hit, cross.possible) if cross is not None else None,
            sim_s=round(sum(test.sim_s for test in report.tests), 3),
            wall_s=report.wall_s,
        )


def _verdicts(report: Report, name: str) -> HistoryVerdicts:
    tallies = [suite.requirements[name] for suite in report.suites if name in suite.requirements]
    return HistoryVerdicts(
        passed=sum(tally.passed for tally in tallies),
        failed=sum(tally.failed for tally in tallies),
        nc=sum(tally.nc for tally in tallies),
        triggers=sum(tally.triggers for tally in tallies),
    )


def _percent(part: int, whole: int) -> float | None:
    return round(100.0 * part / whole, 2) if whole else None


HISTORY: Section[tuple[HistoryEntry, ...]] = Section("history", tuple[HistoryEntry, ...], ())
"""Earlier sessions of the same suites and options, and this one; a merged report has none."""

SECTIONS = (HISTORY,)


def append(path: Path, entry: HistoryEntry) -> None:
    """Add a line, in one write, so that concurrent sessions do not mix theirs.

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


def _is_torn(path: Path) -> bool:
    """Whether the last line is incomplete because its session was killed."""
    try:
        with path.open("rb") as file:
            if file.seek(0, os.SEEK_END) == 0:
                return False
            file.seek(-1, os.SEEK_END)
            return file.read(1) != b"\n"
    except FileNotFoundError:
        return False


def read(path: Path) -> tuple[list[HistoryEntry], list[int]]:
    """The entries of a history, in order, and the numbers (from 1) of lines that are none.

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


def _is_of_others(path: Path) -> bool:
    """Whether a file has lines, and none that a session has written. One that cannot be read is told later."""
    try:
        entries, damaged = read(path)
    except (OSError, MalformedError):
        return False
    return bool(damaged) and not entries


def _comparable(entries: Iterable[HistoryEntry], entry: HistoryEntry) -> tuple[HistoryEntry, ...]:
    """The last complete sessions of the same suites and options."""
    same = [earlier for earlier in entries if earlier.complete and earlier.compared_by == entry.compared_by]
    return tuple(same[-_MAX_SHOWN:])


def changes(entries: Sequence[HistoryEntry]) -> list[str]:
    """Differences between the last session and the one before, a sentence each."""
    if len(entries) < 2:
        return []
    before, now = entries[-2], entries[-1]
    sentences = compare_causes(entries)
    new, gone = set(now.failing) - set(before.failing), set(before.failing) - set(now.failing)
    sentences += [f"fails now: {name}" for name in sorted(new)] + [f"fails no longer: {name}" for name in sorted(gone)]
    for measure in ("statements", "branches", "plans", "cross"):
        old, value = getattr(before, measure), getattr(now, measure)
        if old is not None and value is not None and round(old, 1) != round(value, 1):
            sentences.append(f"{'cross products' if measure == 'cross' else measure}: {old:.1f} % -> {value:.1f} %")
    for name in sorted(before.requirements.keys() | now.requirements.keys()):
        then, here = before.requirements.get(name), now.requirements.get(name)
        if then is None or here is None:
            sentences.append(f"{name} is {'new' if then is None else 'gone'}")
        elif (then.failed, then.nc) != (here.failed, here.nc):
            sentences.append(f"{name}: failed {then.failed} -> {here.failed}, not checked {then.nc} -> {here.nc}")
    if before.tests != now.tests:
        sentences.append(f"tests: {before.tests} -> {now.tests}")
    return sentences


def compare_causes(entries: Sequence[HistoryEntry]) -> list[str]:
    """Causes that are new in the last session, that the session before had too, and that are gone."""
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


class TrendFeature(Feature[Path]):
    """Keeps a history of sessions."""

    name = "trend"
    group = "files"
    options = (
        Value("history", "FILE", "add a line on this session to FILE (JSON lines), and report the trend over sessions"),
    )

    def read(self, reader: OptionReader) -> Path | None:
        """The file of the history."""
        path = reader.file("history")
        if path is not None and path.is_file() and _is_of_others(path):
            raise usage_error(
                f"--hri-history: {visible(str(path))} is not a history file, and a line would be appended to it; "
                "name another file"
            )
        return path

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Add the session to the history, and earlier ones of the same suites and options to its report.

        A session that did not run whole suites is kept in the file, and compared with nothing.
        """
        path = self.settings(session.options)
        if path is None:
            return report
        entry = HistoryEntry.of(report, is_whole=session.is_whole)
        try:
            earlier, damaged = read(path)
            append(path, entry)
        except (OSError, MalformedError) as error:
            reason = error.strerror or error if isinstance(error, OSError) else error
            session.problems.append(visible(f"--hri-history: {path}: {reason}"))
            return report
        session.warnings += [f"{path}:{number}: not a session of a history, so it was left out" for number in damaged]
        return HISTORY.put(report, (*_comparable(earlier, entry), entry) if session.is_whole else ())


FEATURE = TrendFeature()


class TrendView(View):
    """The view of figures over sessions."""

    name = "trend"
    scripts = ("trend",)

    def findings(self, report: Report) -> Iterator[Line]:
        """Causes that are new, that were there before, and that are gone."""
        from pytest_hricdv.report.formatting import Line

        for text in compare_causes(HISTORY.of(report)):
            yield Line(visible(f"trend: {text}"), "ok" if text.startswith("gone") else "warn")

    def section(self, report: Report) -> PageSection | None:
        """What changed since the session before, and plots."""
        from pytest_hricdv.report.tests_view import anchor

        history = HISTORY.of(report)
        if not history:
            return None
        texts = changes(history)
        values = {
            "history": history,
            "meaning": meaning(history, len(texts)),
            "changes": [_separate_test(text) for text in texts],
            "anchors": {test.id: anchor(test.nodeid) for test in report.tests},
        }
        return PageSection("trend", "Trend", "trend/trend.html.jinja", values)

    def data(self, report: Report) -> dict[str, Any]:
        """The sessions, for the plots."""
        return {"history": msgspec.to_builtins(HISTORY.of(report))}


VIEW = TrendView()


def meaning(history: Sequence[HistoryEntry], changed: int) -> str:
    """`Since the session before, 2 tests fail that did not; 3 differences in all.`.

    Args:
        history: the sessions, this one last.
        changed: number of differences since the session before.
    """
    from pytest_hricdv.report.formatting import plural

    if len(history) < 2:
        return "This is the first session of these suites and options: there is none to compare it with."
    if not changed:
        return "Since the session before, nothing but times changed."
    before, now = (set(entry.failing) for entry in history[-2:])
    counts = [(len(now - before), "that did not"), (len(before - now), "no longer")]
    parts = [f"{plural(count, 'test')} {'fails' if count == 1 else 'fail'} {words}" for count, words in counts if count]
    failing = ", ".join(parts) or "no test came to fail"
    return f"Since the session before, {failing}; {plural(changed, 'difference')} in all."


def _separate_test(text: str) -> tuple[str, str]:
    """A sentence of `changes` without the test that it ends with, and this test; empty if it names none."""
    what, separator, name = text.partition(": ")
    return (f"{what}: ", name) if separator and what in ("fails now", "fails no longer") else (text, "")
