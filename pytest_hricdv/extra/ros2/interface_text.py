"""Parses interface files (`.msg`, `.srv`, `.action`) with `rosidl_adapter` of ROS 2.

`parts_of` returns the messages of a file, each a `Part` with its fields and constants. `interface_classes` generates
classes from them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import redirect_stderr
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2Error

_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float", "float64": "double"}
"""Name of a basic type in interface files -> its name in IDL, where they differ."""


@dataclass(frozen=True)
class FieldType:
    """The type of a field.

    Args:
        name: the name of a basic type in IDL, or "package/folder/Name".
        size: the size of an array with a fixed size, or the maximum number of elements; None: unbounded.
        is_fixed: whether there are exactly `size` elements.
        max_length: maximum length of a string; None: unbounded.
    """

    name: str
    is_array: bool = False
    size: int | None = None
    is_fixed: bool = False
    max_length: int | None = None

    @property
    def is_message(self) -> bool:
        """Whether the type is another message."""
        return "/" in self.name


@dataclass(frozen=True)
class InterfaceField:
    """A field of a message; `default` is None if the file gives none."""

    name: str
    type: FieldType
    default: Any = None


@dataclass(frozen=True)
class Part:
    """A message, or one part of a service or an action."""

    fields: tuple[InterfaceField, ...]
    constants: tuple[tuple[str, Any], ...] = ()


def parts_of(text: str, package: str, location: str) -> list[Part]:
    """The parts of an interface file: one of a message, two of a service, three of an action.

    Args:
        package: the file's package; for types without a package.
        location: the file's location, for messages.

    Raises:
        Ros2Error: a line is wrong, or `rosidl_adapter` is missing.
    """
    parts: list[tuple[list[InterfaceField], list[tuple[str, Any]]]] = [([], [])]
    for number, line in enumerate(text.splitlines(), start=1):
        if line.rstrip() == "---":
            parts.append(([], []))
            continue
        fields, constants = parts[-1]
        for entry in _entries(line.lstrip(), package, f"{location}:{number}"):
            if hasattr(entry, "value"):
                constants.append((entry.name, bytes([entry.value]) if entry.type == "byte" else entry.value))
            else:
                fields.append(_field(entry))
    return [Part(tuple(fields), tuple(constants)) for fields, constants in parts]


def _entries(line: str, package: str, location: str) -> Iterator[Any]:
    """The fields and constants of one line, as `rosidl_adapter` reads them."""
    try:
        from rosidl_adapter.parser import (  # type: ignore[import-not-found, unused-ignore]
            parse_message_string,
        )
    except ModuleNotFoundError as error:
        raise Ros2Error(
            f"{location}: the package {error.name!r} of ROS 2, which reads interface files, cannot be imported; source "
            "a distribution, or run `pip install ros-rclpy`"
        ) from None
    line = re.sub(r"^Header\b", "std_msgs/Header", line)  # as ROS 1 had it
    try:
        with open(os.devnull, "w") as nowhere, redirect_stderr(nowhere):  # it prints what it raises
            message = parse_message_string(package, "Line", line)
    except Exception as error:  # its errors have no class in common
        raise Ros2Error(f"{location}: {line!r}: {type(error).__name__}: {error}") from None
    yield from message.fields
    yield from message.constants


def _field(entry: Any) -> InterfaceField:
    kind, default = entry.type, entry.default_value
    name = _IDL_NAMES.get(kind.type, kind.type) if kind.pkg_name is None else f"{kind.pkg_name}/msg/{kind.type}"
    if name == "octet" and default is not None:
        default = [bytes([value]) for value in default] if kind.is_array else bytes([default])
    is_fixed = kind.is_array and bool(kind.array_size) and not kind.is_upper_bound
    field_type = FieldType(name, kind.is_array, kind.array_size, is_fixed, kind.string_upper_bound)
    return InterfaceField(entry.name, field_type, default)
