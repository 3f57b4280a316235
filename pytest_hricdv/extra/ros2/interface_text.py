"""Interface files of ROS 2, as text: the fields and constants of `.msg`, `.srv` and `.action` files.

As the ROS 2 documentation "About interfaces" describes them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2Error

NUMBERS = {
    "byte": "octet",
    "char": "uint8",  # since ROS 2 dashing, where IDL has it so
    "float32": "float",
    "float64": "double",
    **{f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
"""Name of a type of numbers in interface files -> in IDL."""

_TEXTS = ("string", "wstring")
_TYPE = re.compile(r"(?P<name>[A-Za-z]\w*(?:/\w+){0,2})(?:<=(?P<most>\d+))?(?P<array>\[(?P<bound><=)?(?P<size>\d*)\])?")
_ENTRY = re.compile(rf"(?P<type>{_TYPE.pattern})\s+(?P<field>[A-Za-z]\w*)\s*(?P<rest>.*)", re.DOTALL)
_SEPARATOR = re.compile(r"---\s*")


@dataclass(frozen=True)
class FieldType:
    """The type of a field.

    Args:
        name: of a type of numbers in IDL, "boolean", "string", "wstring", or "package/folder/Name".
        is_array: whether there are several.
        size: of an array with a fixed size, or the most elements; None: any number.
        is_fixed: whether there are exactly `size`.
        most: characters of a text; None: any number.
    """

    name: str
    is_array: bool = False
    size: int | None = None
    is_fixed: bool = False
    most: int | None = None

    @property
    def is_message(self) -> bool:
        """Whether it is another message."""
        return "/" in self.name


@dataclass(frozen=True)
class InterfaceField:
    """A field of a message; `default` is None where the file says none."""

    name: str
    type: FieldType
    default: Any = None


@dataclass(frozen=True)
class Part:
    """A message, or one part of a service or an action."""

    fields: tuple[InterfaceField, ...]
    constants: tuple[tuple[str, Any], ...]


def parts_of(text: str, package: str, place: str) -> list[Part]:
    """The parts of a file: one of a message, two of a service, three of an action.

    Args:
        package: that the file is of, for types without a package.
        place: of the file, for messages.

    Raises:
        Ros2Error: a line is no field, no constant and no comment.
    """
    parts, lines = [], list[tuple[int, str]]()
    for number, line in enumerate(text.splitlines(), start=1):
        if _SEPARATOR.fullmatch(line):
            parts.append(_part(lines, package, place))
            lines = []
        else:
            lines.append((number, line))
    return [*parts, _part(lines, package, place)]


def _part(lines: Sequence[tuple[int, str]], package: str, place: str) -> Part:
    fields, constants = [], []
    for number, line in lines:
        content = _without_comment(line)
        if not content:
            continue
        entry = _ENTRY.fullmatch(content)
        if entry is None:
            problem = f"{content!r} is neither a field, as `float64 x`, nor a constant, `uint8 A=1`"
            raise Ros2Error(f"{place}:{number}: {problem}")
        kind, name, rest = _type(entry, package), entry["field"], entry["rest"]
        try:
            if rest.startswith("=") and not kind.is_array:
                constants.append((name, _value(kind, rest[1:].strip())))
            else:
                fields.append(InterfaceField(name, kind, _value(kind, rest) if rest else None))
        except (KeyError, ValueError, SyntaxError, TypeError):
            raise Ros2Error(f"{place}:{number}: {rest!r} is no value of type {entry['type']}") from None
    return Part(tuple(fields), tuple(constants))


def _without_comment(line: str) -> str:
    """The content of a line: a text may have "#" in it."""
    quote = ""
    for index, character in enumerate(line):
        if quote:
            quote = "" if character == quote and line[index - 1] != "\\" else quote
        elif character in "\"'":
            quote = character
        elif character == "#":
            return line[:index].strip()
    if quote:  # an apostrophe in a text that has no quotes around it
        return line.partition("#")[0].strip()
    return line.strip()


def _type(entry: re.Match[str], package: str) -> FieldType:
    return FieldType(
        _full_name(entry["name"], package),
        is_array=entry["array"] is not None,
        size=int(entry["size"]) if entry["size"] else None,
        is_fixed=bool(entry["size"]) and entry["bound"] is None,
        most=int(entry["most"]) if entry["most"] else None,
    )


def _full_name(name: str, package: str) -> str:
    if name == "bool":
        return "boolean"
    if name in NUMBERS or name in _TEXTS:
        return NUMBERS.get(name, name)
    if name == "Header":  # as ROS 1 had it
        return "std_msgs/msg/Header"
    parts = name.split("/")
    return "/".join([parts[0] if len(parts) > 1 else package, "msg", parts[-1]])


def _value(kind: FieldType, text: str) -> Any:
    """A value of a field or a constant. Raises KeyError, ValueError, SyntaxError or TypeError for what is none."""
    if kind.is_array:
        element = FieldType(kind.name)
        inner = text.strip().removeprefix("[").removesuffix("]").strip()
        if kind.name in _TEXTS:
            return list(ast.literal_eval(f"[{inner}]"))
        return [_value(element, item.strip()) for item in inner.split(",") if item.strip()]
    if kind.is_message:
        raise ValueError(text)
    if kind.name in _TEXTS:
        quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "\"'"
        return str(ast.literal_eval(text)) if quoted else text
    if kind.name == "boolean":
        return {"true": True, "1": True, "false": False, "0": False}[text.lower()] if text else False
    if kind.name in ("float", "double"):
        return float(text)
    number = int(text, 0)
    return bytes([number]) if kind.name == "octet" else number
