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
        encoding: of its messages: "cdr" as ROS 2 writes them, "json".
        definition: of the type in the language of .msg files, with those in it; empty where the bag has none.
    """

    type: str
    latched: bool
    encoding: str = "cdr"
    definition: str = ""


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
        any_encoding: whether topics may have messages that are not CDR.
    """

    path: Path
    topics: dict[str, BagTopic] = field(default_factory=dict)
    messages: list[BagMessage] = field(default_factory=list)
    any_encoding: bool = False


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
        content.messages.extend(message for message in reading(file, content) if _is_wanted(message.topic, topics))
    missing = [topic for topic in topics or () if topic not in content.topics]
    if missing:
        raise BagError(
            f"bag {path}: no topic {missing[0]!r}{nearest(missing[0], list(content.topics))}; it has "
            f"{', '.join(sorted(content.topics)) or 'none'}"
        )
    content.messages.sort(key=lambda message: message.time_ns)
    return content


def files_left(path: Path) -> tuple[list[Path], list[BagError]]:
    """The files of a bag that can be read, whatever is wrong with it; and what is wrong."""
    try:
        return _files(path), []
    except BagError as error:
        files = sorted((file for suffix in _SUFFIXES for file in path.glob(f"*{suffix}")), key=_number)
        return (files if path.is_dir() else []), [error]


def messages_left(file: Path, content: BagContent) -> Iterator[BagMessage]:
    """The messages of one file in the order in which they were written, up to where it is broken.

    Raises:
        BagError: after the last message that can be read, where the file is broken there.
    """
    return _mcap(file, content, in_order_of_time=False) if file.suffix == ".mcap" else _sqlite(file, content)


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


def _add_topic(content: BagContent, file: Path, name: str, topic: BagTopic) -> None:
    if topic.encoding != "cdr" and not content.any_encoding:
        raise BagError(f"bag {file}: topic {name} has messages in the format {topic.encoding!r}; expected cdr")
    content.topics[name] = topic


def _is_latched(qos: str) -> bool:
    return _LATCHED.search(qos or "") is not None


def _is_wanted(name: str, topics: Collection[str] | None) -> bool:
    return name in topics if topics is not None else "/_" not in name


def _sqlite(file: Path, content: BagContent) -> Iterator[BagMessage]:
    try:
        connection = sqlite3.connect(f"file:{file.absolute()}?mode=ro", uri=True)
        try:
            yield from _rows(connection, file, content)
        finally:
            connection.close()
    except sqlite3.Error as error:
        raise BagError(
            f"bag {file}: not a database that can be read, perhaps cut off: {error}; `sqlite3 {file.name} .recover` "
            "reads what is left"
        ) from None


def _rows(connection: sqlite3.Connection, file: Path, content: BagContent) -> Iterator[BagMessage]:
    columns = {str(row[1]) for row in connection.execute("PRAGMA table_info(topics)")}
    qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"  # of bags before foxy
    definitions = _definitions(connection)
    names: dict[int, str] = {}
    for number, name, kind, encoding, offered in connection.execute(
        f"SELECT id, name, type, serialization_format, {qos} FROM topics ORDER BY id"
    ):
        topic = BagTopic(kind, _is_latched(str(offered)), encoding, definitions.get(kind, ""))
        _add_topic(content, file, name, topic)
        names[number] = name
    for number, time_ns, data in connection.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id"):
        if number not in names:
            raise BagError(f"bag {file}: a message is of a topic that it has not, number {number}: is it complete?")
        yield BagMessage(time_ns, names[number], bytes(data))


def _definitions(connection: sqlite3.Connection) -> dict[str, str]:
    """Type -> its definition, in bags since iron."""
    if not list(connection.execute("PRAGMA table_info(message_definitions)")):
        return {}
    rows = connection.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
    return {str(kind): str(text) for kind, encoding, text in rows if encoding == "ros2msg"}


def _mcap(file: Path, content: BagContent, *, in_order_of_time: bool = True) -> Iterator[BagMessage]:
    try:
        from mcap.reader import NonSeekingReader, make_reader
    except ModuleNotFoundError as error:
        raise BagError(
            f'bag {file}: {error.name} is needed to read it; install the extra: pip install "pytest-hricdv[traces]"'
        ) from None
    with file.open("rb") as stream:
        try:
            if in_order_of_time:
                reader = make_reader(stream)
                summary = reader.get_summary()
                for channel in summary.channels.values() if summary is not None else ():
                    schema = summary.schemas.get(channel.schema_id) if summary is not None else None
                    _add_channel(content, file, channel, schema)
                records = reader.iter_messages()
            else:
                records = NonSeekingReader(stream).iter_messages(log_time_order=False)
            yield from _of_records(records, content, file)
        except BagError:
            raise
        except Exception as error:  # its own, and those of `struct`, of texts and of decompression: it is cut off
            raise BagError(
                f"bag {file}: not an MCAP file that can be read, perhaps cut off: {error_text(error)}; `mcap recover` "
                "reads what is left"
            ) from None


def _add_channel(content: BagContent, file: Path, channel: Any, schema: Any) -> None:
    kind = "" if schema is None else schema.name
    is_defined = schema is not None and schema.encoding == "ros2msg"
    definition = schema.data.decode(errors="replace") if is_defined else ""
    latched = _is_latched(channel.metadata.get("offered_qos_profiles", ""))
    _add_topic(content, file, channel.topic, BagTopic(kind, latched, channel.message_encoding, definition))


def _of_records(records: Iterable[Any], content: BagContent, file: Path) -> Iterator[BagMessage]:
    for schema, channel, message in records:
        if channel.topic not in content.topics:
            _add_channel(content, file, channel, schema)
        yield BagMessage(message.log_time, channel.topic, message.data)
