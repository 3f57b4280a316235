"""`BagPlayer`: publishes the topics of a recorded bag in simulated time, as a stimulus for the nodes under test.

Testbenches import it from `pytest_hricdv.ros2`. `read_bag` reads the file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.messages import NS_PER_S, CdrError, deserialize, import_type, set_stamp, stamp_ns
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.recordings.containers import write_ahead_log
from pytest_hricdv.run import TestbenchError

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class BagPlayer:
    """Publishes the messages of a bag of ROS 2, MCAP or SQLite, as `ros2 bag play` does, in simulated time.

    Args:
        system: the system of `run.ros2`.
        path: the path of the bag's folder, or of a file of it; relative to the folder in which pytest is started.
        topics: the topics that are published; None: all but hidden ones.
        start_s: how much of the beginning is left out (s of the recording).
        rate: how much faster the bag is played than it was recorded.
        loop: whether the bag begins again at its end.
        delay_s: when the bag begins (s of simulated time from now).
        shift_stamps: whether stamps of headers are moved with the messages, so that nodes find them as old as they were
            when they were recorded. False: they stay in the time of the recording.
        node: the player's name in the graph.

    Raises:
        BagError: the bag cannot be read, a topic is not in it, the type of one is not installed, or a number is wrong.
    """

    def __init__(
        self,
        system: StartedSystem,
        path: str | Path,
        *,
        topics: Sequence[str] | None = None,
        start_s: float = 0.0,
        rate: float = 1.0,
        loop: bool = False,
        delay_s: float = 0.0,
        shift_stamps: bool = True,
        node: str = "bag",
    ) -> None:
        self._kernel, self._rate, self._loop, self._delay_s = system.kernel, rate, loop, delay_s
        self._shift_stamps = shift_stamps
        self.is_over = False
        """Whether all messages have been published; always false with `loop`."""
        content = read_bag(Path(path), topics)
        self._bag = content.path
        self._messages = self._from(content, start_s)
        played = {message.topic for message in self._messages}
        self._kinds = _classes(content, played)
        world = system.node(node)
        self._publishers = {
            topic: world.publisher(topic, kind, latched=content.topics[topic].latched)
            for topic, kind in self._kinds.items()
        }
        self._kernel.spawn(f"{node}: {Path(path).name}", self._play)

    def _from(self, content: BagContent, start_s: float) -> list[BagEntry]:
        bag = f"bag {content.path}"
        for name, value, is_right in (
            ("rate", self._rate, math.isfinite(self._rate) and self._rate > 0),
            ("start_s", start_s, math.isfinite(start_s) and start_s >= 0),
            ("delay_s", self._delay_s, math.isfinite(self._delay_s) and self._delay_s >= 0),
        ):
            if not is_right:
                expected = "a number above 0" if name == "rate" else "a number of seconds, 0 or more"
                raise BagError(f"{bag}: {name}={value!r}; expected {expected}")
        if not content.messages:
            raise BagError(f"{bag}: there is no message in it, of the topics that are played")
        first_ns, last_ns = content.messages[0].time_ns, content.messages[-1].time_ns
        from_ns = first_ns + round(start_s * NS_PER_S)
        if from_ns > last_ns:
            raise BagError(f"{bag}: start_s={start_s!r}, but it is {(last_ns - first_ns) / NS_PER_S:.3f} s long")
        messages = [message for message in content.messages if message.time_ns >= from_ns]
        if self._loop and messages[0].time_ns == messages[-1].time_ns:
            raise BagError(f"{bag}: loop=True, but all messages are of one instant: a round would take no time")
        self._from_ns = from_ns
        return messages

    def _play(self) -> None:
        self._kernel.sleep(self._delay_s)
        begins_s = self._kernel.now_s
        while True:
            begins_ns = system_ns(self._kernel)
            for number, message in enumerate(self._messages):
                due_s = begins_s + (message.time_ns - self._from_ns) / NS_PER_S / self._rate
                self._kernel.sleep(max(due_s - self._kernel.now_s, 0.0))
                self._publishers[message.topic].publish(self._message(number, message, begins_ns))
            if not self._loop:
                break
            begins_s += (self._messages[-1].time_ns - self._from_ns) / NS_PER_S / self._rate
        self.is_over = True

    def _message(self, number: int, recorded: BagEntry, begins_ns: int) -> Any:
        kind = self._kinds[recorded.topic]
        try:
            message = deserialize(recorded.data, kind)
        except (CdrError, ValueError) as error:
            at_s = (recorded.time_ns - self._from_ns) / NS_PER_S
            raise TestbenchError(
                f"bag {self._bag}: message {number} of those that are played, {recorded.topic} at {at_s:.3f} s: "
                f"{error}; was it recorded with another version of the type?"
            ) from None
        if self._shift_stamps:
            _shift(message, lambda ns: begins_ns + round((ns - self._from_ns) / self._rate))
        return message


def _classes(content: BagContent, topics: set[str]) -> dict[str, Any]:
    """The classes of the messages of topics. Raises BagError if some are not installed, with all of them."""
    classes, missing = {}, []
    for name in sorted(topics):
        try:
            classes[name] = import_type(content.topics[name].type, "msg")
        except Ros2Error:
            missing.append(f"{name} ({content.topics[name].type})")
    if missing:
        raise BagError(
            f"bag {content.path}: messages of these types are not installed: {', '.join(missing)}; install their "
            "packages, name the folder of their interface files in Ros2(interfaces=(...,)), or choose topics=(...)"
        )
    return classes


def _shift(message: Any, move: Callable[[int], int]) -> None:
    """Move the stamps of all headers in a message; a stamp of 0 means that there is none."""
    if type(message).__name__ == "Header":
        if ns := stamp_ns(message.stamp):
            set_stamp(message.stamp, max(move(ns), 0))
        return
    for name, type_ in zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True):
        of = getattr(type_, "value_type", type_)
        if hasattr(of, "namespaces"):
            value = getattr(message, name)
            for inner in value if of is not type_ else [value]:
                _shift(inner, move)


_METADATA = "metadata.yaml"
_SUFFIXES = (".mcap", ".db3")


class BagError(Ros2Error):
    """A bag cannot be read or played; the message says which, where, and what to do."""


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Args:
        type: the type of its messages, as "std_msgs/msg/String".
        latched: whether it was offered to later subscriptions, too ("transient local").
    """

    type: str
    latched: bool


class BagEntry(NamedTuple):
    """A message of a bag: when it was recorded, on which topic, and its bytes (CDR)."""

    time_ns: int
    topic: str
    data: bytes


@dataclass
class BagContent:
    """The content of a bag.

    Args:
        topics: all topics of the bag, by name.
        messages: the messages of the topics that were asked for, in the order of time.
    """

    path: Path
    topics: dict[str, BagTopic] = field(default_factory=dict)
    messages: list[BagEntry] = field(default_factory=list)


def read_bag(path: Path, topics: Collection[str] | None = None) -> BagContent:
    """Read a bag: its folder, or one file of it.

    Args:
        path: the path of a folder with or without `metadata.yaml`, or of a file.
        topics: those whose messages are wanted; None: all that are not hidden.

    Raises:
        BagError: it is not a bag, is cut off, or has no such topic.
    """
    content = BagContent(path)
    for part in _parts(path):
        _read(part, content, topics)
    missing = [topic for topic in topics or () if topic not in content.topics]
    if missing:
        raise BagError(
            f"bag {path}: no topic {missing[0]!r}{nearest(missing[0], list(content.topics))}; it has "
            f"{', '.join(sorted(content.topics)) or 'none'}"
        )
    content.messages.sort(key=lambda message: message.time_ns)
    return content


def _parts(path: Path) -> list[Path]:
    """The parts to read in sequence: the folder if it has metadata, else its files, or the one file."""
    if not path.exists():
        raise BagError(f"bag {path.absolute()}: there is no such file or folder; paths begin where pytest was started")
    if path.is_file() or (path / _METADATA).is_file():
        return [path]
    files = [file for suffix in _SUFFIXES for file in path.glob(f"*{suffix}")]  # of an interrupted recording
    if not files:
        raise BagError(f"bag {path.absolute()}: neither {_METADATA} nor a file *.mcap or *.db3 is in this folder")
    return sorted(files, key=_number)


def _number(file: Path) -> tuple[int, str]:
    number = re.search(r"_(\d+)\.", file.name)
    return (int(number[1]) if number else 0, file.name)


def _read(path: Path, content: BagContent, topics: Collection[str] | None) -> None:
    """Add the topics and the wanted messages of a folder or a file to the content."""
    try:
        from rosbags.rosbag2 import Reader
    except ModuleNotFoundError as error:
        raise BagError(
            f'bag {path}: {error.name} is needed to read it; install the extra: pip install "pytest-hricdv[ros2]"'
        ) from None
    if log := write_ahead_log(path):
        raise BagError(
            f"bag {path}: {log.name} has messages that are not in the database yet, as after an interrupted recording; "
            f"merge them: sqlite3 {log.name.removesuffix('-wal')} 'PRAGMA wal_checkpoint(TRUNCATE)'"
        )
    try:
        with Reader(path) as reader:
            wanted = [connection for connection in reader.connections if _is_wanted(connection.topic, topics)]
            for connection in reader.connections:
                content.topics[connection.topic] = BagTopic(connection.msgtype, _is_latched(connection.ext))
            for connection, time_ns, data in reader.messages(wanted) if wanted else ():
                content.messages.append(BagEntry(time_ns, connection.topic, bytes(data)))
    except Exception as error:  # its own, and those of `struct`, of SQLite and of decompression
        raise BagError(
            f"bag {path}: cannot be read, perhaps cut off: {error_text(error)}; `ros2 bag reindex` writes its "
            "metadata again"
        ) from None


def _is_wanted(name: str, topics: Collection[str] | None) -> bool:
    return name in topics if topics is not None else "/_" not in name


def _is_latched(extension: Any) -> bool:
    return any(profile.durability.name == "TRANSIENT_LOCAL" for profile in extension.offered_qos_profiles)
