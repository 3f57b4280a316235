"""Reads recordings: ROS 2 bags (MCAP, SQLite), and MCAP files with JSON messages, as `--hri-mcap` writes them.

What is wrong with one is a sentence, and all else of it is used.
"""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv.recordings.bags import Decoder, Value, bag_files, read_messages
from pytest_hricdv.recordings.containers import BagMessage, UnreadableError

CLOCK = "/clock"
NS_PER_S = 1_000_000_000

JITTER_S = 1.0
"""How far messages may be written out of order, as recorders with a cache do; more is a clock that was set back."""

PAUSE_S = 600.0
"""A longer pause of all topics is a jump of the clock, or the beginning of another recording."""

MIN_PERIODIC = 20
"""A topic with fewer messages is not periodic."""

MAX_QUARTILE_RATIO = 1.5
"""Of a periodic topic, the greatest quotient of the quartiles of the times between its messages: timers have 1.0."""


MAX_VALUES = 3_000_000
"""Messages and values of fields of a recording that are kept: they take 500 MB."""


@dataclass(frozen=True, slots=True)
class RecordedSample:
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
        is_cut: whether not all of it could be read.
    """

    name: str
    topics: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[tuple[RecordedSample, ...], ...] = ()
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    is_cut: bool = False


def read_recordings(
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
    """A bag as a whole; of a folder without metadata, its files: each begins for itself, as traces of tests do."""
    if not path.is_dir() or (path / "metadata.yaml").exists():
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
    doubled = {file for file in files if file.name.endswith(".ros2.mcap")
               and file.with_name(file.name.replace(".ros2.mcap", ".mcap")) in files}  # fmt: skip
    return [file for file in files if file not in doubled] or [path]


def _read(asked: Path, path: Path, wanted: Callable[[str], bool], file_of: Callable[[str], Path | None]) -> Recording:
    name = path.name if path == asked else f"{asked.name}/{path.name}"
    reading, problems = _Reading(wanted, Decoder(file_of), name), []
    try:
        for file in bag_files(path):
            for message in read_messages(file):
                reading.add(message)
                if reading.kept > MAX_VALUES:
                    raise UnreadableError(f"{file.name}: has more than {MAX_VALUES:,} messages and values")
    except UnreadableError as error:
        read = f"its first {reading.count} messages are used" if reading.count else "nothing of it is used"
        problems.append(f"{error}; {read}")
    except OSError as error:
        problems.append(f"{path.absolute()}: cannot be read: {error.strerror}")
    is_cut = bool(problems)
    problems += reading.problems()
    if not reading.count and not problems:
        problems.append(f"{name}: has no messages: nothing was observed")
    parts, jumps, notes = reading.parts()
    return Recording(name, reading.types, parts, (*problems, *jumps), tuple(notes) if reading.count else (), is_cut)


class _Reading:
    """Collects the messages of one recording."""

    def __init__(self, wanted: Callable[[str], bool], decoder: Decoder, name: str) -> None:
        self._wanted, self._decoder, self._name = wanted, decoder, name
        self.types: dict[str, str] = {}
        """Topic -> type, of the messages up to now."""
        self._written: list[RecordedSample] = []
        self._clock: list[tuple[float, float]] = []
        self._unreadable: dict[str, tuple[int, str]] = {}
        self._is_ros = False
        self.kept = 0
        """Messages and values of fields up to now."""

    @property
    def count(self) -> int:
        """Messages up to now."""
        return len(self._written)

    def add(self, message: BagMessage) -> None:
        """Add the next message, as it was written."""
        time_s = message.time_ns / NS_PER_S
        self.types[message.topic] = message.type
        self._is_ros |= message.encoding == "cdr"
        if message.topic == CLOCK and message.encoding == "cdr" and len(message.data) >= 12:
            seconds, nanoseconds = struct.unpack_from("<iI", message.data, 4)
            self._clock.append((time_s, seconds + nanoseconds / NS_PER_S))
            self.kept += 1
            return
        fields: Mapping[str, Value] = {}
        if self._wanted(message.topic):
            try:
                fields = self._decoder.fields(message)
            except UnreadableError as error:
                count, text = self._unreadable.get(message.topic, (0, str(error)))
                self._unreadable[message.topic] = (count + 1, text)
        self._written.append(RecordedSample(time_s, message.topic, fields))
        self.kept += 1 + sum(len(value) if isinstance(value, tuple) else 1 for value in fields.values())

    def problems(self) -> Iterator[str]:
        """What could not be read."""
        for topic, (count, text) in self._unreadable.items():
            messages = "message" if count == 1 else "messages"
            yield f"{self._name}: {topic}: {text}; of {count} {messages} only the times are used"

    def parts(self) -> tuple[tuple[tuple[RecordedSample, ...], ...], list[str], list[str]]:
        """The messages in the order of time, part by part; jumps of the clock, and what is to be known of it."""
        messages, notes = self._written, []
        if self._clock:
            notes = [f"{self._name}: times are those of {CLOCK}, as the nodes had them"]
            messages = self._by_clock()
        elif self._is_ros:
            notes = [f"{self._name}: has no {CLOCK}: times are those at which messages were recorded"]
        parts, jumps = _split(messages, self._name)
        return tuple(parts), _cut(jumps), notes

    def _by_clock(self) -> list[RecordedSample]:
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
            made.append(RecordedSample(time_s, message.topic, message.fields))
        return made


def _split(messages: Sequence[RecordedSample], name: str) -> tuple[list[tuple[RecordedSample, ...]], list[str]]:
    """The parts between jumps of the clock, each in the order of time; and the jumps, a sentence each."""
    parts: list[list[RecordedSample]] = []
    jumps: list[str] = []
    last_s = 0.0
    for number, message in enumerate(messages, 1):
        jump_s = message.time_s - last_s if parts else 0.0
        if not parts or jump_s < -JITTER_S or jump_s > PAUSE_S:
            if parts:
                how = f"goes back by {-jump_s:.3g} s" if jump_s < 0 else f"jumps by {jump_s:.3g} s"
                at = f"{name}: message {number} ({message.topic})"
                jumps.append(f"{at}: the clock {how}: times across it are not counted")
            parts.append([])
            last_s = message.time_s
        last_s = max(last_s, message.time_s)
        parts[-1].append(message)
    return [tuple(sorted(part, key=lambda message: message.time_s)) for part in parts], jumps


def _cut(jumps: list[str], most: int = 3) -> list[str]:
    """The first sentences, and how many more there are."""
    return jumps if len(jumps) <= most else [*jumps[:most], f"{jumps[0].partition(':')[0]}: {len(jumps) - most} more"]


def is_periodic(gaps: Sequence[float]) -> bool:
    """Whether a topic with these times between its messages is periodic, as of a timer."""
    ordered = sorted(gaps)
    if len(ordered) + 1 < MIN_PERIODIC:
        return False
    return ordered[3 * len(ordered) // 4] <= MAX_QUARTILE_RATIO * ordered[len(ordered) // 4]
