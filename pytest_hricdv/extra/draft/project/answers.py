"""Keeps what people edited in the files of a draft, to answer its questions, when it is drafted again (`merge`)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from difflib import SequenceMatcher
from pathlib import Path

RECORD = ".hricdv-draft.json"
"""The file with the texts of a draft as they were drafted."""

Answers = Mapping[str, tuple[str, str]]
"""Name of a file -> its text as it was drafted, and as it is now."""

_LOCATION = re.compile(r"[\w./-]+\.py:\d+")
"""A location in the code, which moves with other lines."""


def read_answers(folder: Path) -> Answers:
    """The files of the last draft in a folder; none if there is no draft, or one of which no record is left."""
    try:
        drafted = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return {name: (text, (folder / name).read_text(encoding="utf-8")) for name, text in drafted.items()
                if (folder / name).is_file()}  # fmt: skip
    except (OSError, ValueError, AttributeError):
        return {}


def record_text(texts: Mapping[str, str]) -> str:
    """The content of the record."""
    return json.dumps(texts, ensure_ascii=False, indent=1) + "\n"


def find_edits(answers: Answers) -> tuple[str, ...]:
    """The files that somebody has changed."""
    return tuple(name for name, (drafted, now) in answers.items() if drafted != now)


def merge(drafted: str, now: str, new: str) -> str:
    """A new text, with what somebody has changed in the last one; where both changed a line, that of the person.

    >>> merge("low = 1\\nhigh = 2\\n", "low = 1\\nhigh = 5\\n", "low = 0\\nhigh = 2\\nmore = 3\\n")
    'low = 0\\nhigh = 5\\nmore = 3\\n'
    """
    old, own, others = (text.splitlines(keepends=True) for text in (drafted, now, new))
    kept, there = list(_changes(old, own)), _places(old, others)
    changes = kept + [change for change in _changes(old, others) if not any(_overlap(change, other) for other in kept)]
    merged: list[str] = []
    line = 0
    for begin, end, lines in sorted(changes, key=lambda change: change[:2]):
        merged += [*_shift(old, others, there, line, begin), *lines]
        line = end
    return "".join((*merged, *_shift(old, others, there, line, len(old))))


_Change = tuple[int, int, list[str]]
"""First and last line, and what is in their place."""


def _matcher(old: list[str], lines: list[str]) -> SequenceMatcher[str]:
    before, after = ([_LOCATION.sub("", line) for line in text] for text in (old, lines))
    return SequenceMatcher(None, before, after, autojunk=False)


def _changes(old: list[str], lines: list[str]) -> Iterator[_Change]:
    for kind, begin, end, first, last in _matcher(old, lines).get_opcodes():
        if kind != "equal":
            yield begin, end, lines[first:last]


def _places(old: list[str], lines: list[str]) -> dict[int, int]:
    """Number of a line -> that of the same one in another text."""
    blocks = _matcher(old, lines).get_matching_blocks()
    return {a + step: b + step for a, b, size in blocks for step in range(size)}


def _overlap(one: _Change, other: _Change) -> bool:
    return max(one[0], other[0]) < min(one[1], other[1]) or (one[0] == one[1] and other[0] < one[0] < other[1])


def _shift(old: list[str], others: list[str], there: Mapping[int, int], begin: int, end: int) -> Iterator[str]:
    """Unchanged lines, with their present locations."""
    return (others[there[line]] if line in there else old[line] for line in range(begin, end))
