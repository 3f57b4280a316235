"""Messages of ROS 2 as their generated Python classes have them: copies, and the names of their types."""

from __future__ import annotations

import array
from collections.abc import Callable
from ctypes import c_float
from dataclasses import dataclass
from functools import cache
from typing import Any


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
        setattr_direct(made, slot, _copied(getattr(message, slot)))
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


def _copied(value: Any) -> Any:
    if isinstance(value, _IMMUTABLE):
        return value
    if isinstance(value, list):
        return [_copied(element) for element in value]
    if isinstance(value, array.array):
        return value[:]
    if hasattr(type(value), "__slots__") and hasattr(type(value), "get_fields_and_field_types"):
        return copy_message(value)
    return value.copy() if hasattr(value, "copy") else value  # an array of numpy


def type_name(kind: type[Any]) -> str:
    """The name of a message, service or action type, such as "std_msgs/msg/String"."""
    parts = kind.__module__.split(".")
    return "/".join([*parts[:2], kind.__name__])
