"""Judges logs. If a log has no data for a requirement, the verdict is unknown, never passed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.logs.log_map import LogMap, SignalSource, TopicSource, field_sources, value_of
from pytest_hricdv.monitor.analysis import names_read, topics_read
from pytest_hricdv.monitor.log import Log, Series
from pytest_hricdv.monitor.logged import evaluate
from pytest_hricdv.monitor.monitor_set import MonitorError
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.verdict import Verdict
from pytest_hricdv.monitor.vocabulary import Vocabulary
from pytest_hricdv.recordings.bags import Value
from pytest_hricdv.recordings.recording import RecordedSample, Recording, is_periodic

GAP_PERIODS = 5.0
"""No message of a periodic topic for so many of its periods is a gap (chosen): recorders lose one or two."""

Span = tuple[float, float]
"""From when to when (s)."""


@dataclass(frozen=True)
class LoggedRun:
    """A part of a log without jumps of its clock.

    Args:
        name: of the log, for people.
        log: its messages and signals, with times since its beginning.
        gaps: signal or message -> when there is no data of it.
        missing: signals and messages that the log does not have at all.
    """

    name: str
    log: Log
    gaps: Mapping[str, tuple[Span, ...]] = field(default_factory=dict)
    missing: frozenset[str] = frozenset()


@dataclass(frozen=True)
class LogVerdict:
    """A verdict on a log: that of the monitors for each stretch that has data, and what makes it unknown, if it is."""

    requirement: str
    stretches: tuple[Verdict, ...]
    unknown: str = ""

    @property
    def verdict(self) -> str:
        """Failed, where any stretch fails; unknown, where data is missing; otherwise that of the monitors."""
        if any(part.verdict == "Failed" for part in self.stretches):
            return "Failed"
        return "unknown" if self.unknown else self.stretches[0].verdict

    @property
    def margin(self) -> float | None:
        """The least of all stretches."""
        return min((part.margin for part in self.stretches if part.margin is not None), default=None)


def runs_of(recording: Recording, made: LogMap, vocabulary: Vocabulary) -> Iterator[LoggedRun]:
    """The parts of a recording as runs.

    Raises:
        InputError: a message lacks a field that the map names, or it is of another type.
    """
    parts = recording.parts
    if made.is_own:
        parts = (tuple(sample for part in parts for sample in part),)
    for number, part in enumerate(parts, 1):
        name = recording.name if len(parts) == 1 else f"{recording.name}, part {number}"
        if part:
            yield _run_of(name, part, made, vocabulary)


def _run_of(name: str, part: Sequence[RecordedSample], made: LogMap, vocabulary: Vocabulary) -> LoggedRun:
    sources = dict(field_sources(made, vocabulary))
    begin_s = 0.0 if made.is_own else min(time_of(sample, made.time) for sample in part)
    messages: list[RecordedSample] = []
    series: dict[str, tuple[list[float], list[Value]]] = {}
    seen: dict[str, list[float]] = {}
    by_topic: dict[str, list[tuple[str, TopicSource]]] = {}
    for own, source in made.sources.items():
        by_topic.setdefault(source.topic, []).append((own, source))
    for sample in part:
        for own, source in by_topic.get(sample.topic, ()):
            time_s = time_of(sample, source.time or made.time) - begin_s
            seen.setdefault(own, []).append(time_s)
            if isinstance(source, SignalSource):
                times, values = series.setdefault(own, ([], []))
                times.append(time_s)
                values.append(value_of(own, sources[own], sample.fields, vocabulary))
                continue
            names = {member: f"{own}.{member}" for member in vocabulary.messages[own]}
            fields = {
                member: value_of(path, sources[path], sample.fields, vocabulary) for member, path in names.items()
            }
            messages.append(RecordedSample(time_s, own, fields))
    end_s = max(time_of(sample, made.time) for sample in part) - begin_s
    end_s = max(end_s, *(times[-1] for times in seen.values()), 0.0) if seen else end_s
    messages.sort(key=lambda message: message.time_s)
    signals: dict[str, Series] = {own: _in_order(*values) for own, values in series.items()}
    gaps: dict[str, tuple[Span, ...]] = {}
    for own, times in seen.items():
        limit_s = made.sources[own].gap_s
        if spans := tuple(_gaps(sorted(times), end_s, made.gap_s if limit_s is None else limit_s)):
            gaps[own] = spans
    needed = {*vocabulary.signals, *(() if made.is_own else vocabulary.messages)}
    return LoggedRun(name, Log(signals, messages, end_s), gaps, frozenset(needed - seen.keys()))


def time_of(sample: RecordedSample, clock: str) -> float:
    """When a message was recorded (s), or the stamp in its header. Raises InputError where it has none."""
    if clock == "log":
        return sample.time_s
    stamp = (sample.fields.get("header.stamp.sec"), sample.fields.get("header.stamp.nanosec"))
    if not (isinstance(stamp[0], float) and isinstance(stamp[1], float)):
        raise InputError(f"{sample.topic}: its messages have no header.stamp, by which their times were to be")
    return stamp[0] + stamp[1] / 1e9


def _in_order(times: Sequence[float], values: Sequence[Value]) -> Series:
    order = sorted(range(len(times)), key=times.__getitem__)
    return [times[n] for n in order], [values[n] for n in order]  # type: ignore[return-value]


def _gaps(times: Sequence[float], end_s: float, limit_s: float | None) -> Iterator[Span]:
    """When there is no data for longer than the limit; up to the first message, and from the last one on."""
    waits = [after - before for before, after in pairwise(times)]
    if limit_s is None:
        limit_s = GAP_PERIODS * sorted(waits)[3 * len(waits) // 4] if waits and is_periodic(waits) else math.inf
    for before, after in pairwise((0.0, *times, end_s)):
        if after - before > limit_s:
            yield before, after


def judge(requirements: Sequence[Requirement], run: LoggedRun) -> list[LogVerdict]:
    """The verdicts on a run, in the order of the requirements.

    Raises:
        MonitorError: the log has a value that no requirement can be judged by.
    """
    read = {requirement.id: _read(requirement) for requirement in requirements}
    whole = [each for each in requirements if not (read[each.id] & (run.gaps.keys() | run.missing))]
    verdicts = {
        verdict.requirement: LogVerdict(verdict.requirement, (verdict,)) for verdict in evaluate(whole, run.log)
    }
    for requirement in requirements:
        if requirement.id not in verdicts:
            verdicts[requirement.id] = _judge_stretches(requirement, run, read[requirement.id])
    return [verdicts[requirement.id] for requirement in requirements]


def _read(requirement: Requirement) -> frozenset[str]:
    signals = (name for name in names_read(requirement.formula) if "." not in name)
    return frozenset((*signals, *requirement.shows, *topics_read(requirement.formula)))


def _judge_stretches(requirement: Requirement, run: LoggedRun, read: frozenset[str]) -> LogVerdict:
    """The verdict on what lies between the gaps of what a requirement reads: what fails there fails."""
    if absent := sorted(read & run.missing):
        return LogVerdict(requirement.id, (), f"the log has no {' and no '.join(absent)}")
    spans = sorted((*span, name) for name in read & run.gaps.keys() for span in run.gaps[name])
    begin_s = 0.0
    stretches: list[Verdict] = []
    for from_s, to_s, _ in (*spans, (run.log.end_s, run.log.end_s, "")):
        if from_s > begin_s:
            with suppress(MonitorError):  # nothing of a signal in it
                stretches += evaluate([requirement], _cut(run.log, begin_s, from_s))
        begin_s = max(begin_s, to_s)
    first, more = spans[0], len(spans) - 1
    text = f"no data of {first[2]} from {first[0]:.3f} to {first[1]:.3f} s" + (
        f", and {more} more gaps" if more else ""
    )
    return LogVerdict(requirement.id, tuple(stretches), text)


def _cut(log: Log, begin_s: float, end_s: float) -> Log:
    """A stretch of a log; signals have the values that they had when it began."""
    signals: dict[str, Series] = {}
    for name, (times, values) in log.signals.items():
        kept = [n for n, time_s in enumerate(times) if begin_s <= time_s <= end_s]
        before = [n for n, time_s in enumerate(times) if time_s < begin_s][-1:]
        numbers = [*before, *kept] if before and not (kept and times[kept[0]] == begin_s) else kept
        signals[name] = [max(times[n], begin_s) for n in numbers], [values[n] for n in numbers]  # type: ignore[assignment]
    messages = [message for message in log.messages if begin_s <= message.time_s <= end_s]
    return Log(signals, messages, end_s)
