"""Recordings as other tools write them: MCAP with JSON or CDR, and bags of SQLite."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

BEGAN_NS = 1_700_000_000 * 10**9
"""A time of the system, as recorders use it."""

STRING = "std_msgs/msg/String"
DEFINITIONS = {
    STRING: "string data\n",
    "cell_msgs/msg/Tray": "cell_msgs/Pose pose\nuint8 cups\nfloat32[] loads\nbool is_wet\n"
    + "=" * 80
    + "\nMSG: cell_msgs/Pose\nfloat64 x\nfloat64 y\n",
    "rosgraph_msgs/msg/ClockPort": "builtin_interfaces/Time clock\n"
    + "=" * 80
    + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
}

Entry = tuple[float, str, Any]
"""When (s), topic, content."""


def text(data: str) -> bytes:
    """A `std_msgs/msg/String` as CDR."""
    encoded = data.encode() + b"\x00"
    return b"\x00\x01\x00\x00" + struct.pack("<I", len(encoded)) + encoded


def tray(x: float, y: float, cups: int, loads: Sequence[float], is_wet: bool) -> bytes:
    """A `cell_msgs/msg/Tray` as CDR."""
    body = struct.pack("<ddB3xI", x, y, cups, len(loads)) + struct.pack(f"<{len(loads)}f?", *loads, is_wet)
    return b"\x00\x01\x00\x00" + body


def clock(time_s: float) -> bytes:
    """A `rosgraph_msgs/msg/ClockPort` as CDR."""
    seconds = int(time_s)
    return b"\x00\x01\x00\x00" + struct.pack("<iI", seconds, round((time_s - seconds) * 1e9))


def write_mcap(
    file: Path,
    entries: Sequence[Entry],
    types: Mapping[str, str] | None = None,
    encoding: str = "",
    *,
    packed: bool = False,
) -> Path:
    """Write an MCAP file; messages of JSON where no types are given."""
    with file.open("wb") as stream:
        writer = McapWriter(
            stream, compression=CompressionType.ZSTD if packed else CompressionType.NONE, chunk_size=200
        )
        writer.start(profile="ros2" if types else "")
        channels = {}
        for topic in dict.fromkeys(topic for _, topic, _ in entries):
            kind = (types or {}).get(topic, "")
            definition = DEFINITIONS.get(kind, "")
            schema = writer.register_schema(kind or topic, "ros2msg" if types else "jsonschema", definition.encode())
            channels[topic] = writer.register_channel(topic, encoding or ("cdr" if types else "json"), schema)
        for time_s, topic, content in entries:
            data = content if isinstance(content, bytes) else json.dumps(content).encode()
            time_ns = BEGAN_NS + round(time_s * 1e9)
            writer.add_message(channels[topic], time_ns, data, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]
    return file


def write_sqlite(folder: Path, entries: Sequence[Entry], types: Mapping[str, str]) -> Path:
    """Write a bag of SQLite, as a folder."""
    store = get_typestore(Stores.EMPTY)
    for kind in dict.fromkeys(types.values()):
        parsed = get_types_from_msg(DEFINITIONS[kind], kind)
        store.register({name: made for name, made in parsed.items() if name not in store.fielddefs})
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {
            topic: writer.add_connection(topic, types[topic], typestore=store)
            for topic in dict.fromkeys(topic for _, topic, _ in entries)
        }
        for time_s, topic, data in entries:
            writer.write(connections[topic], BEGAN_NS + round(time_s * 1e9), data)
    return folder
