"""Bags of ROS 2, as `ros2 bag record` writes them: what is in them, in the order of time. MCAP and SQLite are read."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.declarations.ros2 import Ros2Error

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_METADATA = "metadata.yaml"
_SUFFIXES = (".mcap", ".db3")
_LATCHED = re.compile(r"durability:\s*['\"]?(?:1|transient_local)\b")
"""In the QoS with which a topic was offered, of old and new bags."""


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


class BagMessage(NamedTuple):
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
    messages: list[BagMessage] = field(default_factory=list)


def read_bag(path: Path, topics: Collection[str] | None = None) -> BagContent:
    """Read a bag: its folder, or one file of it.

    Args:
        path: of a folder with or without `metadata.yaml`, or of a file.
        topics: those whose messages are wanted; None: all that are not hidden.

    Raises:
        BagError: it is no bag, is compressed as a whole, is cut off, or has no such topic.
    """
    content = BagContent(path)
    for file in _files(path):
        reading = _mcap if file.suffix == ".mcap" else _sqlite
        reading(file, content, topics)
    missing = [topic for topic in topics or () if topic not in content.topics]
    if missing:
        raise BagError(
            f"bag {path}: no topic {missing[0]!r}{nearest(missing[0], list(content.topics))}; it has "
            f"{', '.join(sorted(content.topics)) or 'none'}"
        )
    content.messages.sort(key=lambda message: message.time_ns)
    return content


def _files(path: Path) -> list[Path]:
    if path.is_file():
        return [_readable(path)]
    if not path.is_dir():
        raise BagError(f"bag {path.absolute()}: there is no such file or folder; paths begin where pytest was started")
    metadata = path / _METADATA
    if not metadata.is_file():  # of a recording that was broken off: the files say all that is needed
        files = sorted((file for suffix in _SUFFIXES for file in path.glob(f"*{suffix}*")), key=_number)
        if not files:
            raise BagError(f"bag {path.absolute()}: neither {_METADATA} nor a file *.mcap or *.db3 is in this folder")
        return [_readable(file) for file in files if not file.name.endswith(("-wal", "-shm"))]
    files = [path / Path(name).name for name in _listed(metadata)]
    missing = next((file for file in files if not file.is_file()), None)
    if missing is not None:
        raise BagError(f"{metadata}: it lists {missing.name}, which is not there: is the bag complete?")
    return [_readable(file) for file in files]


def _number(file: Path) -> tuple[int, str]:
    number = re.search(r"_(\d+)\.", file.name)
    return (int(number[1]) if number else 0, file.name)


def _listed(metadata: Path) -> list[str]:
    """The files of a bag. Raises BagError if it cannot be read, or messages are compressed one by one."""
    try:
        bag: Any = yaml.safe_load(metadata.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names, mode = [str(name) for name in bag["relative_file_paths"]], str(bag.get("compression_mode") or "")
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, AttributeError) as error:
        raise BagError(
            f"{metadata}: not the metadata of a bag: {error_text(error)}; `ros2 bag reindex` writes it anew"
        ) from None
    if mode.upper() == "MESSAGE":
        raise BagError(f"{metadata}: messages are compressed one by one ({bag.get('compression_format')}); {_CONVERT}")
    return names


_CONVERT = "write it without compression: `ros2 bag convert -i BAG -o OUTPUT.yaml`"


def _readable(file: Path) -> Path:
    if file.suffix not in _SUFFIXES:
        problem = (
            "is compressed as a whole" if file.suffix in (".zstd", ".zst", ".lz4") else "is neither *.mcap nor *.db3"
        )
        raise BagError(f"bag {file.absolute()}: the file {problem}; {_CONVERT}")
    return file


def _add_topic(content: BagContent, file: Path, name: str, kind: str, encoding: str, qos: str) -> None:
    if encoding != "cdr":
        raise BagError(f"bag {file}: topic {name} has messages in the format {encoding!r}; expected cdr")
    content.topics[name] = BagTopic(kind, _LATCHED.search(qos or "") is not None)


def _is_wanted(name: str, topics: Collection[str] | None) -> bool:
    return name in topics if topics is not None else "/_" not in name


def _sqlite(file: Path, content: BagContent, topics: Collection[str] | None) -> None:
    try:
        connection = sqlite3.connect(f"file:{file.absolute()}?mode=ro", uri=True)
        try:
            _add_rows(connection, file, content, topics)
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise BagError(
            f"bag {file}: not a database that can be read, perhaps cut off: {error}; `sqlite3 {file.name} .recover` "
            "reads what is left"
        ) from None


def _add_rows(connection: sqlite3.Connection, file: Path, content: BagContent, topics: Collection[str] | None) -> None:
    columns = {str(row[1]) for row in connection.execute("PRAGMA table_info(topics)")}
    qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"  # of bags before foxy
    names: dict[int, str] = {}
    for number, name, kind, encoding, offered in connection.execute(
        f"SELECT id, name, type, serialization_format, {qos} FROM topics ORDER BY id"
    ):
        _add_topic(content, file, name, kind, encoding, str(offered))
        names[number] = name
    for number, time_ns, data in connection.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id"):
        if _is_wanted(names[number], topics):
            content.messages.append(BagMessage(time_ns, names[number], bytes(data)))


def _mcap(file: Path, content: BagContent, topics: Collection[str] | None) -> None:
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
    except ModuleNotFoundError as error:
        raise BagError(
            f'bag {file}: {error.name} is needed to read it; install the extra: pip install "pytest-hricdv[traces]"'
        ) from None
    with file.open("rb") as stream:
        try:
            reader = make_reader(stream)
            summary = reader.get_summary()
            for channel in summary.channels.values() if summary is not None else ():
                schema = summary.schemas.get(channel.schema_id) if summary is not None else None
                _add_channel(content, file, channel, schema)
            content.messages.extend(_of_records(reader.iter_messages(), content, file, topics))
        except McapError as error:
            raise BagError(
                f"bag {file}: not an MCAP file that can be read, perhaps cut off: {error_text(error)}; `mcap recover` "
                "reads what is left"
            ) from None


def _add_channel(content: BagContent, file: Path, channel: Any, schema: Any) -> None:
    kind = "" if schema is None else schema.name
    _add_topic(
        content, file, channel.topic, kind, channel.message_encoding, channel.metadata.get("offered_qos_profiles", "")
    )


def _of_records(
    records: Iterable[Any], content: BagContent, file: Path, topics: Collection[str] | None
) -> Iterator[BagMessage]:
    for schema, channel, message in records:
        if channel.topic not in content.topics:
            _add_channel(content, file, channel, schema)
        if _is_wanted(channel.topic, topics):
            yield BagMessage(message.log_time, channel.topic, message.data)
