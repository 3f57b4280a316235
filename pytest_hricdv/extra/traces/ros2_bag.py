"""The messages of ROS 2 of a run as an MCAP file of the profile "ros2": `ros2 bag` and viewers read it.

Messages are CDR, with their definitions; services are in the other file (see `mcap_file`). Times are those that nodes
read from their clocks, so that they go with the stamps in the messages. The same run gives the same bytes.
"""

from __future__ import annotations

from pathlib import Path

from mcap.writer import CompressionType, Writer

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.ros2.cdr import serialize
from pytest_hricdv.extra.ros2.clocks import EPOCH_NS
from pytest_hricdv.extra.ros2.definitions import definition_of
from pytest_hricdv.extra.ros2.messages import RosMessage
from pytest_hricdv.extra.traces.mcap_file import LIBRARY
from pytest_hricdv.extra.traces.trace import ns
from pytest_hricdv.runtime import Record

_PROFILE = "ros2"


def write(path: Path, record: Record) -> bool:
    """Write the messages on topics of a record; whether there are any, otherwise there is no file.

    Raises:
        OSError: the file cannot be written; an old one is left as it was.
    """
    sent = [
        (EPOCH_NS + ns(message.time_s), message.source)
        for message in record.messages
        if isinstance(message.source, RosMessage)
    ]
    published = [(time_ns, source) for time_ns, source in sent if not source.direction]
    if not published:
        return False
    with atomic_file.replaced(path) as temporary, temporary.open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(profile=_PROFILE, library=LIBRARY)
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for number, (time_ns, source) in enumerate(published):
            kind = type(source.message)
            if source.type not in schemas:
                schemas[source.type] = writer.register_schema(source.type, "ros2msg", definition_of(kind).encode())
            if source.name not in channels:
                facts = {"offered_qos_profiles": ""}
                channels[source.name] = writer.register_channel(source.name, "cdr", schemas[source.type], facts)
            data = serialize(source.message, kind)
            writer.add_message(channels[source.name], time_ns, data, time_ns, number)
        writer.finish()  # type: ignore[no-untyped-call]
    return True
