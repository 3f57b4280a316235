"""Messages as bytes: Common Data Representation, little endian (OMG DDSI-RTPS 2.3, 10.2; XCDR version 1).

A class that `rosidl` generated says what its fields are: `SLOT_TYPES` has objects whose classes name the kind of type.
"""

from __future__ import annotations

import array
import importlib
import struct
from typing import Any

HEADER = b"\x00\x01\x00\x00"  # CDR_LE, and two bytes of options, which are 0
_FORMATS = {
    "boolean": "?",
    "octet": "c",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float": "f",
    "double": "d",
}
"""Basic type of IDL -> format of `struct`."""


class CdrError(ValueError):
    """Bytes that are no message of the type, or a type that has no representation here."""


def serialize(message: Any, kind: type[Any]) -> bytes:
    """The bytes of a message."""
    out = bytearray()
    _write_message(out, message)
    return HEADER + bytes(out)


def deserialize(data: bytes, kind: type[Any]) -> Any:
    """The message of some bytes. Raises CdrError if they are too few, or not little endian."""
    if bytes(data[:2]) != HEADER[:2]:
        raise CdrError(f"{kind.__name__}: expected little-endian CDR, whose first bytes are 00 01")
    try:
        return Reader(bytes(data[len(HEADER) :])).message(kind)
    except struct.error as error:
        raise CdrError(f"{kind.__name__}: {len(data)} bytes are too few: {error}") from None


def _format(typename: str) -> str:
    if typename not in _FORMATS:
        raise CdrError(f"a field of type {typename} has no representation here")
    return _FORMATS[typename]


def _fields(kind: Any) -> list[tuple[str, Any]]:
    return list(zip(kind.get_fields_and_field_types(), kind.SLOT_TYPES, strict=True))


def _is_wide(type_: Any) -> bool:
    return type(type_).__name__.endswith("WString")


def _write_message(out: bytearray, message: Any) -> None:
    fields = _fields(type(message))
    for name, type_ in fields:
        _write(out, type_, getattr(message, name))
    if not fields:
        out.append(0)  # a structure of C needs a member


def _pack(out: bytearray, code: str, value: Any) -> None:
    size = struct.calcsize(code)
    # Aligned to its own size, counted from after the header.
    out.extend(bytes(-len(out) % size))
    out.extend(struct.pack(f"<{code}", value))


def _write(out: bytearray, type_: Any, value: Any) -> None:
    if hasattr(type_, "value_type"):
        if not hasattr(type_, "size"):
            _pack(out, "I", len(value))
        for element in value:
            _write(out, type_.value_type, element)
    elif hasattr(type_, "typename"):
        _pack(out, _format(type_.typename), value)
    elif hasattr(type_, "namespaces"):
        _write_message(out, value)
    elif _is_wide(type_):
        encoded = value.encode("utf-16-le")
        _pack(out, "I", len(encoded) // 2)
        out.extend(encoded)
    else:
        encoded = value.encode() + b"\x00"  # the length counts the final zero; that of wide texts has none
        _pack(out, "I", len(encoded))
        out.extend(encoded)


class Reader:
    """Reads values one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def message(self, kind: Any) -> Any:
        """The next message of a class."""
        fields = _fields(kind)
        made = kind()
        for name, type_ in fields:
            setattr(made, name, self._like(getattr(made, name), self.value(type_, getattr(made, name))))
        if not fields:
            self.unpack("B")
        return made

    @staticmethod
    def _like(default: Any, value: Any) -> Any:
        """Values in the container that the field has: an array of Python or numpy, or a list."""
        if isinstance(default, array.array):
            return array.array(default.typecode, value)
        if hasattr(default, "dtype"):
            made = default.copy()
            made[:] = value
            return made
        return value

    def unpack(self, code: str) -> Any:
        """The next number of a format of `struct`."""
        size = struct.calcsize(code)
        self._at += -self._at % size
        (value,) = struct.unpack_from(f"<{code}", self._data, self._at)
        self._at += size
        return value

    def _take(self, size: int) -> bytes:
        taken = self._data[self._at : self._at + size]
        if len(taken) < size:
            raise struct.error(f"a text of {size} bytes begins at {self._at}")
        self._at += size
        return taken

    def _numbers(self, code: str, count: int) -> list[Any]:
        """So many numbers: those of an image are many."""
        size = struct.calcsize(code)
        self._at += -self._at % size if count else 0
        values = struct.unpack_from(f"<{count}{code}", self._data, self._at)
        self._at += size * count
        return list(values)

    def value(self, type_: Any, default: Any) -> Any:
        """The next value of a type."""
        if hasattr(type_, "value_type"):
            count = type_.size if hasattr(type_, "size") else self.unpack("I")
            if hasattr(type_.value_type, "typename"):
                return self._numbers(_format(type_.value_type.typename), count)
            return [self.value(type_.value_type, None) for _ in range(count)]
        if hasattr(type_, "typename"):
            return self.unpack(_format(type_.typename))
        if hasattr(type_, "namespaces"):
            return self.message(type(default) if default is not None else class_of(type_))
        if _is_wide(type_):
            return self._take(2 * self.unpack("I")).decode("utf-16-le")
        return self._take(self.unpack("I"))[:-1].decode()


def class_of(type_: Any) -> Any:
    """The class of the messages in a sequence, which the default of the field does not show."""
    return getattr(importlib.import_module(".".join(type_.namespaces)), type_.name)
