"""What code tells a port: the topic, and the names and values in what it hands over."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.stand_ins.neutral import Neutral
from pytest_hricdv.runtime import text_of


@dataclass
class ToldContent:
    """The content of a call.

    Args:
        topic: the text before a dict, JSON or tuple; empty if there is none.
        named: values by the names that they have in it.
        others: all other values, in their order.
    """

    topic: str = ""
    named: dict[str, Any] = field(default_factory=dict)
    others: list[Any] = field(default_factory=list)

    @property
    def arguments(self) -> dict[str, Any]:
        """All values; positional ones are named by their numbers."""
        return {**{str(number): value for number, value in enumerate(self.others)}, **self.named}

    def message(self, kind: type[Any]) -> Any:
        """The content as a message of a class, whose fields without a value are neutral."""
        left = list(self.others)
        values = {}
        for part in fields(kind):
            has_value = part.name in self.named or bool(left)
            value = self.named[part.name] if part.name in self.named else left.pop(0) if left else None
            values[part.name] = _as(part.type, value) if has_value else _as(part.type, None)
        return kind(**values)


def read_content(arguments: Sequence[Any], named: Mapping[str, Any], is_broker: bool = False) -> ToldContent:
    """The content of a call; a broker is called with a topic first.

    >>> read_content(("ward/state", '{"state": "up", "height_cm": 60}'), {"qos": 1})
    ToldContent(topic='ward/state', named={'state': 'up', 'height_cm': 60}, others=[])
    >>> read_content(("mouth", 1), {})
    ToldContent(topic='', named={}, others=['mouth', 1])
    """
    told = ToldContent(named={word(name): value for name, value in named.items() if _is_plain(value)})
    every = list(arguments)
    if len(every) == 1 and type(every[0]) is tuple:
        every, is_topic = list(every[0]), True
    else:
        is_topic = len(every) > 1 and isinstance(every[0], str) and ("/" in every[0] or _members(every[1]) is not None)
    for number, value in enumerate(every):
        members = _members(value)
        if (is_topic or is_broker) and number == 0 and isinstance(value, str):
            told.topic = value
            told.named = {} if is_topic else told.named  # of a topic and a message: how it is published
        elif members is not None:
            told.named |= {word(name): part for name, part in members.items() if _is_plain(part)}
        elif _is_plain(value):
            told.others.append(value)
    return told


def _members(value: Any) -> Mapping[str, Any] | None:
    """The members of a dict, of JSON of one, or of a message; None of anything else."""
    if isinstance(value, bytes | bytearray | str) and value[:1] in ("{", b"{"):
        try:
            value = json.loads(value)
        except (ValueError, RecursionError):
            return None
    if isinstance(value, Mapping):
        return {str(name): part for name, part in value.items()}
    names = getattr(type(value), "__dataclass_fields__", None) or getattr(type(value), "_fields", None)
    return {name: getattr(value, name, None) for name in names} if names else None


def _is_plain(value: Any) -> bool:
    return value is None or (isinstance(value, bool | int | float | str | bytes | Enum)
                             and not isinstance(value, Neutral))  # fmt: skip


def _as(kind: Any, value: Any) -> Any:
    """A value as a field of this type has it."""
    if kind in (bool, "bool"):
        return bool(value)
    if kind in (float, "float", int, "int"):
        return float(value) if isinstance(value, int | float) else 0.0
    value = text_of(value) if isinstance(value, Enum) else value
    value = bytes(value).decode("utf-8", "replace") if isinstance(value, bytes | bytearray) else value
    return value.strip() if isinstance(value, str) else "" if value is None else str(value)
