"""Reads the messages of MCAP files and of ROS 2 SQLite files as bytes.

Such files come from anywhere. What they unpack to, how long a message is, and which tables and columns are looked at
is limited here; no name in a file is followed, and none is opened for writing.
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any

MAX_MESSAGE_BYTES = 100_000_000
"""Greatest size of a message, and of what is unpacked at once: four images of 4K that are not compressed."""

MAX_UNPACKING = 200
"""How many times its size a file may unpack to (chosen): recordings do five to thirty times."""

MAX_TOPICS = 100_000
"""Topics, and definitions of types; a robot has hundreds."""


class UnreadableError(ValueError):
    """A message, or the rest of a file, cannot be read; the text says why."""


@dataclass(frozen=True, slots=True)
class BagMessage:
    """A message as it was written: when (ns), on which topic, its type, encoding and bytes, and the definition."""

    time_ns: int
    topic: str
    type: str
    encoding: str
    data: bytes
    definition: str


def read_mcap(file: Path) -> Iterator[BagMessage]:
    """The messages of an MCAP file in the order in which they were written. Raises errors of any kind."""
    from mcap.records import Channel, Chunk, Message, Schema
    from mcap.stream_reader import StreamReader

    schemas: dict[int, tuple[str, str]] = {0: ("", "")}
    channels: dict[int, tuple[str, str, int]] = {}
    left = MAX_UNPACKING * max(file.stat().st_size, 1_000_000)
    with file.open("rb") as stream:  # needs no index, which a file that was cut off has not
        for outer in StreamReader(stream, emit_chunks=True, record_size_limit=MAX_MESSAGE_BYTES).records:
            data = _unpack(outer) if isinstance(outer, Chunk) else b""
            left -= len(data)
            if left < 0:
                raise UnreadableError(f"unpacks to more than {MAX_UNPACKING:,} times its size")
            for record in _records(data) if isinstance(outer, Chunk) else (outer,):
                if isinstance(record, Schema):
                    schemas[record.id] = record.name, record.data.decode(errors="replace")
                elif isinstance(record, Channel):
                    channels[record.id] = record.topic, record.message_encoding, record.schema_id
                elif isinstance(record, Message):
                    topic, encoding, schema = channels[record.channel_id]
                    kind, definition = schemas[schema]
                    yield BagMessage(record.log_time, topic, kind, encoding, record.data, definition)


def _unpack(chunk: Any) -> bytes:
    """What a chunk has packed; never more than the limit is in memory."""
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


def _records(data: bytes) -> Iterator[Any]:
    """The records of a chunk, one after the other: a list of them would take a hundred times their bytes."""
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Message, Schema

    kinds: dict[int, Any] = {Opcode.CHANNEL: Channel, Opcode.SCHEMA: Schema}
    place = 0
    while place < len(data):
        opcode, length = struct.unpack_from("<BQ", data, place)
        place += 9 + length
        if place > len(data) or opcode == 0:
            raise UnreadableError("a chunk has a record that is none, or ends within one")
        if opcode == Opcode.MESSAGE:
            yield Message.read(ReadDataStream(BytesIO(data[place - length : place])), length)
        elif opcode in kinds:
            yield kinds[opcode].read(ReadDataStream(BytesIO(data[place - length : place])))


def read_sqlite(file: Path) -> Iterator[BagMessage]:
    """The messages of an SQLite file of ROS 2 in the order in which they were written. Raises errors of any kind."""
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
            number: BagMessage(0, str(name), str(kind), str(encoding), b"", definitions.get(kind, ""))
            for number, name, kind, encoding in database.execute(asked).fetchmany(MAX_TOPICS)
        }
        for number, time_ns, data in database.execute("SELECT topic_id, timestamp, data FROM messages"):
            if not (number in topics and isinstance(time_ns, int) and isinstance(data, bytes)):
                raise UnreadableError("a row of its messages has no topic, time or data")
            if data.startswith(_ZSTD):
                raise UnreadableError("its messages are compressed; write it anew with: ros2 bag convert")
            yield replace(topics[number], time_ns=time_ns, data=data)


_ZSTD = b"\x28\xb5\x2f\xfd"
"""What zstd begins with; CDR begins with 0."""
