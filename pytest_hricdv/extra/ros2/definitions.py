"""Definitions of messages in the language of .msg files, with those that they contain; made of the generated classes.

As the MCAP registry's "ros2msg" wants them: each further type after a line of "=" and its name.
"""

from __future__ import annotations

import re
from typing import Any

from pytest_hricdv.extra.ros2.cdr import class_of
from pytest_hricdv.extra.ros2.messages import type_name

_SEPARATOR = "=" * 80
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(?:, (?P<most>\d+))?>")
_BOUNDED_TEXT = re.compile(r"(w?string)<(\d+)>")
_NAMES = {"boolean": "bool", "double": "float64", "float": "float32", "octet": "byte"}


def definition_of(kind: Any) -> str:
    """The definition of a class of messages."""
    definitions: dict[str, str] = {}
    _add(kind, definitions)
    first, *others = definitions.items()
    return "\n".join([first[1], *(f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in others)])


def _add(kind: Any, definitions: dict[str, str]) -> None:
    package, _, name = type_name(kind).split("/")
    if f"{package}/{name}" in definitions:
        return
    fields = kind.get_fields_and_field_types()
    definitions[f"{package}/{name}"] = "\n".join(f"{_written(type_)} {field}" for field, type_ in fields.items())
    for type_ in kind.SLOT_TYPES:
        of = getattr(type_, "value_type", type_)
        if hasattr(of, "namespaces"):
            _add(class_of(of), definitions)


def _written(type_: str) -> str:
    """A type as .msg files write it: `sequence<double, 3>` is `float64[<=3]`."""
    sequence = _SEQUENCE.fullmatch(type_)
    if sequence:
        return f"{_written(sequence['of'])}[{'<=' + sequence['most'] if sequence['most'] else ''}]"
    base, bracket, size = type_.partition("[")
    return _NAMES.get(base, _BOUNDED_TEXT.sub(r"\1<=\2", base)) + bracket + size
