"""`write_bag`: writes the ROS 2 messages of a run as an MCAP file of the profile "ros2", for `ros2 bag` and viewers.

`extra.traces` calls it for each trace, by way of `registry`. Messages are encoded as CDR. Their definitions are made
from the generated classes, since an installation need not have the .msg files. The file has topics only, no services.
Its times are those that nodes read from their clocks, so that they match the stamps in the messages. The same run gives
the same bytes.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from pytest_hricdv._base import atomic_file
from pytest_hricdv.extra.ros2.clocks import EPOCH_NS
from pytest_hricdv.extra.ros2.messages import RosMessage, class_of, serialize, type_name
from pytest_hricdv.runtime import Record
from pytest_hricdv.runtime.kernel import US_PER_S

_PROFILE, _LIBRARY = "ros2", "pytest-hricdv"
_SEPARATOR = "=" * 80  # the MCAP registry's "ros2msg" has it before each additional type, with its name
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(?:, (?P<most>\d+))?>")
_BOUNDED_TEXT = re.compile(r"(w?string)<(\d+)>")
# The generated classes name basic types as IDL does -> the names in .msg files, where they differ.
_NAMES = {"boolean": "bool", "double": "float64", "float": "float32", "octet": "byte"}


def write_bag(path: Path, record: Record) -> bool:
    """Write the messages on topics of a record. Returns whether it has any; without one, no file is written.

    Raises:
        OSError: the file cannot be written; an old one is left as it was.
    """
    sent = [
        (EPOCH_NS + round(message.time_s * US_PER_S) * 1000, message.source)
        for message in record.messages
        if isinstance(message.source, RosMessage)
    ]
    published = [(time_ns, source) for time_ns, source in sent if not source.direction]
    if not published:
        return False
    with atomic_file.replace_file(path) as temporary, temporary.open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(profile=_PROFILE, library=_LIBRARY)
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


def definition_of(kind: Any) -> str:
    """The definition of a class of messages in the language of .msg files, with those that it contains."""
    definitions: dict[str, str] = {}
    _add(kind, definitions)
    first, *others = definitions.items()
    return "\n".join([first[1], *(f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in others)])


def _add(kind: Any, definitions: dict[str, str]) -> None:
    package, _, name = type_name(kind).split("/")
    if f"{package}/{name}" in definitions:
        return
    fields = kind.get_fields_and_field_types()
    definitions[f"{package}/{name}"] = "\n".join(f"{_msg_type(type_)} {field}" for field, type_ in fields.items())
    for type_ in kind.SLOT_TYPES:
        of = getattr(type_, "value_type", type_)
        if hasattr(of, "namespaces"):
            _add(class_of(of), definitions)


def _msg_type(type_: str) -> str:
    """A type as .msg files write it: `sequence<double, 3>` is `float64[<=3]`."""
    sequence = _SEQUENCE.fullmatch(type_)
    if sequence:
        return f"{_msg_type(sequence['of'])}[{'<=' + sequence['most'] if sequence['most'] else ''}]"
    base, bracket, size = type_.partition("[")
    return _NAMES.get(base, _BOUNDED_TEXT.sub(r"\1<=\2", base)) + bracket + size
