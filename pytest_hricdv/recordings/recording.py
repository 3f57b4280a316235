"""Reads recordings: ROS 2 bags (MCAP, SQLite), and MCAP files with JSON messages, as `--hri-mcap` writes them.

`hricdv check` uses a `RecordingReader`, which reads message by message; drafts use `read_recordings`, which loads a
whole `Recording`. A problem of a recording is reported as a sentence, and its other messages are still read.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv.recordings.bags import Decoder, Paths, Value, bag_files, read_messages
from pytest_hricdv.recordings.containers import UnreadableError
from pytest_hricdv.recordings.message_order import (
    CLOCK,
    HEADER_JITTER_S,
    JITTER_S,
    MAX_VALUES,
    NOTHING,
    NS_PER_S,
    TICK,
    UNREAD,
    MessageOrder,
    RecordedSample,
    clock_s,
    times_of_clock,
)

MIN_PERIODIC = 20
"""Minimum number of messages of a periodic topic."""

MAX_QUARTILE_RATIO = 1.5
"""Maximum ratio of the quartiles of the intervals between messages of a periodic topic; for timers it is 1.0."""


@dataclass(frozen=True)
class Recording:
    """The content of one file or folder.

    Args:
        name: the file's name, for people.
        topics: name -> type.
        parts: its messages in the order of time; a new part begins where the clock jumped.
        problems: a sentence each.
        notes: notes on its times, likewise.
        is_cut: whether a part of it could not be read.
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
    """Read recordings into memory, up to a limit.

    Args:
        paths: the paths of bags (folders, or files of them) and MCAP files; each file in other folders is a recording.
        wanted: whether the fields of a topic are needed.
        file_of: the interface file of a type of ROS 2; None if there is none.
    """
    return [_read(reader, wanted) for reader in recording_readers(paths, file_of)]


def recording_readers(paths: Sequence[Path], file_of: Callable[[str], Path | None]) -> list[RecordingReader]:
    """A reader of each recording; see `read_recordings`."""
    readers = [RecordingReader(path, part, file_of) for path in paths for part in _separate(path)]
    count = Counter(reader.name for reader in readers)
    for reader in readers:
        if count[reader.name] > 1:  # logs of a fleet have the same name in different folders
            reader.name = str(reader.path)
    return readers


def _separate(path: Path) -> list[Path]:
    """A bag as a whole; in a folder without metadata, each file is a recording, as traces of tests are."""
    if not path.is_dir() or (path / "metadata.yaml").exists():
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix in (".mcap", ".db3"))
    doubled = {file for file in files if file.name.endswith(".ros2.mcap")
               and file.with_name(file.name.replace(".ros2.mcap", ".mcap")) in files}  # fmt: skip
    return [file for file in files if file not in doubled] or [path]


def _read(reader: RecordingReader, wanted: Callable[[str], bool]) -> Recording:
    parts: list[list[RecordedSample]] = []
    for number, sample in reader.samples(lambda topic: {} if wanted(topic) else None, most=MAX_VALUES):
        while len(parts) <= number:
            parts.append([])
        parts[number].append(sample)
    problems = [*reader.problems, *reader.unreadable_lines(), *reader.jumps]
    if not reader.count and not problems:
        problems.append(f"{reader.name}: has no messages: nothing was observed")
    notes = tuple(reader.notes) if reader.count else ()
    return Recording(reader.name, reader.types, tuple(map(tuple, parts)), tuple(problems), notes, reader.is_cut)


class RecordingReader:
    """Reads one recording, any number of times, with a second of it in memory.

    Args:
        asked: the path that the user gave.
        path: the path of the file or bag: the same, or inside that folder.
        file_of: see `read_recordings`.

    Attributes:
        name: for people.
        types: topic -> type, of the part read so far, as are all that follow.
        count: number of messages.
        problems: why the rest was not read.
        unreadable: topic -> number of messages with fields that cannot be read, and the reason.
        jumps: the clock's jumps, a sentence each.
        base_ns: origin of the times of messages (ns): as floats since 1970, they would be exact to 0.25 us only.
    """

    def __init__(self, asked: Path, path: Path, file_of: Callable[[str], Path | None]) -> None:
        self.path = path
        self.name = path.name if path == asked else f"{asked.name}/{path.name}"
        self._file_of = file_of
        self._begin()

    def _begin(self) -> None:
        self.types: dict[str, str] = {}
        self.count = 0
        self.problems: list[str] = []
        self.unreadable: dict[str, tuple[int, str]] = {}
        self.jumps: list[str] = []
        self.base_ns = 0
        self._is_ros = self._has_clock = False
        self._kept = 0

    @property
    def is_cut(self) -> bool:
        """Whether a part of it could not be read."""
        return bool(self.problems)

    @property
    def notes(self) -> list[str]:
        """Notes on its times, a sentence each."""
        if self._has_clock:
            return [f"{self.name}: times are those of {CLOCK}"]
        return [f"{self.name}: has no {CLOCK}: times are those of the recorder"] if self._is_ros else []

    def unreadable_lines(self) -> Iterator[str]:
        """Lines on unreadable messages."""
        for topic, (count, text) in self.unreadable.items():
            messages = "message" if count == 1 else "messages"
            yield f"{self.name}: {topic}: {text}; of {count} {messages} only the times are used"

    def samples(
        self,
        fields_of: Callable[[str], Paths | None],
        *,
        stamp: Callable[[RecordedSample], float | None] | None = None,
        is_exact: bool = False,
        most: float = math.inf,
    ) -> Iterator[tuple[int, RecordedSample]]:
        """The messages in the order of time, each with the number of its part (from 0): the clock jumps between parts.

        Args:
            fields_of: topic -> the fields that are needed; empty for all, None for none.
            stamp: message -> its own time (s); None to leave it out.
            is_exact: whether times begin at 0 and the clock never jumps, as in traces of this tool; otherwise times are
                since the first message.
            most: number of messages and values that the caller can keep; later ones are not read.
        """
        self._begin()
        order = MessageOrder(self.name, JITTER_S if stamp is None else HEADER_JITTER_S, splits=not is_exact)
        add = order.add
        for sample in times_of_clock(self._decode(fields_of, most, is_based=not is_exact)):
            if stamp is not None:
                time_s = stamp(sample)
                if time_s is None:
                    continue
                sample = sample._replace(time_s=time_s)
            try:
                due = add(sample)
            except UnreadableError as error:
                self.problems.append(self._cut_off(str(error)))
                break
            yield from due
        yield from order.rest()
        self.jumps = order.jumps()

    def _decode(
        self, fields_of: Callable[[str], Paths | None], most: float, *, is_based: bool
    ) -> Iterator[RecordedSample]:
        """The messages in the order of the file, up to the first error, with the times of the recorder."""
        decode, topics = Decoder(self._file_of).fields, dict[str, Paths | None]()
        try:
            for file in bag_files(self.path):
                for message in read_messages(file):
                    time_ns, _, topic = message
                    if is_based:
                        self.base_ns, is_based = time_ns, False
                    name, time_s = topic.name, (time_ns - self.base_ns) / NS_PER_S
                    if name not in topics:
                        topics[name] = fields_of(name)
                        self.types[name] = topic.type
                        self._is_ros |= topic.encoding == "cdr"
                    if name == CLOCK and topic.encoding == "cdr" and len(message.data) >= 12:
                        self._has_clock = True
                        yield RecordedSample(time_s, TICK, {"": clock_s(message.data)})
                        continue
                    self.count += 1
                    paths = topics[name]
                    if paths is None:
                        yield RecordedSample(time_s, name, NOTHING)
                        if most < math.inf:
                            self._keep(NOTHING, most, file)
                        continue
                    try:
                        fields: Mapping[str, Value] = decode(message, paths or None)
                    except UnreadableError as error:
                        count, text = self.unreadable.get(name, (0, str(error)))
                        self.unreadable[name] = (count + 1, text)
                        fields = UNREAD
                    yield RecordedSample(time_s, name, fields)
                    if most < math.inf:
                        self._keep(fields, most, file)
        except UnreadableError as error:
            self.problems.append(self._cut_off(str(error)))
        except OSError as error:
            self.problems.append(f"{self.path.absolute()}: cannot be read: {error.strerror}")

    def _keep(self, fields: Mapping[str, Value], most: float, file: Path) -> None:
        self._kept += 1 + sum(len(value) if isinstance(value, tuple) else 1 for value in fields.values())
        if self._kept > most:
            raise UnreadableError(f"{file.name}: has more than {most:,} messages and values")

    def _cut_off(self, text: str) -> str:
        first = "first message is" if self.count == 1 else f"first {self.count} messages are"
        return f"{text}; {f'its {first} used' if self.count else 'no message of it is used'}"


def is_periodic(gaps: Sequence[float]) -> bool:
    """Whether a topic with these times between its messages is periodic, as of a timer."""
    ordered = sorted(gaps)
    if len(ordered) + 1 < MIN_PERIODIC:
        return False
    return ordered[3 * len(ordered) // 4] <= MAX_QUARTILE_RATIO * ordered[len(ordered) // 4]
