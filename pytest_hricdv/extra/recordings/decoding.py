"""The fields of recorded messages: of ROS 2 by the definitions of their types, of JSON as they are."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.extra.ros2.cdr import HEADER, CdrError, Reader
from pytest_hricdv.extra.ros2.interface_classes import slot_type
from pytest_hricdv.extra.ros2.interface_text import Part, parts_of

Value = bool | float | str | tuple[float, ...]
"""Of a field; the numbers of an array."""

_SEPARATOR = re.compile(r"^={40,}\s*$", re.MULTILINE)
"""Between the definitions of types in one text (https://mcap.dev/spec/registry#ros2msg)."""

_DEEPEST = 8
"""Messages in messages that are read (chosen: a pose with covariance and stamp has four)."""


MOST_ELEMENTS = 1000
"""Of an array, so many are looked at one by one (chosen: an image has millions)."""


class UnreadableError(ValueError):
    """The bytes of a message cannot be read; the text says why."""


class Definitions:
    """The definitions of types of ROS 2: those that came with a bag, else those of interface files.

    Args:
        file_of: the interface file of a type such as "std_msgs/msg/Bool"; None where there is none.
    """

    def __init__(self, file_of: Callable[[str], Path | None]) -> None:
        self._file_of = file_of
        self._texts: dict[str, str] = {}
        self._parts: dict[str, Part] = {}

    def add(self, kind: str, text: str) -> None:
        """A definition of a bag, with those of the types in it."""
        first, *others = _SEPARATOR.split(text)
        self._texts.setdefault(kind, first)
        for other in others:
            head, _, body = other.strip().partition("\n")
            name = head.removeprefix("MSG:").strip().split("/")
            if len(name) > 1:
                self._texts.setdefault(f"{name[0]}/msg/{name[-1]}", body)

    def part(self, kind: str) -> Part:
        """The fields of a type.

        Raises:
            UnreadableError: it is defined nowhere, or not as ROS defines types.
        """
        if kind not in self._parts:
            try:
                self._parts[kind] = parts_of(self._text(kind), kind.partition("/")[0], kind)[0]
            except (Ros2Error, OSError, ValueError) as error:
                raise UnreadableError(str(error)) from None
        return self._parts[kind]

    def _text(self, kind: str) -> str:
        if kind in self._texts:
            return self._texts[kind]
        file = self._file_of(kind) if kind.count("/") == 2 else None
        if file is None:
            raise UnreadableError(f"type {kind or 'unknown'} is defined neither in it, nor here: install its package")
        return file.read_text(encoding="utf-8")


class _DefinedReader(Reader):
    """Reads messages without their classes."""

    def __init__(self, data: bytes, definitions: Definitions) -> None:
        super().__init__(data)
        self._definitions = definitions
        self._depth = 0

    def fields(self, kind: str) -> dict[str, Any]:
        """The fields of the next message."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise UnreadableError(f"type {kind}: messages in messages are nested more than {_DEEPEST} deep")
        part = self._definitions.part(kind)
        values = {entry.name: self.value(slot_type(entry.type), None) for entry in part.fields}
        if not part.fields:
            self.unpack("B")
        self._depth -= 1
        return values

    def nested(self, type_: Any, default: Any) -> Any:
        """See `Reader.nested`."""
        return self.fields("/".join([*type_.namespaces, type_.name]))


def of_cdr(data: bytes, kind: str, definitions: Definitions) -> dict[str, Value]:
    """The fields of a message of ROS 2.

    Raises:
        UnreadableError: the bytes are no message of this type, or it is not known.
    """
    if bytes(data[:2]) != HEADER[:2]:
        raise UnreadableError("its bytes are no little-endian CDR")
    try:
        content = _DefinedReader(bytes(data[len(HEADER) :]), definitions).fields(kind)
    except (CdrError, UnicodeDecodeError, OverflowError) as error:
        raise UnreadableError(f"its bytes are no {kind}: {error}") from None
    except Exception as error:  # of `struct`, for which there is one class only
        if type(error).__name__ != "error":
            raise
        raise UnreadableError(f"its {len(data)} bytes are too few for {kind}") from None
    return dict(_flat(content, ""))


def of_json(data: bytes) -> dict[str, Value]:
    """The fields of a message of JSON. Raises UnreadableError where it is no object."""
    try:
        content = json.loads(data)
    except (ValueError, RecursionError):
        raise UnreadableError("its bytes are no JSON") from None
    if not isinstance(content, dict):
        raise UnreadableError("its JSON is no object")
    return dict(_flat(content, ""))


def _flat(content: Mapping[str, Any], above: str) -> Iterator[tuple[str, Value]]:
    """Fields, those of messages in it by paths (`linear.x`)."""
    for name, value in content.items():
        path = f"{above}{name}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{path}.")
        elif isinstance(value, bool | str):
            yield path, value
        elif isinstance(value, int | float):
            yield path, float(value)
        elif isinstance(value, list) and value:
            elements = _some(value)
            if all(type(element) in (int, float) for element in elements):
                yield path, tuple(map(float, elements))


def _some(values: list[Any]) -> list[Any]:
    """The elements of an array; of a long one, as an image, the extremes and some at equal distances."""
    step = -(-len(values) // MOST_ELEMENTS)
    if step == 1 or not isinstance(values[0], int | float):
        return values[:MOST_ELEMENTS]
    return [min(values), max(values), *values[::step]]
