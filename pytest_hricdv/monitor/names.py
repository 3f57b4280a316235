"""Names in formulas: of signals, of fields as `topic.field`, and of a field's value in the message before."""

from __future__ import annotations

import re

Kind = type[bool] | type[float] | type[str]

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def last_of(field: str) -> str:
    """The name of the value that a field, `topic.field`, had in the message before the present one."""
    return f"last({field})"


def field_of(name: str) -> str:
    """`topic.field` of a field, or of its value in the message before; empty for a signal."""
    return name.removeprefix("last(").removesuffix(")") if "." in name else ""


def source_of(name: str) -> str:
    """The source whose updates change `name` (a signal, a field, or its value in the message before)."""
    topic, dot, _ = field_of(name).partition(".")
    return f"on({topic})" if dot else name


def is_optional(name: str, kind: Kind) -> bool:
    """Whether a missing value is no error: of the text of a message, and of a field in the message before."""
    return "." in name and (kind is str or name != field_of(name))
