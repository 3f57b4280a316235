"""Examples on pages, which tests run and studies measure: blocks that are files, or changes of files.

A block with a name after its language is a file: ```` ```toml pytest.ini ````. A block of the language `diff` with a
name changes the file of this name: lines begin with ` `, `-` or `+`, and `@@` separates changes at several places.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

_BLOCK = re.compile(r"^```(?P<kind>\w+)(?: (?P<name>\S+))?\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
CHANGE = "diff"
"""The language of blocks that change a file."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page: its language, its text, and the name of the file that it is, or an empty name."""

    kind: str
    name: str
    text: str


def blocks_of(page: Path) -> list[Block]:
    """The blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [Block(found["kind"], found["name"] or "", found["text"]) for found in _BLOCK.finditer(text)]


def write_files(found: Iterable[Block], folder: Path) -> list[str]:
    """Write the blocks that are files, and change files, in this order; returns their names, each once."""
    names: dict[str, None] = {}
    for block in found:
        if block.name:
            path = folder / block.name
            path.parent.mkdir(parents=True, exist_ok=True)
            text = changed(path.read_text(encoding="utf-8"), block.text) if block.kind == CHANGE else block.text
            path.write_text(text, encoding="utf-8")
            names[block.name] = None
    return list(names)


def changed(text: str, change: str) -> str:
    """A text with a change applied.

    Raises:
        ValueError: what it removes or keeps is not there, or several times.

    >>> changed("a = 1\\nb = 2\\n", "-a = 1\\n+a = 3\\n")
    'a = 3\\nb = 2\\n'
    """
    for hunk in re.split(r"^@@.*\n", change, flags=re.MULTILINE):
        lines = [(line[:1].strip(), line[1:] or line) for line in hunk.splitlines(keepends=True)]
        before = "".join(line for sign, line in lines if sign != "+")
        if text.count(before) != 1:
            raise ValueError(f"expected once, found {text.count(before)} times:\n{before}")
        text = text.replace(before, "".join(line for sign, line in lines if sign != "-"))
    return text
