"""Reading recordings: bags of ROS 2 (MCAP, SQLite) and MCAP files with messages of JSON, as `--hri-mcap` writes them.

What is wrong with one is a sentence, and all else of it is used.
"""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv.extra.recordings.decoding import Definitions, UnreadableError, Value, of_cdr, of_json
from pytest_hricdv.extra.ros2.bag_file import (
    BagContent,
    BagError,
    BagMessage,
    files_left,
    messages_left,
)

CLOCK = "/clock"
NS_PER_S = 1_000_000_000

JITTER_S = 1.0
"""By as much messages may be written out of order, as recorders with a cache do; more is a clock that was set back
(chosen: `ros2 bag record` writes its cache several times a second)."""

PAUSE_S = 600.0
"""A longer pause of all topics is a jump of the clock, or of another recording (chosen)."""

_SHORTEST_PAUSE_S, _PAUSE_FACTOR, _PAUSE_STREAMS = 10.0, 50.0, 2
"""With so many topics that come again and again, so many times the pause that 99 % of all do not exceed is one, too,
from so many seconds (chosen: one topic alone may rest while its node has nothing to do, as a clock never does)."""

STREAM_MESSAGES = 20
"""A topic with fewer messages is none that comes again and again (chosen)."""

STREAM_SPREAD = 1.5
"""The greatest quotient of the quartiles of the times between its messages (chosen: timers have 1.0, people more)."""


@dataclass(frozen=True)
class Recorded:
    """A message: when (s), on which topic, and its fields; these are empty where nobody asked for them."""

    time_s: float
    topic: str
    fields: Mapping[str, Value]


@dataclass(frozen=True)
class Recording:
    """What was read of one file or folder.

    Args:
        name: of the file, for people.
        topics: name -> type.
        parts: its messages in the order of time; several parts where the clock jumped.
        problems: what is wrong with it, a sentence each.
        notes: what is to be known of it, likewise.
    """

    name: str
    topics: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[tuple[Recorded, ...], ...] = ()
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def counts(self) -> dict[str, int]:
        """Topic -> its messages."""
        counts = dict.fromkeys(self.topics, 0)
        for part in self.parts:
            for message in part:
                counts[message.topic] = counts.get(message.topic, 0) + 1
        return counts


def read(
    paths: Sequence[Path], wanted: Callable[[str], bool], file_of: Callable[[str], Path | None]
) -> list[Recording]:
    """Read recordings.

    Args:
        paths: of bags (folders, or files of them) and MCAP files; of other folders, each file in it is one recording.
        wanted: whether the fields of a topic are of use.
        file_of: the interface file of a type of ROS 2; None where there is none.
    """
    return [_read(path, part, wanted, file_of) for path in paths for part in _separate(path)]


def _separate(path: Path) -> list[Path]:
    """A bag as a whole; of a folder without metadata, its files: each begins anew, as traces of tests do."""
    if not path.is_dir() or (path / "metadata.yaml").exists():
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
    doubled = {file for file in files if file.name.endswith(".ros2.mcap")
               and file.with_name(file.name.replace(".ros2.mcap", ".mcap")) in files}  # fmt: skip
    return [file for file in files if file not in doubled] or [path]


def _read(asked: Path, path: Path, wanted: Callable[[str], bool], file_of: Callable[[str], Path | None]) -> Recording:
    name = path.name if path == asked else f"{asked.name}/{path.name}"
    content = BagContent(path, any_encoding=True)
    files, errors = files_left(path)
    problems = [str(error) for error in errors]
    reading = _Reading(wanted, Definitions(file_of), name)
    for file in files:
        try:
            for message in messages_left(file, content):
                reading.add(content, message)
        except BagError as error:
            read = f"its first {reading.count} messages are used" if reading.count else "nothing of it is used"
            problems.append(f"{error}; {read}")
        except OSError as error:
            problems.append(f"{path.absolute()}: cannot be read: {error.strerror or error_text(error)}")
    problems += reading.problems()
    if not reading.count and not problems:
        problems.append(f"{path.absolute()}: has no messages: nothing was observed")
    parts, jumps, notes = reading.parts()
    kinds = {topic: description.type for topic, description in content.topics.items()}
    return Recording(name, kinds, parts, (*problems, *jumps), tuple(notes) if reading.count else ())


class _Reading:
    """Collects the messages of one recording."""

    def __init__(self, wanted: Callable[[str], bool], definitions: Definitions, name: str) -> None:
        self._wanted, self._definitions, self._name = wanted, definitions, name
        self._written: list[Recorded] = []
        self._clock: list[tuple[float, float]] = []
        self._unreadable: dict[str, tuple[int, str]] = {}
        self._defined: set[str] = set()
        self._is_ros = False

    @property
    def count(self) -> int:
        """Messages up to now."""
        return len(self._written)

    def add(self, content: BagContent, message: BagMessage) -> None:
        """Add the next message, as it was written."""
        time_s, topic = message.time_ns / NS_PER_S, content.topics[message.topic]
        self._is_ros |= topic.encoding == "cdr"
        if message.topic == CLOCK and topic.encoding == "cdr" and len(message.data) >= 12:
            seconds, nanoseconds = struct.unpack_from("<iI", message.data, 4)
            self._clock.append((time_s, seconds + nanoseconds / NS_PER_S))
            return
        fields: Mapping[str, Value] = {}
        if self._wanted(message.topic):
            if topic.definition and topic.type not in self._defined:
                self._definitions.add(topic.type, topic.definition)
                self._defined.add(topic.type)
            try:
                fields = self._decoded(message.data, topic.encoding, topic.type)
            except UnreadableError as error:
                count, text = self._unreadable.get(message.topic, (0, str(error)))
                self._unreadable[message.topic] = (count + 1, text)
        self._written.append(Recorded(time_s, message.topic, fields))

    def _decoded(self, data: bytes, encoding: str, kind: str) -> Mapping[str, Value]:
        if encoding == "json":
            return of_json(data)
        if encoding == "cdr":
            return of_cdr(data, kind, self._definitions)
        raise UnreadableError(f"its messages are {encoding or 'of no format that it names'}; expected cdr or json")

    def problems(self) -> Iterator[str]:
        """What could not be read."""
        for topic, (count, text) in self._unreadable.items():
            messages = "message" if count == 1 else "messages"
            yield f"{self._name}: {topic}: {text}; of {count} {messages} only the times are used"

    def parts(self) -> tuple[tuple[tuple[Recorded, ...], ...], list[str], list[str]]:
        """The messages in the order of time, part by part; jumps of the clock, and what is to be known of it."""
        messages, notes = self._written, []
        if self._clock:
            notes = [f"{self._name}: times are those of {CLOCK}, as the nodes had them"]
            messages = self._by_clock()
        elif self._is_ros:
            notes = [f"{self._name}: has no {CLOCK}: times are those at which messages were recorded"]
        unset = [message for message in messages if self._is_ros and not message.time_s]
        timed = [message for message in messages if message.time_s or not self._is_ros]
        if not timed:
            timed, unset = messages, []
        parts, jumps = _split(timed, self._name)
        if unset:
            count = "one message has" if len(unset) == 1 else f"{len(unset)} messages have"
            jumps.insert(0, f"{self._name}: {count} the time 0, as before a first {CLOCK}: it is not counted")
        return (*((message,) for message in unset), *parts), _cut(jumps), notes

    def _by_clock(self) -> list[Recorded]:
        """The messages with the times that the clock of the simulation had then, between its messages linearly."""
        written, shown = zip(*self._clock, strict=True)
        made = []
        for message in self._written:
            at = max(1, min(bisect_right(written, message.time_s), len(written) - 1))
            if len(written) == 1 or shown[at] < shown[at - 1]:
                time_s = shown[at - 1]
            else:
                width_s = written[at] - written[at - 1]
                share = min(max((message.time_s - written[at - 1]) / width_s, 0.0), 1.0) if width_s > 0 else 0.0
                time_s = shown[at - 1] + share * (shown[at] - shown[at - 1])
            made.append(Recorded(time_s, message.topic, message.fields))
        return made


def _split(messages: Sequence[Recorded], name: str) -> tuple[list[tuple[Recorded, ...]], list[str]]:
    """The parts between jumps of the clock, each in the order of time; and the jumps, a sentence each."""
    parts: list[list[Recorded]] = []
    jumps: list[str] = []
    last_s, pause_s = 0.0, _pause_s(messages)
    for number, message in enumerate(messages, 1):
        jump_s = message.time_s - last_s if parts else 0.0
        if not parts or jump_s < -JITTER_S or jump_s > pause_s:
            if parts:
                how = f"goes back by {-jump_s:.3g} s" if jump_s < 0 else f"jumps by {jump_s:.3g} s"
                place = f"{name}: message {number} ({message.topic})"
                jumps.append(f"{place}: the clock {how}: times across it are not counted")
            parts.append([])
            last_s = message.time_s
        last_s = max(last_s, message.time_s)
        parts[-1].append(message)
    return [tuple(sorted(part, key=lambda message: message.time_s)) for part in parts], jumps


def _cut(jumps: list[str], most: int = 3) -> list[str]:
    """The first sentences, and how many more there are."""
    return jumps if len(jumps) <= most else [*jumps[:most], f"{jumps[0].partition(':')[0]}: {len(jumps) - most} more"]


def _pause_s(messages: Sequence[Recorded]) -> float:
    by_topic: dict[str, list[float]] = defaultdict(list)
    for message in messages:
        by_topic[message.topic].append(message.time_s)
    gaps = [[abs(later - earlier) for earlier, later in pairwise(times)] for times in by_topic.values()]
    if sum(map(is_stream, gaps)) < _PAUSE_STREAMS:
        return PAUSE_S
    pauses_s = sorted(abs(later.time_s - earlier.time_s) for earlier, later in pairwise(messages))
    usual_s = pauses_s[int(0.99 * (len(pauses_s) - 1))]
    return min(PAUSE_S, max(_SHORTEST_PAUSE_S, _PAUSE_FACTOR * usual_s))


def is_stream(gaps: Sequence[float]) -> bool:
    """Whether a topic with these times between its messages comes again and again, as of a timer."""
    ordered = sorted(gaps)
    if len(ordered) + 1 < STREAM_MESSAGES:
        return False
    return ordered[3 * len(ordered) // 4] <= STREAM_SPREAD * ordered[len(ordered) // 4]
