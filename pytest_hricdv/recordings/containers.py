"""Reads the messages of MCAP files and of ROS 2 SQLite files as bytes.

`bags` calls `read_mcap` and `read_sqlite`; each `BagMessage` has its `RecordedTopic`. Files may come from anywhere, so
sizes of messages and of unpacked data are limited, only plain tables and columns are read, no path in a file is
followed, and nothing is opened for writing.
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

MAX_MESSAGE_BYTES = 100_000_000
"""Maximum size (bytes) of a message, and of data unpacked at once: four uncompressed images of 4K."""

MAX_UNPACKING = 200
"""Maximum ratio of unpacked to packed size of a file (chosen): recordings have five to thirty."""

MAX_TOPICS = 100_000
"""Maximum number of topics, and of type definitions, in a file; a robot has hundreds."""


class UnreadableError(ValueError):
    """A message, or the rest of a file, cannot be read; the error gives the reason."""


class RecordedTopic(NamedTuple):
    """A topic: its name, the type of its messages, their encoding, and the definition of the type."""

    name: str
    type: str
    encoding: str
    definition: str


class BagMessage(NamedTuple):
    """A message as recorded: time (ns), bytes, and topic."""

    time_ns: int
    data: bytes
    topic: RecordedTopic


_MCAP_MAGIC = b"\x89MCAP0\r\n"
_HEAD, _MESSAGE_HEAD = struct.Struct("<BQ"), struct.Struct("<HIQQ")


def read_mcap(file: Path) -> Iterator[BagMessage]:
    """The messages of an MCAP file in the order of the file. Raises errors of any kind.

    Records of messages, which there are millions of, are parsed here; all others by the library.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Chunk, Schema

    schemas: dict[int, tuple[str, str]] = {0: ("", "")}
    channels: dict[int, tuple[str, int, str]] = {}
    topics: dict[int, RecordedTopic] = {}
    left = MAX_UNPACKING * max(file.stat().st_size, 1_000_000)
    kinds = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
    with file.open("rb") as stream:  # the index is not used, as truncated files lack it
        for outer, data in _outer_records(stream):
            parts: Iterator[tuple[int, int, int]] = iter(((outer, 0, len(data)),))
            if outer == Opcode.CHUNK:
                data = _unpack(Chunk.read(ReadDataStream(BytesIO(data))))
                left -= len(data)
                if left < 0:
                    raise UnreadableError(f"unpacks to more than {MAX_UNPACKING:,} times its size")
                parts = _records(data)
            for kind, begin, end in parts:
                if kind == _MESSAGE:
                    number, _, time_ns, _ = _MESSAGE_HEAD.unpack_from(data, begin)
                    topic = topics.get(number) or _topic(number, topics, channels, schemas)
                    yield BagMessage(time_ns, data[begin + 22 : end], topic)
                elif kind in kinds:
                    record = ReadDataStream(BytesIO(data[begin:end]))
                    if kind == Opcode.SCHEMA:
                        schema = Schema.read(record)
                        schemas[schema.id] = schema.name, schema.data.decode(errors="replace")
                    else:
                        channel = Channel.read(record)
                        channels[channel.id] = channel.topic, channel.schema_id, channel.message_encoding
                    topics.clear()


_MESSAGE, _FOOTER, _END_OF_DATA = 0x05, 0x02, 0x0F


def _topic(
    number: int,
    topics: dict[int, RecordedTopic],
    channels: dict[int, tuple[str, int, str]],
    schemas: dict[int, tuple[str, str]],
) -> RecordedTopic:
    """The topic of a channel."""
    if number not in channels or channels[number][1] not in schemas:
        raise UnreadableError("not an MCAP file that can be read, or cut off: a message without channel or schema")
    name, schema, encoding = channels[number]
    kind, definition = schemas[schema]
    topics[number] = RecordedTopic(name, kind, encoding, definition)
    return topics[number]


def _outer_records(stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """The records of a file up to the end of its data: their kinds and bytes."""
    if stream.read(len(_MCAP_MAGIC)) != _MCAP_MAGIC:
        raise UnreadableError("not an MCAP file that can be read, or cut off: it does not begin as one")
    while head := stream.read(9):
        kind, length = _HEAD.unpack(head) if len(head) == 9 else (0, 0)
        if not kind or length > MAX_MESSAGE_BYTES:
            raise UnreadableError(f"not an MCAP file that can be read, or cut off: a record of {length:,} bytes")
        data = stream.read(length)
        if len(data) < length:
            raise UnreadableError("not an MCAP file that can be read, or cut off: it ends within a record")
        if kind in (_END_OF_DATA, _FOOTER):
            return
        yield kind, data
    raise UnreadableError("not an MCAP file that can be read, or cut off: it has no end")


def _unpack(chunk: Any) -> bytes:
    """The unpacked content of a chunk, with at most the limit in memory."""
    most = MAX_MESSAGE_BYTES + 1
    if chunk.compression == "zstd":
        import zstandard

        data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(most)
    elif chunk.compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        data = LZ4FrameDecompressor().decompress(chunk.data, most)
    elif chunk.compression:
        raise UnreadableError(f"compressed with {chunk.compression[:20]!r}; expected zstd or lz4")
    else:
        data = chunk.data
    if len(data) >= most:
        raise UnreadableError(f"a chunk unpacks to more than {MAX_MESSAGE_BYTES:,} bytes")
    return bytes(data)


def _records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """The records of a chunk: kind, begin and end. A list would take a hundred times its bytes."""
    place, last = 0, len(data)
    unpack = _HEAD.unpack_from
    while place < last:
        kind, length = unpack(data, place)
        begin = place + 9
        place = begin + length
        if place > last or kind == 0:
            raise UnreadableError("a chunk has an invalid record, or ends within one")
        yield kind, begin, place


def read_sqlite(file: Path) -> Iterator[BagMessage]:
    """The messages of an SQLite file of ROS 2 in the order of the file. Raises errors of any kind."""
    address = f"{file.absolute().as_uri()}?mode=ro&immutable=1"
    with closing(sqlite3.connect(address, uri=True, isolation_level=None)) as database:
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_MESSAGE_BYTES)
        for setting in ("trusted_schema=OFF", "cell_size_check=ON", "query_only=ON", "temp_store=MEMORY"):
            database.execute(f"PRAGMA {setting}")
        # Views and virtual tables, which may be endless or read other files, have no page of their own.
        stored = {
            name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type='table' AND rootpage>0")
        }
        if missing := {"topics", "messages"} - stored:
            raise UnreadableError(f"no recording of ROS 2: without a table {' and '.join(sorted(missing))}")
        definitions: dict[str, str] = {}
        if "message_definitions" in stored:
            asked = "SELECT topic_type, encoded_message_definition FROM message_definitions WHERE encoding='ros2msg'"
            definitions = {str(kind): str(text) for kind, text in database.execute(asked).fetchmany(MAX_TOPICS)}
        asked = "SELECT id, name, type, serialization_format FROM topics"
        topics = {
            number: RecordedTopic(str(name), str(kind), str(encoding), definitions.get(kind, ""))
            for number, name, kind, encoding in database.execute(asked).fetchmany(MAX_TOPICS)
        }
        for number, time_ns, data in database.execute("SELECT topic_id, timestamp, data FROM messages"):
            if not (number in topics and isinstance(time_ns, int) and isinstance(data, bytes)):
                raise UnreadableError("a row of its messages has no topic, time or data")
            if data.startswith(_ZSTD):
                raise UnreadableError("its messages are compressed; convert it with: ros2 bag convert")
            yield BagMessage(time_ns, data, topics[number])


_ZSTD = b"\x28\xb5\x2f\xfd"
"""The first bytes of zstd data; CDR begins with 0."""


def write_ahead_log(path: Path) -> Path | None:
    """The write-ahead log of a database, where it holds what the file itself does not; None if there is none.

    A reader that opens SQLite files as immutable silently misses such a log.

    Args:
        path: the path of an SQLite file, or of a folder of them.
    """
    logs = path.glob("*-wal") if path.is_dir() else [path.with_name(f"{path.name}-wal")]
    return next((log for log in sorted(logs) if log.is_file() and log.stat().st_size), None)
