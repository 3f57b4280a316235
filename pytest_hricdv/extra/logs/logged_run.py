"""`LoggedRun`: the part of a log between two jumps of its clock, with the gaps in its data.

`judge` and `LoggedActions` get them from a `LogReader`. It reads a log twice: for its times, which show the gaps
(`runs`), and for its values (`events`).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

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
from pytest_hricdv.recordings.message_order import NS_PER_S, UNREAD, RecordedSample
from pytest_hricdv.recordings.recording import RecordingReader, is_periodic

GAP_PERIODS = 5.0
"""A periodic topic has a gap where no message comes for more than this many periods: recorders lose one or two."""

MAX_GAPS = 1000
"""Maximum number of gaps of a topic; with more, the whole run counts as a gap."""

MAX_WAITS = 20_000
"""Maximum number of intervals to keep, from which the period of a topic is found; of more, every second, fourth, ..."""

Span = tuple[float, float]
"""Begin and end (s)."""

_STAMP: Paths = {"header.stamp.sec": ("header", "stamp", "sec"), "header.stamp.nanosec": ("header", "stamp", "nanosec")}


@dataclass(slots=True)
class TopicTimes:
    """The times of the messages of a topic, in bounded memory: number, first, last (s), and the longest waits."""

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
        """The gaps: waits that are longer than the limit, also before the first message and after the last one.

        Args:
            limit_s: None for five periods of a periodic topic.
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
        name: the name of the log, for people.
        begin_s: its beginning on the clock of the log (s).
        end_s: (s).
        topics: topic of the log -> times of its messages.
        gaps: signal or message of the testbench -> its gaps.
        missing: signals and messages that the log lacks.
        unread: signal or message -> number of messages that cannot be read.
        infinite: signal or message -> number of values that are not finite.
    """

    name: str
    begin_s: float
    end_s: float = 0.0
    topics: dict[str, TopicTimes] = field(default_factory=dict)
    gaps: Mapping[str, tuple[Span, ...]] = field(default_factory=dict)
    missing: frozenset[str] = frozenset()
    unread: dict[str, int] = field(default_factory=dict)
    infinite: dict[str, int] = field(default_factory=dict)

    def complete_from_s(self, names: Iterable[str], made: LogMap) -> float:
        """The first time at which all of these signals have a value."""
        topics = (made.signals[name].topic for name in names if name in made.signals)
        return max((self.topics[topic].first_s for topic in topics if topic in self.topics), default=0.0)


class LogEvent(NamedTuple):
    """The meaning of a message of the log for the testbench.

    Args:
        name: the name of the signal, message, cross product or action.
        source: its topic.
        value: takes the value of a signal, or fields, from the fields of the message; it raises InputError if the
            message lacks one, or has one of another type.
        paths: the fields that it reads; empty for all.
        is_signal: whether it is a signal.
        is_judged: whether requirements may read it.
        is_simple: whether all of its messages count.
    """

    name: str
    source: TopicSource
    value: Callable[[Mapping[str, Value]], Value | Mapping[str, Value]]
    paths: tuple[str, ...]
    is_signal: bool
    is_judged: bool
    is_simple: bool


def _event(name: str, source: TopicSource, vocabulary: Vocabulary) -> LogEvent:
    """The event of a source of the map."""
    is_signal, is_judged = isinstance(source, SignalSource), isinstance(source, SignalSource | MessageSource)
    is_simple = not source.only and getattr(source, "every_s", None) is None
    places = {} if isinstance(source, ActionSource) else dict(field_sources(name, source, vocabulary))
    paths = tuple(path for place in places.values() for path in paths_of(place))
    readings = {
        key.removeprefix(name).removeprefix("."): reading_of(key, place, vocabulary.kind(key), vocabulary.unit(key))
        for key, place in places.items()
    }
    if isinstance(source, CrossSource):
        readings = {key: _text_of(name, path) for key, path in source.coordinates.items()}
        paths = tuple(source.coordinates.values())

    def values(fields: Mapping[str, Value]) -> Mapping[str, Value]:
        return {key: reading(fields) for key, reading in readings.items()}

    value = readings[""] if is_signal else (lambda fields: fields) if isinstance(source, ActionSource) else values
    return LogEvent(name, source, value, (*paths, *source.only), is_signal, is_judged, is_simple)


class LogReader:
    """Reads a log by a map, any number of times.

    Args:
        recording: the reader of its messages.
        made: the map.
    """

    def __init__(self, recording: RecordingReader, made: LogMap, vocabulary: Vocabulary) -> None:
        self.recording, self.made, self._vocabulary = recording, made, vocabulary
        self._events: dict[str, list[LogEvent]] = {}
        self._wanted: dict[str, dict[str, tuple[str, ...]] | None] = {}
        self._stamped: set[str] = set()
        for name, source in (*made.sources.items(), *made.cross.items(), *made.actions.items()):
            event = _event(name, source, vocabulary)
            self._events.setdefault(source.topic, []).append(event)
            wanted = {path: tuple(path.split(".")) for path in event.paths}
            if (source.time or made.time) == "header":
                self._stamped.add(source.topic)
                wanted.update(_STAMP)
            self._wanted[source.topic] = (self._wanted.get(source.topic) or {}) | wanted or None
        for action in made.actions.values():
            self._wanted[action.topic] = {}  # all fields, so that the nearest one to a wrong name can be found

    def runs(self) -> list[LoggedRun]:
        """Its parts, after one pass through its times.

        Raises:
            InputError: a message has no stamp in its header, though the map says so.
        """
        runs: list[LoggedRun] = []
        begin_s, part, topics = 0.0, -1, dict[str, TopicTimes]()
        for number, (time_s, name, _) in self._samples(lambda topic: _STAMP if topic in self._stamped else None):
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
        """The events of the testbench in the order of time: number of the run (from 0), time (s), event, value.

        Raises:
            InputError: a message lacks a field that the map names, or has one of another type.
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
                    if event.is_judged and not _is_finite(value):  # its meaning depends on the sensor
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
        """Whether a message counts: it has the values that it must have, and its period of resampling begins."""
        source = event.source
        if not all(fields.get(path) == value for path, value in source.only.items()):
            return False
        if isinstance(source, SignalSource) and source.every_s is not None:
            if time_s < due_s.get((part, event.name), -math.inf):
                return False
            due_s[part, event.name] = time_s + source.every_s
        return True

    def _samples(self, paths_of_topic: Callable[[str], Paths | None]) -> Iterator[tuple[int, RecordedSample]]:
        stamp = self._stamp if self._stamped else None
        return self.recording.samples(paths_of_topic, stamp=stamp, is_exact=self.made.is_own)

    def _stamp(self, sample: RecordedSample) -> float | None:
        """The time of a message; None for topics that the map does not name, as their stamps are not read."""
        if sample.topic not in self._events:
            return None
        if sample.topic not in self._stamped:
            return sample.time_s
        return None if sample.fields is UNREAD else stamp_of(sample, self.recording.base_ns)


def _is_finite(value: Value | Mapping[str, Value]) -> bool:
    if isinstance(value, Mapping):
        return all(map(_is_finite, value.values()))
    return not isinstance(value, float) or math.isfinite(value)


def stamp_of(sample: RecordedSample, base_ns: int) -> float:
    """The stamp in the header of a message (s since `base_ns`). Raises InputError without one."""
    seconds, nanoseconds = (sample.fields.get(path) for path in _STAMP)
    if not (isinstance(seconds, float) and isinstance(nanoseconds, float) and math.isfinite(seconds + nanoseconds)):
        raise InputError(
            f'{sample.topic}: its messages have no header.stamp; expected one, as the map has time = "header"'
        )
    return (int(seconds) * NS_PER_S + int(nanoseconds) - base_ns) / NS_PER_S


def _text_of(name: str, path: str) -> Reading:
    def read(fields: Mapping[str, Value]) -> Value:
        value = fields.get(path)
        if not isinstance(value, str | float | bool):
            raise InputError(f"cross.{name}: its messages have no field {path}")
        return f"{value:g}" if isinstance(value, float) else str(value)

    return read


def spans_between(gaps: Iterable[Span], begin_s: float, end_s: float) -> tuple[Span, ...]:
    """The stretches of a run between gaps."""
    left: list[Span] = []
    for from_s, to_s in (*sorted(gaps), (end_s, end_s)):
        if from_s > begin_s or (from_s == end_s == begin_s and not left):
            left.append((begin_s, from_s))
        begin_s = max(begin_s, to_s)
    return tuple(left)
