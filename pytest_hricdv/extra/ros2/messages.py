"""Handles messages of ROS 2 through their generated classes: copies, names of types, fields for a record, and bytes.

- `copy_message` and `type_name` are used by publishers and services, `import_type` wherever a type is named.
- `fields_of` gives the `Bridge` the fields of a message for the record: a flat mapping of names such as
  "pose.position.x" to plain values. An array or a sequence has its length, as `name.length`, and a checksum of its
  content, as `name.crc`: runs with equal hashes had equal messages.
- `serialize` and `deserialize` convert to and from Common Data Representation, little endian (OMG DDSI-RTPS 2.3, 10.2;
  XCDR version 1), as in bags. `SLOT_TYPES` of a generated class has objects whose classes name the kinds of its fields.
"""

from __future__ import annotations

import array
import importlib
import struct
import zlib
from collections.abc import Callable
from ctypes import c_float
from dataclasses import dataclass
from functools import cache
from typing import Any

from pytest_hricdv._base.message import nearest
from pytest_hricdv.declarations.ros2 import Ros2Error
from pytest_hricdv.runtime.record import Value
from pytest_hricdv.runtime.source_location import error_line


@dataclass(frozen=True)
class RosMessage:
    """A message as it was sent.

    Args:
        name: full name of the topic or service.
        direction: "request" or "response" of a service, "" of a topic.
        message: a copy that nobody changes.
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
    """A deep copy of a message, equal to what a receiver would get.

    `rosidl` generates classes with a slot for each field. Values of float32 fields, in Python of double precision, are
    rounded to float32.
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


NS_PER_S = 10**9


def stamp_ns(stamp: Any) -> int:
    """The nanoseconds of a `builtin_interfaces/msg/Time` or `Duration`."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def set_stamp(stamp: Any, time_ns: int) -> None:
    """Set a `builtin_interfaces/msg/Time` or `Duration`."""
    stamp.sec, stamp.nanosec = divmod(time_ns, NS_PER_S)


def type_name(kind: type[Any]) -> str:
    """The name of a message, service or action type, such as "std_msgs/msg/String"."""
    parts = kind.__module__.split(".")
    return "/".join([*parts[:2], kind.__name__])


_PLAIN = (bool, int, float, str)
_CHECKS = "_check_fields"
"""A slot of generated classes that is not a field: whether setters check what they are given."""


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
            # 32 bits are enough: it distinguishes the runs of a suite, and nobody forges messages here.
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
    """Bytes that are not a message of the type, or a type that has no representation here."""


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
            raise struct.error(f"a string of {size} bytes begins at {self._at}")
        self._at += size
        return taken

    def _numbers(self, code: str, count: int) -> list[Any]:
        """A reader of `count` numbers at once: an image has many."""
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


_EXAMPLES = {
    "msg": ("topics", "std_msgs/msg/String"),
    "srv": ("services", "std_srvs/srv/Trigger"),
    "action": ("actions", "my_robot/action/Fetch"),
}
"""Folder of a package -> what its types are of, and one of them."""


def import_type(name: str, folder: str) -> Any:
    """The class of a type such as "std_msgs/msg/String".

    Args:
        folder: what it is: "msg", "srv" or "action".

    Raises:
        Ros2Error: the name is none of such a type, or its package is not installed.
    """
    package, _, rest = name.partition("/")
    found_folder, _, class_name = rest.partition("/")
    if found_folder != folder or not class_name:
        role, example = _EXAMPLES[folder]
        raise Ros2Error(f"ros2: {role} has the type {name!r}; expected one such as {example!r}")
    try:
        module = importlib.import_module(f"{package}.{folder}")
    except ModuleNotFoundError as error:
        if error.name not in (package, f"{package}.{folder}"):
            raise Ros2Error(
                f"ros2: type {name!r}: {package} cannot be imported: {error_line(error)} imports {error.name!r}, "
                "which is not installed; install it"
            ) from error
        raise Ros2Error(
            f"ros2: type {name!r}: there is no Python package {error.name!r}; is the workspace's setup file sourced? "
            "The folder of its interface files is enough: Ros2(interfaces=(...,))"
        ) from None
    try:
        return getattr(module, class_name)
    except AttributeError:
        classes = [member for member in dir(module) if member[0].isupper()]
        raise Ros2Error(f"ros2: {package} has no {folder} {class_name!r}{nearest(class_name, classes)}") from None
