"""The texts of source files, and the places of names in them."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.parser import read_text

_HIDDEN = re.compile(r"//[^\n]*|/\*[\s\S]*?\*/|\"[^\"\\]*(?:\\.[^\"\\]*)*\"")


@lru_cache(maxsize=64)
def text_of(file: str) -> str:
    """The text of a source file; empty if there is no such file."""
    path = Path(file)
    return read_text(path) if path.is_file() else ""


@lru_cache(maxsize=64)
def _code_of(file: str) -> str:
    """The text with comments and strings replaced by spaces, so that places stay the same."""
    return _HIDDEN.sub(lambda hidden: re.sub(r"[^\n]", " ", hidden[0]), text_of(file))


@lru_cache(maxsize=64)
def _line_starts(file: str) -> tuple[int, ...]:
    text = text_of(file)
    return (0, *(found.end() for found in re.finditer("\n", text)))


def location_of(name: str, start: Location, skip: str = "") -> Location:
    """The place of a name after ``start`` and after the name ``skip``; ``start`` if it does not occur."""
    code, starts = _code_of(start.file), _line_starts(start.file)
    if start.line > len(starts):
        return start
    offset = starts[start.line - 1] + start.column - 1
    if skip:
        skipped = _word(skip).search(code, offset)
        offset = skipped.end() if skipped else offset
    found = _word(name).search(code, offset)
    return start if found is None else _location(start.file, found.start())


def _location(file: str, offset: int) -> Location:
    before = text_of(file)[:offset]
    return Location(file, before.count("\n") + 1, offset - (before.rfind("\n") + 1) + 1)


@lru_cache(maxsize=1024)
def _word(name: str) -> re.Pattern[str]:
    return re.compile(rf"(?<![\w.]){re.escape(name)}(?!\w)")


def clear_cache() -> None:
    """Forget the texts, so that changed files are read again."""
    for cached in (text_of, _code_of, _line_starts):
        cached.cache_clear()
