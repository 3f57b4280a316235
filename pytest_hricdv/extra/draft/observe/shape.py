"""The shape of observed values: their kinds, ranges, strings, fields and keys, merged over all observations."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from pytest_hricdv._base.input_file import check_keys

MAX_TEXTS, MAX_LENGTH = 16, 60
"""Most texts that are kept of a value, and their length (characters): more or longer ones are no fixed set."""

MAX_FIELDS, MAX_DEPTH = 40, 4
"""Most keys of a dict or fields of an object that are kept, and how deep they are nested."""

_SECRET = re.compile(
    r"pass(word|wd)?|secret|token|(api|access)[_-]?key|authorization|bearer|cookie|credential|private", re.IGNORECASE
)

MASK = "***"
"""Replaces a text whose name says that it is a secret."""


def is_secret(name: str) -> bool:
    """Whether a value of this name is masked."""
    return _SECRET.search(name) is not None


@dataclass
class Shape:
    """All values that were observed at one place.

    Args:
        count: number of the values.
        kinds: kind of value -> how often: "bool", "int", "float", "text", "none", "object", "dict", "json", "bytes",
            "list", "enum", "callable".
        texts: text or member of an enumeration -> how often, up to `MAX_TEXTS`.
        low: the least number. high: the greatest one.
        classes: class of objects and enumerations, as "module:Class" -> how often.
        fields: the fields of objects and dicts, by name.
        is_open: whether there were more texts than are kept.
    """

    count: int = 0
    kinds: dict[str, int] = field(default_factory=dict)
    texts: dict[str, int] = field(default_factory=dict)
    low: float | None = None
    high: float | None = None
    classes: dict[str, int] = field(default_factory=dict)
    fields: dict[str, Shape] = field(default_factory=dict)
    is_open: bool = False

    def add(self, value: Any, name: str = "", depth: int = 0) -> None:
        """Count a value; `name` is that of its field or parameter."""
        self.count += 1
        if value is None or isinstance(value, bool):
            self._note("none" if value is None else "bool")
        elif isinstance(value, Enum):
            self._note("enum")
            self._class_of(value)
            self._text(value.value if isinstance(value.value, str) else value.name)
        elif isinstance(value, int | float):
            self._number(value)
        elif isinstance(value, str | bytes):
            self._content(value, name, depth)
        elif isinstance(value, Mapping):
            self._note("dict")
            self._members({key: part for key, part in list(value.items())[:MAX_FIELDS] if isinstance(key, str)}, depth)
        elif isinstance(value, list | tuple | set | frozenset) and not hasattr(value, "_fields"):
            self._note("list")
        elif callable(value) and hasattr(value, "__qualname__"):
            self._note("callable")
            self._count(self.classes, f"{getattr(value, '__module__', '')}:{value.__qualname__}")
        else:
            self._note("object")
            self._class_of(value)
            self._members(_fields_of(value), depth)

    def _note(self, kind: str) -> None:
        self.kinds[kind] = self.kinds.get(kind, 0) + 1

    def _count(self, table: dict[str, int], key: str) -> None:
        if key in table or len(table) < MAX_TEXTS:
            table[key] = table.get(key, 0) + 1
        else:
            self.is_open = True

    def _class_of(self, value: Any) -> None:
        self._count(self.classes, f"{type(value).__module__}:{type(value).__qualname__}")

    def _number(self, value: float) -> None:
        self._note("int" if isinstance(value, int) else "float")
        if abs(value) <= sys.float_info.max:  # not of NaN, nor of an integer that no float can have
            self.low = value if self.low is None else min(self.low, value)
            self.high = value if self.high is None else max(self.high, value)

    def _text(self, text: str) -> None:
        if len(text) > MAX_LENGTH or not text.isprintable():
            self.is_open = True
        else:
            self._count(self.texts, text)

    def _content(self, value: str | bytes, name: str, depth: int) -> None:
        """A text, or the object of JSON in it."""
        if value[:1] in ("{", b"{") and len(value) < 10_000 and depth < MAX_DEPTH:
            try:
                content = json.loads(value)
            except (ValueError, RecursionError):
                content = None
            if isinstance(content, dict):
                self._note("json" if isinstance(value, str) else "bytes")
                self._members(content, depth)
                return
        self._note("text" if isinstance(value, str) else "bytes")
        if isinstance(value, str):
            self._text(MASK if is_secret(name) else value)

    def _members(self, members: Mapping[str, Any], depth: int) -> None:
        for name, part in list(members.items())[:MAX_FIELDS] if depth < MAX_DEPTH else ():
            self.fields.setdefault(name, Shape()).add(part, name, depth + 1)

    def merge(self, other: Shape) -> None:
        """Add all values of another one."""
        self.count += other.count
        for mine, theirs in ((self.kinds, other.kinds), (self.texts, other.texts), (self.classes, other.classes)):
            for key, count in theirs.items():
                mine[key] = mine.get(key, 0) + count
        lows = [low for low in (self.low, other.low) if low is not None]
        highs = [high for high in (self.high, other.high) if high is not None]
        self.low, self.high = min(lows, default=None), max(highs, default=None)
        for name, part in other.fields.items():
            self.fields.setdefault(name, Shape()).merge(part)
        self.is_open |= other.is_open

    def to_json(self) -> dict[str, Any]:
        """The shape as plain data, without empty parts."""
        plain: dict[str, Any] = {"count": self.count, "kinds": self.kinds}
        plain |= {name: value for name, value in (("texts", self.texts), ("classes", self.classes)) if value}
        plain |= {"low": self.low, "high": self.high} if self.low is not None else {}
        plain |= {"fields": {name: part.to_json() for name, part in self.fields.items()}} if self.fields else {}
        return plain | ({"is_open": True} if self.is_open else {})

    @staticmethod
    def from_json(plain: Any, depth: int = 0) -> Shape:
        """Read plain data. Raises ValueError, TypeError or KeyError where it is none of `to_json`."""
        if not isinstance(plain, dict) or depth > MAX_DEPTH + 2:
            raise ValueError("expected the shape of a value")
        check_keys(plain, ("count", "kinds", "texts", "classes", "low", "high", "fields", "is_open"))
        made = Shape(int(plain["count"]), _counts(plain.get("kinds", {})), _counts(plain.get("texts", {})),
                     _number_of(plain.get("low")), _number_of(plain.get("high")), _counts(plain.get("classes", {})),
                     is_open=bool(plain.get("is_open")))  # fmt: skip
        made.fields = {str(name): Shape.from_json(part, depth + 1) for name, part in plain.get("fields", {}).items()}
        return made


def _counts(table: Any) -> dict[str, int]:
    return {str(key): int(count) for key, count in dict(table).items()}


def _number_of(value: Any) -> float | None:
    return None if value is None else float(value)


def _fields_of(value: Any) -> Mapping[str, Any]:
    """The fields of a dataclass, named tuple, or object of attrs, msgspec or pydantic; none of other objects."""
    kind = type(value)
    names: Any = getattr(kind, "__dataclass_fields__", None) or getattr(kind, "_fields", None)
    names = names or [attribute.name for attribute in getattr(kind, "__attrs_attrs__", ())]
    names = names or getattr(kind, "__struct_fields__", None) or getattr(kind, "__pydantic_fields__", None) or ()
    fields = {}
    for name in list(names):
        try:
            fields[str(name)] = getattr(value, name)
        except Exception:  # an attribute that raises has no value
            continue
    return fields
