"""Judges logs message by message. Without data for a requirement, its verdict is unknown, never passed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

from msgspec.structs import replace

from pytest_hricdv.execution.run_monitors import mark_outside
from pytest_hricdv.extra.logs.log_map import ActionSource, CrossSource
from pytest_hricdv.extra.logs.log_picture import LogPicture
from pytest_hricdv.extra.logs.logged_actions import LoggedActions
from pytest_hricdv.extra.logs.logged_run import LoggedRun, LogReader, Span, spans_between
from pytest_hricdv.monitor.analysis import names_of, names_read, topics_of, topics_read
from pytest_hricdv.monitor.antecedent import NearMissSearch
from pytest_hricdv.monitor.evaluation_state import nanoseconds
from pytest_hricdv.monitor.formula_monitor import ConditionMonitor
from pytest_hricdv.monitor.logged import masked, what_masks
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import NearMiss, Verdict
from pytest_hricdv.recordings.bags import Value
from pytest_hricdv.report.formatting import plural

MAX_KEPT = 1000
"""Violations and triggers of a requirement that are kept; further ones are counted."""


@dataclass
class JudgedRun:
    """A run with its verdicts.

    Args:
        run: the run.
        picture: its timeline; None if it is not drawn.
        verdicts: requirement -> verdict over all stretches that have data; NC if it is unknown and did not fail.
        unknown: requirement -> why data for it are missing.
        hits: cross product -> its hits, as pairs of coordinates and bins.
        commands: what people did.
    """

    run: LoggedRun
    picture: LogPicture | None
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    unknown: dict[str, str] = field(default_factory=dict)
    hits: dict[str, set[tuple[tuple[str, str], ...]]] = field(default_factory=dict)
    commands: set[str] = field(default_factory=set)

    def word(self, requirement: str) -> str:
        """Passed, Failed, NC or unknown."""
        verdict = self.verdicts[requirement].verdict
        return "unknown" if requirement in self.unknown and verdict != "Failed" else verdict


def judge(
    reader: LogReader,
    requirements: Sequence[Requirement],
    known_when: Mapping[str, PastFormula] | None = None,
    actions: LoggedActions | None = None,
    *,
    draws: bool = False,
) -> list[JudgedRun]:
    """Judge the runs of a log.

    Args:
        reader: of the log.
        requirements: of the testbench.
        known_when: requirement -> the condition under which its violation is known.
        actions: to collect the commands of people; None to ignore them.
        draws: whether to draw timelines.

    Raises:
        MonitorError: the log has a value that no requirement can be judged by.
        InputError: a message lacks a field that the map names, or it is of another type.
    """
    runs = reader.runs()
    judged = [JudgedRun(run, LogPicture(run.end_s) if draws else None) for run in runs]
    judges = [_judges(reader, run, requirements, known_when) for run in runs]
    if any(judges) or reader.made.cross or actions is not None:
        _read(reader, judged, judges, actions)
    for each in (each for mine in judges for each in mine):
        each.finish()
    misses = _near_misses(reader, runs, judges)
    for number, made in enumerate(judged):
        _add_verdicts(made, requirements, judges[number], misses.get(number, {}))
    return judged


def _read(
    reader: LogReader,
    judged: Sequence[JudgedRun],
    judges: Sequence[Sequence[StretchJudge]],
    actions: LoggedActions | None,
) -> None:
    """Read the log once, for all judges of its runs."""
    readers = [_by_name(each, reader) for each in judges]
    for part, time_s, event, value in reader.events([made.run for made in judged]):
        made = judged[part]
        if event.is_judged:
            for read in readers[part].get(event.name, ()):
                read(time_s, event.name, value)
            if made.picture is not None:
                made.picture.add(time_s, event.name, value)
        elif isinstance(event.source, CrossSource):
            made.hits.setdefault(event.name, set()).add(tuple(value.items()))  # type: ignore[arg-type, union-attr]
        elif isinstance(event.source, ActionSource) and actions is not None:
            made.commands.add(actions.command(made.run.name, event.source, value))  # type: ignore[arg-type]


def _by_name(judges: Sequence[StretchJudge], reader: LogReader) -> dict[str, list[Callable[[float, str, Any], None]]]:
    """Signal or message -> the functions that take its values."""
    by_name: dict[str, list[Callable[[float, str, Any], None]]] = {}
    for each in judges:
        for name in each.reads:
            by_name.setdefault(name, []).append(each.signal if name in reader.made.signals else each.message)
    return by_name


def reads(requirement: Requirement) -> frozenset[str]:
    """The signals and messages that a requirement reads."""
    signals = (name for name in names_read(requirement.formula) if "." not in name)
    return frozenset((*signals, *requirement.shows, *topics_read(requirement.formula)))


def _judges(
    reader: LogReader, run: LoggedRun, requirements: Sequence[Requirement], known: Mapping[str, PastFormula] | None
) -> list[StretchJudge]:
    """A judge for each set of requirements with the same stretches."""
    groups: dict[tuple[Span, ...], list[Requirement]] = {}
    for requirement in requirements:
        names = reads(requirement)
        if names & run.missing:
            continue
        begin_s = 0.0 if reader.made.is_own else run.known_from_s(names, reader.made)
        gaps = [span for name in names & run.gaps.keys() for span in run.gaps[name]]
        groups.setdefault(spans_between(gaps, begin_s, run.end_s), []).append(requirement)
    lacks = run.gaps.keys() | run.missing
    conditions = {
        name: None if _names_of(condition) & lacks else condition for name, condition in (known or {}).items()
    }
    return [StretchJudge(tuple(members), spans, conditions) for spans, members in groups.items()]


def _names_of(condition: PastFormula) -> frozenset[str]:
    return frozenset((*(name for name in names_of([condition]) if "." not in name), *topics_of([condition])))


class StretchJudge:
    """Judges requirements over the stretches of a run between the gaps in their data.

    A stretch begins with the last values of the signals before it.
    """

    def __init__(
        self, requirements: tuple[Requirement, ...], spans: Sequence[Span], known: Mapping[str, PastFormula | None]
    ) -> None:
        self.requirements = requirements
        self._known = {requirement.id: known[requirement.id] for requirement in requirements if requirement.id in known}
        conditions = (_names_of(condition) for condition in self._known.values() if condition is not None)
        self.reads = frozenset().union(*map(reads, requirements), *conditions)
        self.verdicts: list[tuple[Verdict, ...]] = []
        self._spans, self._is_whole = deque(spans), len(spans) == 1
        self._masks = {
            requirement.id: what for requirement in requirements if (what := what_masks(requirement.formula))
        }
        self._masking = frozenset(topic for what in self._masks.values() for topic in what)
        self._values: dict[str, bool | float | str] = {}
        self._next()

    def _next(self) -> None:
        self._begin_s, self._end_s = self._spans.popleft() if self._spans else (float("inf"), float("inf"))
        self._monitors: MonitorSet | None = None
        self._conditions: dict[str, ConditionMonitor] = {}
        self._instant: tuple[float, dict[str, list[Mapping[str, Value]]]] = (-1.0, {})
        self._masked: dict[str, dict[str, int]] = {}

    def signal(self, time_s: float, name: str, value: bool | float | str) -> None:
        """Take a new value of a signal."""
        while time_s > self._end_s:
            self._close()
        if time_s >= self._begin_s:
            (self._monitors or self._open()).signal(time_s, name, value)
        if self._spans or self._monitors is None:
            self._values[name] = value

    def message(self, time_s: float, name: str, fields: Mapping[str, Value]) -> None:
        """Take a message."""
        while time_s > self._end_s:
            self._close()
        if time_s >= self._begin_s:
            (self._monitors or self._open()).message(time_s, name, fields)
            if name in self._masking:
                self._note_message(time_s, name, fields)

    def _open(self) -> MonitorSet:
        monitors = self._monitors = MonitorSet(self.requirements, most=MAX_KEPT)
        conditions = self._known.items()
        self._conditions = {name: monitors.watch(when) for name, when in conditions if when is not None}
        for name, value in self._values.items():
            monitors.signal(self._begin_s, name, value)
        monitors.advance(self._begin_s)
        return monitors

    def _note_message(self, time_s: float, name: str, fields: Mapping[str, Value]) -> None:
        if time_s != self._instant[0]:
            self._count_masked()
            self._instant = (time_s, {})
        self._instant[1].setdefault(name, []).append(fields)

    def _count_masked(self) -> None:
        for topic, messages in self._instant[1].items():
            for requirement, what in self._masks.items() if len(messages) > 1 else ():
                if topic in what and (count := masked(messages, *what[topic])):
                    counts = self._masked.setdefault(requirement, {})
                    counts[topic] = counts.get(topic, 0) + count

    def _close(self) -> None:
        """Add the verdicts on the present stretch; there are none if a signal has no value in it."""
        with suppress(*(() if self._is_whole else (MonitorError,))):
            monitors = self._monitors or self._open()
            self._count_masked()
            verdicts = monitors.finish(self._end_s)
            self.verdicts.append(tuple(map(self._complete, verdicts)))
        self._next()

    def _complete(self, verdict: Verdict) -> Verdict:
        """Add the masked messages, and mark violations that are not known ones."""
        name = verdict.requirement
        verdict = replace(verdict, masked_messages=self._masked.get(name, {}))
        return mark_outside(verdict, self._conditions.get(name)) if name in self._known else verdict

    def finish(self) -> None:
        """End the run."""
        while self._begin_s < float("inf"):
            self._close()

    @property
    def untriggered(self) -> Iterator[Requirement]:
        """The requirements that were never triggered in a run without gaps."""
        if self._is_whole and self.verdicts:
            for requirement, verdict in zip(self.requirements, self.verdicts[0], strict=True):
                if verdict.untriggered:
                    yield requirement


def _near_misses(
    reader: LogReader, runs: list[LoggedRun], judges: Sequence[Sequence[StretchJudge]]
) -> dict[int, dict[str, NearMiss]]:
    """Number of a run -> requirement that was never triggered -> its near miss; in one more pass."""
    searches = {
        number: {
            requirement.id: NearMissSearch(requirement.formula.antecedent)
            for each in mine
            for requirement in each.untriggered
        }
        for number, mine in enumerate(judges)
    }
    if not any(searches.values()):
        return {}
    wanted = {
        name for mine in searches.values() for search in mine.values() for name in (*search.signals, *search.topics)
    }
    ends_ns = [nanoseconds(run.end_s) for run in runs]
    last_ns: list[float] = [-1] * len(runs)
    instants = groupby(reader.events(runs), key=lambda entry: (entry[0], nanoseconds(entry[1])))
    for (part, now_ns), entries in instants:
        updates: list[tuple[str, Any]] = [(event.name, value) for _, _, event, value in entries if event.name in wanted]
        for search in searches[part].values():
            found = [update for update in updates if update[0] in search.topics or update[0] in search.signals]
            if found or last_ns[part] < 0:
                search.add(now_ns, found, last=now_ns == ends_ns[part])
        last_ns[part] = now_ns
    for part, of_run in searches.items():
        for search in of_run.values():
            if last_ns[part] < ends_ns[part]:
                search.add(ends_ns[part], (), last=True)
    return {part: {name: search.nearest() for name, search in mine.items()} for part, mine in searches.items()}


def _add_verdicts(
    made: JudgedRun, requirements: Iterable[Requirement], judges: Sequence[StretchJudge], misses: Mapping[str, NearMiss]
) -> None:
    stretches: dict[str, list[Verdict]] = {}
    for verdict in (verdict for each in judges for verdicts in each.verdicts for verdict in verdicts):
        stretches.setdefault(verdict.requirement, []).append(verdict)
    for requirement in requirements:
        name, parts = requirement.id, stretches.get(requirement.id, [])
        unknown = _unknown(made.run, reads(requirement)) or ("" if parts else "no data")
        if unknown:
            made.unknown[name] = unknown
        elif name in misses:
            parts = [replace(part, near_miss=misses[name]) for part in parts]
        made.verdicts[name] = _join(name, parts) if unknown else parts[0]


def _join(name: str, parts: Sequence[Verdict]) -> Verdict:
    """The verdict over several stretches, or where data are missing: NC unless one fails."""
    margin = min((part.margin for part in parts if part.margin is not None), default=None)
    return Verdict(
        requirement=name,
        verdict="Failed" if any(part.verdict == "Failed" for part in parts) else "NC",
        triggers=sum(part.triggers for part in parts),
        passes=sum(part.passes for part in parts),
        failures=sum(part.failures for part in parts),
        untriggered=int(not any(part.triggers for part in parts)),
        pending=sum(part.pending for part in parts),
        violations=tuple(violation for part in parts for violation in part.violations)[:MAX_KEPT],
        margin=margin,
        margin_time_s=next((part.margin_time_s for part in parts if part.margin == margin), None),
        history=tuple(trigger for part in parts for trigger in part.history)[:MAX_KEPT],
    )


def _unknown(run: LoggedRun, names: frozenset[str]) -> str:
    """Why a requirement that reads these names is unknown; empty if it is not."""
    if absent := sorted(names & run.missing):
        return f"the log has no {' and no '.join(absent)}"
    if unread := sorted(names & run.unread.keys()):
        return f"{plural(run.unread[unread[0]], 'message')} of {unread[0]} cannot be read"
    if infinite := sorted(names & run.infinite.keys()):
        count = run.infinite[infinite[0]]
        return f"{plural(count, 'value')} of {infinite[0]} {'is' if count == 1 else 'are'} not finite"
    gaps = sorted((*span, name) for name in names & run.gaps.keys() for span in run.gaps[name])
    if not gaps:
        return ""
    (from_s, to_s, name), more = gaps[0], len(gaps) - 1
    return f"no data of {name} from {from_s:.3f} to {to_s:.3f} s" + (f", and {more} more gaps" if more else "")
