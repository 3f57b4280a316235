"""Values of a record: Python's own bools, numbers and strings, whatever library computed them."""

from __future__ import annotations

from enum import Enum

Value = float | bool | int | str

_PLAIN = (bool, int, float, str)


def plain(value: object) -> Value | None:
    """A bool, a number or a text; a scalar of numpy, or an array of one, as the value that it stands for; else None."""
    if isinstance(value, _PLAIN):
        return value
    item = getattr(value, "item", None)
    scalar = item() if callable(item) and getattr(value, "shape", None) == () else None
    return scalar if isinstance(scalar, _PLAIN) else None


def text_of(member: Enum) -> str:
    """How a member of an enumeration is recorded: by its value if this is a text, else by its name."""
    return member.value if isinstance(member.value, str) else member.name
