"""Logged runs: the parts of a log between jumps of its clock, with when they have data of what.

A log is read twice: first for its times, which show its gaps; then its messages are judged one by one, in between.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.logs.log_map import (
    ActionSource,
    CrossSource,
    LogMap,
    MessageSource,
    Reading,
    SignalSource,
    TopicSource,
    field_sources,
    paths_of,
    reading_of,
)
from pytest_hricdv.monitor.vocabulary import Vocabulary
from pytest_hricdv.recordings.bags import Paths, Value
from pytest_hricdv.recordings.message_order import JITTER_S, NS_PER_S, UNREAD, RecordedSample
from pytest_hricdv.recordings.recording import RecordingReader, is_periodic

GAP_PERIODS = 5.0
"""No message of a periodic topic for so many of its periods is a gap (chosen): recorders lose one or two."""

MAX_GAPS = 1000
"""Gaps of a topic that are looked at; with more of them it is unknown as a whole."""

MAX_WAITS = 20_000
"""Times between messages of a topic of which its period is the quartile: of longer logs every second, fourth, ..."""

HEADER_JITTER_S = 5.0
"""How far stamps of headers may be out of order (chosen): an image takes a second or two."""

Span = tuple[float, float]
"""From when to when (s)."""

_STAMP: Paths = {"header.stamp.sec": ("header", "stamp", "sec"), "header.stamp.nanosec": ("header", "stamp", "nanosec")}


@dataclass(slots=True)
class TopicTimes:
    """When a topic had messages, in bounded memory: how many, the first and the last (s), and the longest waits."""

    first_s: float
    last_s: float
    count: int = 1
    _stride: int = 1
    _waits: list[float] = field(default_factory=list)
    _longest: list[tuple[float, float]] = field(default_factory=list)

    def add(self, time_s: float) -> None:
        """The next message."""
        wait_s = time_s - self.last_s
        self.last_s = time_s
        if self.count % self._stride == 0:
            self._waits.append(wait_s)
            if len(self._waits) > MAX_WAITS:
                self._waits, self._stride = self._waits[1::2], 2 * self._stride
        self.count += 1
        longest = self._longest
        if len(longest) <= MAX_GAPS:
            heapq.heappush(longest, (wait_s, time_s))
        elif wait_s > longest[0][0]:
            heapq.heapreplace(longest, (wait_s, time_s))

    def gaps(self, end_s: float, limit_s: float | None) -> tuple[Span, ...]:
        """When there is no data for longer than the limit; up to the first message, and from the last one on.

        Args:
            end_s: when the run ended.
            limit_s: None: five times the period, if there is one.
        """
        if limit_s is None:
            waits = sorted(self._waits)
            limit_s = GAP_PERIODS * waits[3 * len(waits) // 4] if waits and is_periodic(waits) else math.inf
        spans = [(to_s - wait_s, to_s) for wait_s, to_s in self._longest if wait_s > limit_s]
        if len(spans) > MAX_GAPS:
            return ((0.0, end_s),)
        ends = ((0.0, self.first_s), (self.last_s, end_s))
        return tuple(sorted([*spans, *(span for span in ends if span[1] - span[0] > limit_s)]))


@dataclass
class LoggedRun:
    """A part of a log without jumps of its clock; times are since its beginning.

    Args:
        name: of the log, for people.
        begin_s: when it began, on its clock (s).
        end_s: when it ended (s).
        topics: topic of the log -> when it had messages.
        gaps: signal or message of the testbench -> when there is no data of it.
        missing: signals and messages that the log does not have at all.
        unread: signals and messages -> how many messages cannot be read.
        infinite: signals and messages -> how many have a number that is not finite.
    """

    name: str
    begin_s: float
    end_s: float = 0.0
    topics: dict[str, TopicTimes] = field(default_factory=dict)
    gaps: Mapping[str, tuple[Span, ...]] = field(default_factory=dict)
    missing: frozenset[str] = frozenset()
    unread: dict[str, int] = field(default_factory=dict)
    infinite: dict[str, int] = field(default_factory=dict)

    def known_from_s(self, names: Iterable[str], made: LogMap) -> float:
        """From when on all of these signals have a value."""
        topics = (made.signals[name].topic for name in names if name in made.signals)
        return max((self.topics[topic].first_s for topic in topics if topic in self.topics), default=0.0)


@dataclass(frozen=True)
class LogEvent:
    """What a message of the log is to the testbench.

    Args:
        name: of the signal, the message or the cross product.
        source: where it is.
        readings: of its fields, or of its value, whose name is empty.
    """

    name: str
    source: TopicSource
    readings: tuple[tuple[str, Reading], ...]

    @cached_property
    def value(self) -> Callable[[Mapping[str, Value]], Value | Mapping[str, Value]]:
        """Takes the value of a signal, or the fields of another one; of an action, as they are.

        It raises InputError where the message lacks them, or they are of another type.
        """
        readings = self.readings
        if self.is_signal:
            return readings[0][1]
        if isinstance(self.source, ActionSource):
            return lambda fields: fields
        return lambda fields: {name: reading(fields) for name, reading in readings}

    @cached_property
    def is_signal(self) -> bool:
        """Whether it is a signal."""
        return isinstance(self.source, SignalSource)

    @cached_property
    def is_judged(self) -> bool:
        """Whether requirements may read it."""
        return isinstance(self.source, SignalSource | MessageSource)

    @cached_property
    def is_simple(self) -> bool:
        """Whether all of its messages count."""
        source = self.source
        return source.every_s is None if isinstance(source, SignalSource) else isinstance(source, MessageSource)


class LogReader:
    """Reads a log by a map, as often as needed.

    Args:
        recording: the reader of its messages.
        made: the map.
        vocabulary: of the testbench.
    """

    def __init__(self, recording: RecordingReader, made: LogMap, vocabulary: Vocabulary) -> None:
        self.recording, self.made, self._vocabulary = recording, made, vocabulary
        self._events: dict[str, list[LogEvent]] = {}
        self._paths: dict[str, dict[str, tuple[str, ...]]] = {}
        self._clocks: dict[str, str] = {}
        whole = {source.topic for source in made.actions.values()}  # so that a wrong name has a nearest one
        places = dict(field_sources(made, vocabulary))
        for name, source in (*made.sources.items(), *made.cross.items(), *made.actions.items()):
            own = [place for place in places if place.partition(".")[0] == name and source is made.sources.get(name)]
            readings = [(place.partition(".")[2], reading_of(place, places[place], vocabulary)) for place in own]
            paths = [path for place in own for path in paths_of(places[place])]
            if isinstance(source, CrossSource):
                readings = [(path, _text_of(name, path)) for path in source.coordinates.values()]
                paths = [*source.coordinates.values(), *source.only]
            elif isinstance(source, ActionSource):
                readings, paths = [], []
            self._events.setdefault(source.topic, []).append(LogEvent(name, source, tuple(readings)))
            self._paths.setdefault(source.topic, {}).update({path: tuple(path.split(".")) for path in paths})
            clock = source.time or made.time
            if clock == "header":
                self._clocks[source.topic] = clock
                self._paths[source.topic].update(_STAMP)
        self._wanted: dict[str, Paths | None] = {topic: paths or None for topic, paths in self._paths.items()}
        for topic in whole:
            self._wanted[topic] = {}  # all

    def runs(self) -> list[LoggedRun]:
        """Its parts, after one pass through its times.

        Raises:
            InputError: a message has no stamp in its header, by which its time was to be.
        """
        runs: list[LoggedRun] = []
        begin_s, part, topics = 0.0, -1, dict[str, TopicTimes]()
        for number, (time_s, name, _) in self._samples(lambda topic: _STAMP if topic in self._clocks else None):
            if number != part:
                begin_s, part, topics = 0.0 if self.made.is_own else time_s, number, {}
                runs.append(LoggedRun(self.recording.name, begin_s, topics=topics))
            if name in topics:
                topics[name].add(time_s - begin_s)
            else:
                topics[name] = TopicTimes(time_s - begin_s, time_s - begin_s)
        for run in runs:
            run.end_s = max(topic.last_s for topic in run.topics.values())
        for number, run in enumerate(runs, 1):
            if len(runs) > 1:
                run.name = f"{self.recording.name}, part {number}"
            self._complete(run)
        return runs

    def _complete(self, run: LoggedRun) -> None:
        gaps: dict[str, tuple[Span, ...]] = {}
        own = {name: source for name, source in self.made.sources.items() if source.topic in run.topics}
        for name, source in own.items():
            limit_s = self.made.gap_s if source.gap_s is None else source.gap_s
            if spans := run.topics[source.topic].gaps(run.end_s, limit_s):
                gaps[name] = spans
        needed = {*self._vocabulary.signals, *(() if self.made.is_own else self._vocabulary.messages)}
        run.gaps, run.missing = gaps, frozenset(needed - own.keys())

    def events(self, runs: list[LoggedRun]) -> Iterator[tuple[int, float, LogEvent, Value | Mapping[str, Value]]]:
        """What the messages are to the testbench, in the order of time: number of the run (from 0), time (s), values.

        Raises:
            InputError: a message lacks a field that the map names, or it is of another type.
        """
        due_s: dict[tuple[int, str], float] = {}
        for run in runs:
            run.unread.clear()
            run.infinite.clear()
        events_of, begins_s = self._events, [run.begin_s for run in runs]
        for part, (sampled_s, topic, fields) in self._samples(self._wanted.get):
            events = events_of.get(topic)
            if events is None:
                continue
            time_s = sampled_s - begins_s[part]
            if fields is UNREAD:
                for event in events:
                    runs[part].unread[event.name] = runs[part].unread.get(event.name, 0) + 1
                continue
            for event in events:
                if event.is_simple or self._counts(event, part, time_s, fields, due_s):
                    value = event.value(fields)
                    if event.is_judged and not _is_finite(value):  # nobody knows what a sensor means by it
                        runs[part].infinite[event.name] = runs[part].infinite.get(event.name, 0) + 1
                        continue
                    yield part, time_s, event, value

    def _counts(
        self,
        event: LogEvent,
        part: int,
        time_s: float,
        fields: Mapping[str, Value],
        due_s: dict[tuple[int, str], float],
    ) -> bool:
        """Whether a message counts: it is not too early, or has the values that it must have."""
        source = event.source
        if isinstance(source, SignalSource):
            if time_s < due_s.get((part, event.name), -math.inf):
                return False
            due_s[part, event.name] = time_s + (source.every_s or 0.0)
            return True
        only = source.only if isinstance(source, CrossSource | ActionSource) else {}
        return all(fields.get(path) == value for path, value in only.items())

    def _samples(self, paths_of_topic: object) -> Iterator[tuple[int, RecordedSample]]:
        by_header = bool(self._clocks)
        return self.recording.samples(
            paths_of_topic,  # type: ignore[arg-type]
            stamp=self._stamp if by_header else None,
            jitter_s=HEADER_JITTER_S if by_header else JITTER_S,
            jumps=not self.made.is_own,
            from_zero=self.made.is_own,
        )

    def _stamp(self, sample: RecordedSample) -> float | None:
        """When a message was: of topics that the map does not name, nobody knows, where clocks are those of headers."""
        if sample.topic not in self._events:
            return None
        if sample.topic not in self._clocks:
            return sample.time_s
        return None if sample.fields is UNREAD else stamp_of(sample, self.recording.base_ns)


def _is_finite(value: Value | Mapping[str, Value]) -> bool:
    if isinstance(value, Mapping):
        return all(map(_is_finite, value.values()))
    return not isinstance(value, float) or math.isfinite(value)


def stamp_of(sample: RecordedSample, base_ns: int) -> float:
    """The stamp in the header of a message (s since `base_ns`). Raises InputError where it has none."""
    seconds, nanoseconds = (sample.fields.get(path) for path in _STAMP)
    if not (isinstance(seconds, float) and isinstance(nanoseconds, float) and math.isfinite(seconds + nanoseconds)):
        raise InputError(f"{sample.topic}: its messages have no header.stamp, by which their times were to be")
    return (int(seconds) * NS_PER_S + int(nanoseconds) - base_ns) / NS_PER_S


def _text_of(name: str, path: str) -> Reading:
    def read(fields: Mapping[str, Value]) -> Value:
        value = fields.get(path)
        if not isinstance(value, str | float | bool):
            raise InputError(f"cross.{name}: its messages have no field {path}")
        return f"{value:g}" if isinstance(value, float) else str(value)

    return read


def spans_between(gaps: Iterable[Span], begin_s: float, end_s: float) -> tuple[Span, ...]:
    """What gaps leave of a run."""
    left: list[Span] = []
    for from_s, to_s in (*sorted(gaps), (end_s, end_s)):
        if from_s > begin_s or (from_s == end_s == begin_s and not left):
            left.append((begin_s, from_s))
        begin_s = max(begin_s, to_s)
    return tuple(left)
