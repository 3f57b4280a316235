"""The fields of message classes (`fields_of`), and a message's fields for the record (`record_fields`), as a flat dict.

The bus records each message so, with names such as `place.x_m`; `testbench_faults` checks message classes.
"""

from __future__ import annotations

import dataclasses
import zlib
from collections import deque
from collections.abc import Iterable, Mapping, Set
from enum import Enum

from pytest_hricdv.runtime.record import Value, plain, text_of

FORMS = "dataclasses, named tuples, or classes of attrs, msgspec or pydantic"
"""The classes that can be messages, in words."""


def fields_of(kind: object) -> tuple[str, ...] | None:
    """The fields of the instances of a class, in their order; None if it can be no message.

    Nothing but what the class itself has is asked, so that none of these libraries is needed.

    >>> from typing import NamedTuple
    >>> class Light(NamedTuple):
    ...     level: float
    >>> fields_of(Light), fields_of(str)
    (('level',), None)
    """
    if not isinstance(kind, type):
        return None
    if dataclasses.is_dataclass(kind):
        return tuple(member.name for member in dataclasses.fields(kind))
    if issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return tuple(kind._fields)
    attributes = getattr(kind, "__attrs_attrs__", None)
    if attributes is not None:
        return tuple(attribute.name for attribute in attributes)
    for name in ("__struct_fields__", "__pydantic_fields__"):  # of msgspec, of pydantic 2
        fields = getattr(kind, name, None)
        if fields is not None:
            return tuple(fields)
    return None


def is_message(value: object) -> bool:
    """Whether a value is an instance of such a class."""
    return fields_of(type(value)) is not None


EXPECTED = "a number, a bool, a string, a message, or a list, tuple, set or dict of these"


def record_fields(message: object, names: Iterable[str], above: str = "") -> dict[str, Value]:
    """The fields of a message; fields of a nested message have paths, and fields that are None are left out.

    Of a list, a tuple, a set, a dict or an array there is the length, as `name.length`, and a checksum of its content,
    as `name.crc`, so that runs with equal hashes had equal messages. So it is with messages of ROS 2.

    Args:
        message: the message to record.
        names: the names of its fields.
        above: the path of the message, with a dot at its end.

    Raises:
        TypeError: a value is something else; the text is of the field and its value.

    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Place:
    ...     x_m: float
    ...     room: str | None = None
    >>> @dataclass
    ... class Order:
    ...     to: Place
    ...     items: list[str]
    >>> record_fields(Order(Place(1.5), ["cup", "plate"]), ["to", "items"])
    {'to.x_m': 1.5, 'items.length': 2, 'items.crc': 3738132480}
    """
    fields: dict[str, Value] = {}
    for name in names:
        path, value = above + name, getattr(message, name)
        single = text_of(value) if isinstance(value, Enum) else plain(value)
        if single is not None:
            fields[path] = single
        elif (inner := fields_of(type(value))) is not None:
            fields.update(record_fields(value, inner, f"{path}."))
        elif value is not None:
            content = _content(value)
            if content is None:
                raise TypeError(f"{path} is {value!r}: expected {EXPECTED}")
            fields[f"{path}.length"] = len(value)
            # 32 bits are enough: it distinguishes the runs of a suite, and nobody forges messages here.
            fields[f"{path}.crc"] = zlib.crc32(content)
    return fields


def _content(value: object) -> bytes | None:
    """The content of a collection, the same in each process; None if something in it has none of its own."""
    if isinstance(value, bytes | bytearray):
        return bytes(value)
    to_bytes = getattr(value, "tobytes", None)
    if callable(to_bytes):  # arrays of Python and numpy, and a memoryview
        return bytes(to_bytes())
    text = _text(value) if isinstance(value, Mapping | Set | list | tuple | deque) else None
    return None if text is None else text.encode()


def _text(value: object) -> str | None:
    """A value as a text that says all of it: what a set or a dict has is sorted, as its order may be of the process."""
    if value is None:
        return "None"
    single = text_of(value) if isinstance(value, Enum) else plain(value)
    if single is not None:
        return repr(single)
    names = fields_of(type(value))
    if names is not None:
        parts = [(name, _text(getattr(value, name))) for name in names]
        return _join("(", [text and f"{name}={text}" for name, text in parts])
    if isinstance(value, Mapping):
        items = [(_text(key), _text(of_key)) for key, of_key in value.items()]
        return _join("{", [key and text and f"{key}: {text}" for key, text in items], is_sorted=True)
    if isinstance(value, Set):
        return _join("{", [_text(member) for member in value], is_sorted=True)
    return _join("[", [_text(member) for member in value]) if isinstance(value, list | tuple | deque) else None


def _join(bracket: str, texts: list[str | None], *, is_sorted: bool = False) -> str | None:
    whole = [text for text in texts if text is not None]
    return bracket + ", ".join(sorted(whole) if is_sorted else whole) if len(whole) == len(texts) else None
