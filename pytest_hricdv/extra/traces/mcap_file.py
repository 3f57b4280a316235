"""Traces as MCAP files (https://mcap.dev/spec): JSON messages with JSON Schemas, in the order of virtual time.

The same run gives the same bytes: times are those of the run, from 0 on, and nothing names a machine or a moment.
"""

from __future__ import annotations

import json
from pathlib import Path

from mcap.writer import CompressionType, Writer

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.traces.trace import Channel, Trace

LIBRARY = "pytest-hricdv"


def write(path: Path, trace: Trace) -> None:
    """Write a trace.

    Raises:
        OSError: the file cannot be written; an old one is left as it was.
    """
    with atomic_file.replaced(path) as temporary, temporary.open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(library=LIBRARY)
        writer.add_metadata("hricdv", trace.facts)
        schemas: dict[str, int] = {}
        numbers: dict[Channel, int] = {}
        for event in trace.events():
            channel = event.channel
            if channel not in numbers:
                name, schema = channel.schema
                if name not in schemas:
                    schemas[name] = writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
                numbers[channel] = writer.register_channel(channel.topic, "json", schemas[name], dict(channel.metadata))
            # A text of the code under test may have half a surrogate pair, which UTF-8 has no bytes for.
            data = json.dumps(event.content, ensure_ascii=False).encode("utf-8", "backslashreplace")
            writer.add_message(numbers[channel], event.time_ns, data, event.time_ns)
        writer.finish()  # type: ignore[no-untyped-call]
