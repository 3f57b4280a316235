"""Messages of ROS 2 as their generated Python classes have them: copies, names of their types, and fields for a record.

A record has the fields as a flat mapping of names such as "pose.position.x" to plain values. Of an array or a sequence
it has the length, as `name.length`, and a checksum of the content, as `name.crc`: runs with equal hashes had equal
messages.
"""

from __future__ import annotations

import array
import zlib
from collections.abc import Callable
from ctypes import c_float
from dataclasses import dataclass
from functools import cache
from typing import Any

from pytest_hricdv.runtime.json_value import Value


@dataclass(frozen=True)
class RosMessage:
    """A message as it was sent.

    Args:
        name: full name of the topic or service.
        direction: "request" or "response" of a service, "" of a topic.
        message: nobody changes it any more.
    """

    name: str
    direction: str
    message: Any

    @property
    def type(self) -> str:
        """The name of its type, such as "std_msgs/msg/String"."""
        return type_name(type(self.message))


_IMMUTABLE = (bool, int, float, str, bytes, type(None))


def copy_message(message: Any) -> Any:
    """A copy that shares nothing with the message that can change, as if it had been sent.

    `rosidl` generates classes with a slot for each field. A float32 is rounded to one, which in Python it is not.
    """
    kind: Any = type(message)
    made = kind.__new__(kind)
    for slot in kind.__slots__:
        setattr_direct(made, slot, _copy_value(getattr(message, slot)))
    for slot in _single_slots(kind):
        value = getattr(made, slot)
        if isinstance(value, float):
            setattr_direct(made, slot, c_float(value).value)
    return made


@cache
def _single_slots(kind: Any) -> tuple[str, ...]:
    """The slots of a message's float32 fields. Arrays of such numbers have their precision already."""
    return tuple(f"_{name}" for name, of in kind.get_fields_and_field_types().items() if of == "float")


setattr_direct: Callable[[Any, str, Any], None] = object.__setattr__
"""Sets a slot without the checks of the field's setter, which it has passed."""


def _copy_value(value: Any) -> Any:
    if isinstance(value, _IMMUTABLE):
        return value
    if isinstance(value, list):
        return [_copy_value(element) for element in value]
    if isinstance(value, array.array):
        return value[:]
    if hasattr(type(value), "__slots__") and hasattr(type(value), "get_fields_and_field_types"):
        return copy_message(value)
    return value.copy() if hasattr(value, "copy") else value  # an array of numpy


def type_name(kind: type[Any]) -> str:
    """The name of a message, service or action type, such as "std_msgs/msg/String"."""
    parts = kind.__module__.split(".")
    return "/".join([*parts[:2], kind.__name__])


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
