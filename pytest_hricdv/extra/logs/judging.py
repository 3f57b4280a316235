"""`judge`: judges logs message by message, for `hricdv check`, and returns a `JudgedRun` for each run.

A requirement without data in a log is unknown, never passed.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
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
from pytest_hricdv.monitor.log import Update
from pytest_hricdv.monitor.logged import count_masked, what_masks
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Verdict
from pytest_hricdv.report.formatting import plural

MAX_KEPT = 1000
"""Maximum number of violations, and of triggers, to keep for a requirement; further ones are only counted."""


@dataclass
class JudgedRun:
    """A run with its verdicts.

    Args:
        picture: the run's timeline; None if it is not drawn.
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
        known_when: requirement -> the condition under which its violation is known.
        actions: collects the commands of people; None to ignore them.
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
    for made, mine in zip(judged, judges, strict=True):
        _add_verdicts(made, requirements, mine)
    return judged


def _read(
    reader: LogReader,
    judged: Sequence[JudgedRun],
    judges: Sequence[Sequence[StretchJudge]],
    actions: LoggedActions | None,
) -> None:
    """Read the log once, for all judges of its runs."""
    readers: list[dict[str, list[Callable[[float, str, Any], None]]]] = [{} for _ in judged]
    for by_name, mine in zip(readers, judges, strict=True):
        for judge in mine:
            for name in judge.reads:
                by_name.setdefault(name, []).append(judge.add)
    for part, time_s, event, value in reader.events([made.run for made in judged]):
        made = judged[part]
        if event.is_judged:
            for add in readers[part].get(event.name, ()):
                add(time_s, event.name, value)
            if made.picture is not None:
                made.picture.add(time_s, event.name, value)
        elif isinstance(event.source, CrossSource):
            made.hits.setdefault(event.name, set()).add(tuple(value.items()))  # type: ignore[arg-type, union-attr]
        elif isinstance(event.source, ActionSource) and actions is not None:
            made.commands.add(actions.command(made.run.name, event.source, value))  # type: ignore[arg-type]


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
        begin_s = 0.0 if reader.made.is_own else run.complete_from_s(names, reader.made)
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
        self.verdicts: list[Verdict] = []
        self._spans, self._is_whole = deque(spans), len(spans) == 1
        self._masks = {requirement.id: what_masks(requirement.formula) for requirement in requirements}
        self._masking = frozenset(topic for topics in self._masks.values() for topic in topics)
        self._searches = {
            requirement.id: NearMissSearch(requirement.formula.antecedent)
            for requirement in requirements
            if self._is_whole
        }
        self._values: dict[str, Any] = {}
        self._next()

    def _next(self) -> None:
        self._begin_s, self._end_s = self._spans.popleft() if self._spans else (math.inf, math.inf)
        self._monitors: MonitorSet | None = None
        self._conditions: dict[str, ConditionMonitor] = {}
        self._masked: dict[str, Counter[str]] = {}
        self._instant_s, self._instant = -math.inf, list[Update]()

    def add(self, time_s: float, name: str, value: Any) -> None:
        """Take a new value of a signal, or a message."""
        while time_s > self._end_s:
            self._close()
        if time_s >= self._begin_s:
            monitors = self._monitors or self._open()
            if type(value) is dict:
                monitors.message(time_s, name, value)
            else:
                monitors.signal(time_s, name, value)
            if self._searches or name in self._masking:
                if time_s != self._instant_s:
                    self._end_instant(time_s)
                self._instant.append((name, value))
        if (self._spans or self._monitors is None) and type(value) is not dict:
            self._values[name] = value

    def _open(self) -> MonitorSet:
        monitors = self._monitors = MonitorSet(self.requirements, most=MAX_KEPT)
        conditions = self._known.items()
        self._conditions = {name: monitors.watch(when) for name, when in conditions if when is not None}
        for name, value in self._values.items():
            monitors.signal(self._begin_s, name, value)
        monitors.advance(self._begin_s)
        self._instant_s, self._instant = self._begin_s, [*self._values.items()]
        return monitors

    def _end_instant(self, next_s: float) -> None:
        """Count masked messages, and search for the near miss of each requirement until it is triggered."""
        time_s, updates = self._instant_s, self._instant
        self._instant_s, self._instant = next_s, []
        messages: dict[str, list[Any]] = {}
        for name, value in updates if len(updates) > 1 else ():
            messages.setdefault(name, []).append(value)
        for requirement, topics in self._masks.items() if messages else ():
            for topic in topics.keys() & messages.keys():
                self._masked.setdefault(requirement, Counter())[topic] += count_masked(messages[topic], *topics[topic])
        for requirement, search in [*self._searches.items()]:
            found = [update for update in updates if update[0] in search.topics or update[0] in search.signals]
            if found or time_s in (self._begin_s, self._end_s):
                search.add(nanoseconds(time_s), found, last=time_s == self._end_s)
            if search.is_met:
                del self._searches[requirement]

    def _close(self) -> None:
        """Add the verdicts on the present stretch; there are none if a signal has no value in it."""
        with suppress(*(() if self._is_whole else (MonitorError,))):
            monitors = self._monitors or self._open()
            if self._instant_s < self._end_s:
                self._end_instant(self._end_s)
            self._end_instant(math.inf)
            self.verdicts += map(self._complete, monitors.finish(self._end_s))
        self._next()

    def _complete(self, verdict: Verdict) -> Verdict:
        """Add masked messages and the near miss, and mark violations that are not known ones."""
        name = verdict.requirement
        counts = {topic: count for topic, count in self._masked.get(name, {}).items() if count}
        miss = self._searches[name].nearest() if verdict.untriggered and name in self._searches else None
        verdict = replace(verdict, masked_messages=counts, near_miss=miss)
        return mark_outside(verdict, self._conditions.get(name)) if name in self._known else verdict

    def finish(self) -> list[Verdict]:
        """The verdicts on all stretches, at the end of the run."""
        while self._begin_s < math.inf:
            self._close()
        return self.verdicts


def _add_verdicts(made: JudgedRun, requirements: Iterable[Requirement], judges: Sequence[StretchJudge]) -> None:
    stretches: dict[str, list[Verdict]] = {}
    for verdict in (verdict for judge in judges for verdict in judge.finish()):
        stretches.setdefault(verdict.requirement, []).append(verdict)
    for requirement in requirements:
        name, parts = requirement.id, stretches.get(requirement.id, [])
        unknown = _unknown(made.run, reads(requirement)) or ("" if parts else "no data")
        if unknown:
            made.unknown[name] = unknown
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
