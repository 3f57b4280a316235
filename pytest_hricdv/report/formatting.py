"""Text for people: figures, names in natural order, and each terminal `Line`, measured in columns.

All views of a report, and those of features, use these functions. The views' own words are ASCII, so that they have
the same width in a terminal of any encoding.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

from pytest_hricdv._base.message import and_more, visible
from pytest_hricdv.declarations.model_oracle import MODEL

Item = TypeVar("Item")
Style = Literal["plain", "title", "ok", "bad", "warn", "dim"]

LABEL_COLUMNS = 20
"""Columns of the label that starts a terminal line; chosen: the names of most suites and agents fit."""

_MAX_LINES = 3
"""Most terminal lines of one sentence in the summary; longer ones are cut (chosen: the report has the rest)."""

_ZERO_WIDTH = {"Mn", "Me"}


@dataclass(frozen=True)
class Line:
    """A line of the terminal summary: `text` without an end of line, and the name of its style."""

    text: str
    style: Style = "plain"


def percent(value: float | None) -> str:
    """`80.5 %`, or `-` for none; never `100.0 %` of what is incomplete, nor `0.0 %` of what is above zero."""
    if value is None:
        return "-"
    shown = min(max(round(value, 1), 0.1 if value > 0 else 0.0), 99.9 if value < 100 else 100.0)
    return f"{shown:.1f} %"


def share(part: int, whole: int) -> float | None:
    """Per cent of a whole; None if the whole is zero."""
    return 100.0 * part / whole if whole else None


def seconds(value: float | None) -> str:
    """`0.52 s`, `71.2 s`, `17553 s`, or `-` for none."""
    if value is None:
        return "-"
    digits = 2 if abs(value) < 10 else 1 if abs(value) < 1000 else 0
    return f"{value:.{digits}f} s"


def speedup(factor: float) -> str:
    """`331 times`, `0.52 times`: how many times real time."""
    return f"{factor:.0f} times" if factor >= 10 else f"{factor:.2g} times"


def quantity(value: object) -> str:
    """A float with four significant digits; any other value as it is."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def plural(count: int, noun: str) -> str:
    """`1 test`, `2 tests`, `2 branches`."""
    ending = "" if count == 1 else "es" if noun.endswith("ch") else "s"
    return f"{count} {noun}{ending}"


def enumerate_names(names: Sequence[str]) -> str:
    """`nurse`, `nurse and child`, `nurse, porter and child`."""
    return " and ".join([*filter(None, [", ".join(names[:-1])]), *names[-1:]])


def line_ranges(lines: Iterable[int]) -> tuple[str, ...]:
    """Line numbers as ranges: 60, 61, 62, 70 become `60-62`, `70`."""
    spans: list[list[int]] = []
    for line in sorted(set(lines)):
        if spans and line == spans[-1][1] + 1:
            spans[-1][1] = line
        else:
            spans.append([line, line])
    return tuple(str(first) if first == last else f"{first}-{last}" for first, last in spans)


def branches(arcs: Iterable[Sequence[int]]) -> tuple[str, ...]:
    """Branches as `58->60`; a negative line is the exit (or entry) of a function, as coverage.py counts."""
    return tuple(f"{_end(start)}->{_end(end)}" for start, end in sorted((arc[0], arc[1]) for arc in arcs))


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """A sort key that puts R2 before R10."""
    parts = re.split(r"(\d+)", name)
    return tuple((1, int(part), part) if part.isdecimal() else (0, 0, part) for part in parts)


def by_requirement(name: str) -> tuple[bool, tuple[tuple[int, int, str], ...]]:
    """A sort key for requirements: R2 before R10, and the model after all of them."""
    return name == MODEL, natural(name)


def utc(began: str) -> str:
    """The time of a report, `2026-01-31T12:00:00+00:00`, as `2026-01-31 12:00:00 UTC`."""
    return began.replace("T", " ").replace("+00:00", " UTC")


def capitalize(text: str) -> str:
    """The text with a capital first letter, and all others as they are."""
    return text[:1].upper() + text[1:]


def width(text: str) -> int:
    """Columns that a text takes in a terminal: two for wide East Asian characters, none for combining marks."""
    return sum(_char_width(char) for char in text)


def fit(text: str, columns: int) -> str:
    """The text, or its beginning and `...`, within a number of columns."""
    if width(text) <= columns:
        return text
    dots = "..."[: max(columns, 0)]
    return _cut_end(text, columns - len(dots)).rstrip() + dots


def fit_list(texts: Iterable[str], columns: int) -> str:
    """The first of the texts that fits into the columns without `...`; the texts are ordered from full to short.

    Where not even the last fits, as much of it as there is room for.
    """
    text = ""
    for text in texts:
        if width(text) <= columns:
            return text
    return _cut_end(text, columns)


def fit_path(path: str, columns: int) -> str:
    """The path, or `...` and its end, within a number of columns, since the end distinguishes files."""
    if width(path) <= columns:
        return path
    dots = "..."[: max(columns, 0)]
    room, kept = columns - len(dots), ""
    for char in reversed(path):
        room -= _char_width(char)
        if room < 0:
            break
        kept = char + kept
    return dots + kept


def pad(text: str, columns: int) -> str:
    """The text cut or padded with blanks to exactly this many columns."""
    cut = fit(text, columns)
    return cut + " " * (columns - width(cut))


def listing(items: Sequence[str], columns: int, more: int = 0) -> str:
    """Names separated by commas, as many as fit, and how many are left out, with `more` that are not in `items`."""
    for shown in range(len(items), 0, -1):
        text = ", ".join(items[:shown]) + and_more(len(items) - shown + more)
        if width(text) <= columns:
            return text
    return fit(f"{len(items) + more} of them", columns) if items else ""


def split_first(items: Sequence[Item], most: int) -> tuple[Sequence[Item], int]:
    """The first of the items, and how many more there are."""
    return items[:most], max(0, len(items) - most)


def wrap(words: Iterable[str], columns: int) -> list[str]:
    """Words joined by blanks into lines of limited width; a longer word is cut."""
    lines: list[str] = []
    for word in words:
        if lines and width(lines[-1]) + 1 + width(word) <= columns:
            lines[-1] += f" {word}"
        else:
            lines.append(fit(word, columns))
    return lines


def wrap_line(text: str, columns: int) -> list[str]:
    """The text in lines of limited width, from the second on indented by two more; a long text is cut."""
    if width(text) <= columns:
        return [text]
    words = text.lstrip(" ")
    indent = " " * min(len(text) - len(words), columns // 2)
    room = columns - len(indent) - 2
    lines = wrap(words.split(" "), room)
    if len(lines) > _MAX_LINES:
        lines = [*lines[: _MAX_LINES - 1], fit(" ".join(lines[_MAX_LINES - 1 :]), room)]
    return [indent + lines[0], *(f"{indent}  {line}" for line in lines[1:])]


def label_lines(label: str, text: str, columns: int, style: Style = "plain") -> Iterator[Line]:
    """A label with a text next to it, which continues below itself if it is too long.

    A label that is too long is above the text and not cut, since labels distinguish lines.
    """
    shown = visible(label)
    if width(shown) > LABEL_COLUMNS:
        yield Line(f"  {shown}", style)
        shown = ""
    start = f"  {pad(shown, LABEL_COLUMNS)}  "
    for line in wrap(visible(text).split(" "), columns - width(start)):
        yield Line(start + line, style)
        start = " " * width(start)


def count_notes(notes: Iterable[str], columns: int) -> Iterator[Line]:
    """Notes on tests below a line, each once, with the number of tests that have it; empty ones are left out."""
    for note, count in Counter(filter(None, notes)).items():
        for line in wrap(visible(f"{count} {note}").split(" "), columns - 2):
            yield Line(f"  {line}", "warn")


def _end(line: int) -> str:
    return "exit" if line < 0 else str(line)


def _cut_end(text: str, columns: int) -> str:
    room = columns
    for length, char in enumerate(text):
        room -= _char_width(char)
        if room < 0:
            return text[:length]
    return text


def _char_width(char: str) -> int:
    if unicodedata.category(char) in _ZERO_WIDTH:
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1
