"""Belief subsets from a TOML file that a person with domain knowledge wrote.

    [[aim]]
    name = "one leg"                        # what these subsets are for
    beliefs = ["leg4", "*bored", "m11?l4"]  # a pattern stands for each belief that it matches
    concretizations = 5                     # tests made of each subset; 1 if left out

An entry stands for every combination of its beliefs and patterns (`*`, `?`, `[abc]`).
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path
from typing import Any

from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.suggestion import nearest

_KEYS = ("name", "beliefs", "concretizations")
_MAX_SUBSETS = 100_000


@dataclass(frozen=True)
class BeliefSets:
    """An entry of the file: the belief subsets it stands for, and how many tests are made of each."""

    name: str
    subsets: tuple[tuple[str, ...], ...]
    concretizations: int = 1


def read_belief_sets(path: Path, space: BeliefSpace) -> tuple[BeliefSets, ...]:
    """Read a file and expand its patterns.

    Raises:
        GenerateError: the file cannot be read or is no TOML; an unknown key or belief; a pattern without a match; a
            subset listed twice. With file, line and column.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise GenerateError(f"{path}: {error}; expected a TOML file of belief subsets") from error
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        where = f"{path}:{place[1]}:{place[2]}" if place else f"{path}:{len(text.splitlines())}:1"
        raise GenerateError(f"{where}: {str(error).partition(' (at')[0]}") from None
    return tuple(_Reader(path, text, space).read(data))


class _Reader:
    """Reads the entries of one file; has its text, to report where an error is."""

    def __init__(self, path: Path, text: str, space: BeliefSpace) -> None:
        self.path = path
        self.lines = text.splitlines()
        self.space = space
        self.seen: dict[tuple[str, ...], int] = {}

    def read(self, data: dict[str, Any]) -> Iterator[BeliefSets]:
        entries = data.get("aim")
        for key in data:
            if key != "aim":
                raise GenerateError(f"{self._where(None, key)}: unknown key {key!r}; expected [[aim]] entries only")
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise GenerateError(f"{self.path}:1:1: no [[aim]] entries; expected at least one")
        for number, entry in enumerate(entries):
            yield self._entry(number, entry)

    def _entry(self, number: int, entry: dict[str, Any]) -> BeliefSets:
        for key in entry:
            if key not in _KEYS:
                raise GenerateError(f"{self._where(number, key)}: unknown key {key!r}{nearest(key, _KEYS)}")
        name, count, items = entry.get("name", ""), entry.get("concretizations", 1), entry.get("beliefs")
        if not isinstance(name, str) or name != " ".join(name.split()):
            raise GenerateError(f"{self._where(number, 'name')}: name {name!r}; expected one line of text")
        if type(count) is not int or count < 1:
            where = self._where(number, "concretizations")
            raise GenerateError(f"{where}: concretizations = {count!r}; expected a whole number, at least 1")
        if not isinstance(items, list) or not all(isinstance(item, str) for item in items):
            raise GenerateError(f"{self._where(number, 'beliefs')}: beliefs = {items!r}; expected a list of strings")
        return BeliefSets(name, tuple(self._subsets(number, items)), count)

    def _subsets(self, number: int, items: Sequence[str]) -> Iterator[tuple[str, ...]]:
        choices = [self._matches(number, item) for item in items]
        if (count := math.prod(map(len, choices))) > _MAX_SUBSETS:
            where = self._where(number, "beliefs")
            raise GenerateError(f"{where}: {count} subsets in one entry; expected at most {_MAX_SUBSETS}")
        for combination in product(*choices):
            try:
                subset = self.space.subset(combination)
            except GenerateError as error:
                raise GenerateError(f"{self._where(number, 'beliefs')}: {error}") from None
            first = self.seen.setdefault(subset, number)
            if first != number:
                raise GenerateError(
                    f"{self._where(number, 'beliefs')}: subset {' '.join(subset)} is in the entry at "
                    f"{self._where(first, 'beliefs')} already; expected it once (with concretizations = 2, say)"
                )
            yield subset

    def _matches(self, number: int, item: str) -> list[str]:
        matches = [belief for belief in self.space.beliefs if fnmatchcase(belief, item)]
        if not matches:
            what = "pattern matches no belief" if set(item) & set("*?[") else "unknown belief"
            where = self._where(number, item)
            raise GenerateError(f"{where}: {what}: {item!r}{nearest(item, self.space.beliefs)}")
        return matches

    def _where(self, number: int | None, token: str) -> str:
        """`file:line:column` of a key or a string, searched in the entry of that number or in the whole file."""
        starts = [place for place, line in enumerate(self.lines) if re.match(r"\s*\[\[\s*aim\s*\]\]", line)]
        first = starts[number] if number is not None and number < len(starts) else 0
        last = starts[number + 1] if number is not None and number + 1 < len(starts) else len(self.lines)
        word = re.escape(token)
        spelling = re.compile(rf"""["'](?P<string>{word})["']|^\s*\[*\s*(?P<key>{word})(?=\s*[=\]])""")
        for place in range(first, last):
            if match := spelling.search(self.lines[place].partition(" #")[0]):
                return f"{self.path}:{place + 1}:{match.start(match.lastgroup or 0) + 1}"
        return f"{self.path}:{first + 1}:1"
