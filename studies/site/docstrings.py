"""Sections of docstrings (`Args:`, `Returns:`, `Raises:`, `Attributes:`) to field lists of reStructuredText.

Sphinx's own extension for this, napoleon, takes the words before the first colon of what is returned, and of what is
said of an attribute, for a type. Here types are in the signatures, and such sentences are sentences.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import takewhile

_FIELDS = {"Args": "param", "Attributes": "ivar", "Raises": "raises"}
"""Sections of entries `name: text`, with the field that each entry becomes."""

_SECTION = re.compile(rf"(?P<name>{'|'.join(_FIELDS)}|Returns):\Z")
_ENTRY = re.compile(r"(?P<names>[\w*.]+(?:, [\w*.]+)*): ?(?P<text>.*)")
_INDENT = " " * 4


def field_lists(lines: Sequence[str]) -> list[str]:
    """The lines of a docstring, without its own indentation, with its sections as field lists."""
    return list(_replaced(lines))


def _replaced(lines: Sequence[str]) -> Iterator[str]:
    number = 0
    while number < len(lines):
        section = _SECTION.match(lines[number])
        number += 1
        if section is None:
            yield lines[number - 1]
            continue
        body = [*takewhile(lambda line: not line.strip() or line.startswith(_INDENT), lines[number:])]
        number += len(body)
        yield ""
        yield from _fields(section["name"], [line.removeprefix(_INDENT) for line in body])
        yield ""


def _fields(section: str, body: Sequence[str]) -> Iterator[str]:
    """The fields of a section; lines that go on are indented below their entry."""
    if section == "Returns":
        first, *rest = body
        yield f":returns: {first}"
        yield from (f"{_INDENT}{line}" if line.strip() else line for line in rest)
        return
    for line in body:
        entry = _ENTRY.match(line)
        if entry is None:
            yield line  # goes on, and is indented already; or is blank
            continue
        *names, last = entry["names"].split(", ")
        # Sphinx has one field per name: those of a group are shown with the last one's text.
        yield from (f":{_FIELDS[section]} {name}: as `{last}`" for name in names)
        yield f":{_FIELDS[section]} {last}: {entry['text']}"
