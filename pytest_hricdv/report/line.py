"""Lines of terminal text: measured in columns, cut to fit, with a style for the plugin to map onto markup.

The report's own words are ASCII, so that a terminal of any encoding shows them as they were measured.
"""

import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

Style = Literal["plain", "title", "ok", "bad", "warn", "dim"]

_INVISIBLE = {"Cc", "Cf", "Cs", "Zl", "Zp"}
_ZERO_WIDTH = {"Mn", "Me"}


@dataclass(frozen=True)
class Line:
    """A line of the summary: `text` without an end of line, and the name of its style."""

    text: str
    style: Style = "plain"


def visible(text: str, keep: str = "") -> str:
    """Text with control, format and surrogate characters written as escapes.

    A test's name may hold anything; a raw escape sequence would recolour a terminal, a text-direction mark would let a
    page show another name than the one that ran. `keep` lists characters to leave alone, such as the end of line.
    """
    return "".join(
        char if char in keep or unicodedata.category(char) not in _INVISIBLE else _escape(char) for char in text
    )


def width(text: str) -> int:
    """Columns that a text takes in a terminal: two for wide East Asian characters, none for combining marks."""
    return sum(_char_width(char) for char in text)


def fit(text: str, columns: int) -> str:
    """The text, or its beginning and `...`, in at most so many columns."""
    if width(text) <= columns:
        return text
    dots = "..."[: max(columns, 0)]
    room, kept = columns - len(dots), ""
    for char in text:
        room -= _char_width(char)
        if room < 0:
            break
        kept += char
    return kept.rstrip() + dots


def pad(text: str, columns: int) -> str:
    """The text cut or filled with blanks to exactly so many columns."""
    cut = fit(text, columns)
    return cut + " " * (columns - width(cut))


def listing(items: Sequence[str], columns: int) -> str:
    """Names separated by commas, as many as fit, and how many more there are."""
    for shown in range(len(items), 0, -1):
        text = ", ".join(items[:shown]) + more(len(items) - shown)
        if width(text) <= columns:
            return text
    return fit(f"{len(items)} of them", columns) if items else ""


def more(count: int) -> str:
    """`, and N more`, or nothing."""
    return f", and {count} more" if count else ""


def wrap(words: Iterable[str], columns: int) -> list[str]:
    """Words joined by blanks into lines of at most so many columns; a longer word is cut."""
    lines: list[str] = []
    for word in words:
        if lines and width(lines[-1]) + 1 + width(word) <= columns:
            lines[-1] += f" {word}"
        else:
            lines.append(fit(word, columns))
    return lines


def _escape(char: str) -> str:
    code = ord(char)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _char_width(char: str) -> int:
    if unicodedata.category(char) in _ZERO_WIDTH:
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1
