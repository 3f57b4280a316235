"""Messages of ROS 2 as a record has them: a flat mapping of names such as "pose.position.x" to plain values.

Of an array or a sequence the record has the length, as `name.length`, and a checksum of its content, as `name.crc`, so
that runs with equal hashes had equal messages.
"""

from __future__ import annotations

import zlib
from functools import cache
from typing import Any

from pytest_hricdv.runtime.plain import Value

_PLAIN = (bool, int, float, str)
_CHECKS = "_check_fields"
"""A slot of generated classes that is no field: whether setters check what they are given."""


def fields_of(message: Any, above: str = "") -> dict[str, Value]:
    """The fields of a message, those of nested messages included."""
    fields: dict[str, Value] = {}
    for slot in message.__slots__:
        if slot == _CHECKS:
            continue
        name, value = above + slot.removeprefix("_"), getattr(message, slot)
        if isinstance(value, _PLAIN):
            fields[name] = value
        elif hasattr(value, "get_fields_and_field_types"):
            fields.update(fields_of(value, f"{name}."))
        else:
            fields[f"{name}.length"] = len(value)
            # 32 bits are enough: it tells runs of one suite apart, and nobody forges messages here.
            fields[f"{name}.crc"] = zlib.crc32(_bytes(value))
    return fields


def _bytes(value: Any) -> bytes:
    """The content of an array of numbers, of bytes, or of a list."""
    if isinstance(value, bytes):
        return value
    if hasattr(value, "tobytes"):
        made = value.tobytes()
        assert isinstance(made, bytes)
        return made
    return repr([fields_of(element) if hasattr(element, "__slots__") else element for element in value]).encode()


@cache
def kinds_of(kind: type[Any]) -> dict[str, type[bool] | type[float] | type[str]]:
    """The types that requirements see of the fields of a class of messages."""
    values = fields_of(kind())
    return {name: type(value) if isinstance(value, bool | str) else float for name, value in values.items()}
