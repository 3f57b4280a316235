"""Finds the fields of messages that requirements can compare, from the declared types."""

from __future__ import annotations

import collections.abc
from collections.abc import Iterator
from enum import Enum
from typing import Literal, get_args, get_origin, get_type_hints

from pytest_hricdv.monitor.names import Kind
from pytest_hricdv.runtime import fields_of, text_of

_KINDS: tuple[Kind, ...] = (bool, float, str)

_COLLECTIONS = (
    bytes, bytearray, list, tuple, set, frozenset, dict, collections.deque, collections.abc.Sequence,
    collections.abc.Mapping, collections.abc.Set,
)  # fmt: skip
"""Types that a record stores as length and checksum (see `pytest_hricdv.runtime.message_fields`)."""


def comparable_fields(
    message: type[object], above: str = "", inside: tuple[type[object], ...] = ()
) -> Iterator[tuple[str, Kind, tuple[str, ...]]]:
    """The fields that requirements can compare: name, type, and all its texts where its type says so.

    A message in a message has its fields by paths, and a list its `length` and `crc`. What may be None is none of them.

    Args:
        message: the class.
        above: its path, with a dot at its end.
        inside: of which classes, so that one in itself comes to an end.
    """
    hints = get_type_hints(message)
    for name in fields_of(message) or ():
        hint, path = hints.get(name), above + name
        kind, texts = _field_type(hint)
        if kind is not None:
            yield path, kind, texts
        elif isinstance(hint, type) and fields_of(hint) is not None and hint not in inside:
            yield from comparable_fields(hint, f"{path}.", (*inside, message))
        elif (get_origin(hint) or hint) in _COLLECTIONS:
            yield f"{path}.length", float, ()
            yield f"{path}.crc", float, ()


def _field_type(hint: object) -> tuple[Kind | None, tuple[str, ...]]:
    """The type that requirements see of a field, None if they cannot compare it; all its texts, if its type says so."""
    if isinstance(hint, type) and issubclass(hint, Enum):
        return str, tuple(map(text_of, hint))
    if get_origin(hint) is Literal:
        values = tuple(text_of(value) if isinstance(value, Enum) else value for value in get_args(hint))
        types = {type(value) for value in values}
        hint = types.pop() if len(types) == 1 else None
        return (str, values) if hint is str else _field_type(hint)
    return float if hint is int else next((kind for kind in _KINDS if hint is kind), None), ()
