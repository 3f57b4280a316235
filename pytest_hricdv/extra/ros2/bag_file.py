"""Bags of ROS 2, as `ros2 bag record` writes them: their topics and messages, in the order of time."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.input_file import unmerged_log
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.declarations.ros2 import Ros2Error

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_METADATA = "metadata.yaml"
_SUFFIXES = (".mcap", ".db3")


class BagError(Ros2Error):
    """A bag cannot be read or played; the text says which, where, and what to do."""


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Args:
        type: of its messages, as "std_msgs/msg/String".
        latched: whether it was offered to later subscriptions, too ("transient local").
    """

    type: str
    latched: bool


class RecordedMessage(NamedTuple):
    """A message of a bag: when it was recorded, on which topic, and its bytes (CDR)."""

    time_ns: int
    topic: str
    data: bytes


@dataclass
class BagContent:
    """What was read of a bag.

    Args:
        path: of the bag.
        topics: all of it, name -> topic.
        messages: of the topics that were asked for, in the order of time.
    """

    path: Path
    topics: dict[str, BagTopic] = field(default_factory=dict)
    messages: list[RecordedMessage] = field(default_factory=list)


def read_bag(path: Path, topics: Collection[str] | None = None) -> BagContent:
    """Read a bag: its folder, or one file of it.

    Args:
        path: of a folder with or without `metadata.yaml`, or of a file.
        topics: those whose messages are wanted; None: all that are not hidden.

    Raises:
        BagError: it is no bag, is cut off, or has no such topic.
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
    """What is read one after the other: the folder if it has metadata, else its files, or the one file."""
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
    if log := unmerged_log(path):
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
                content.messages.append(RecordedMessage(time_ns, connection.topic, bytes(data)))
    except Exception as error:  # its own, and those of `struct`, of SQLite and of decompression
        raise BagError(
            f"bag {path}: cannot be read, perhaps cut off: {error_text(error)}; `ros2 bag reindex` writes its "
            "metadata again"
        ) from None


def _is_wanted(name: str, topics: Collection[str] | None) -> bool:
    return name in topics if topics is not None else "/_" not in name


def _is_latched(extension: Any) -> bool:
    return any(profile.durability.name == "TRANSIENT_LOCAL" for profile in extension.offered_qos_profiles)
