"""Error messages about input: short and legible in a terminal, whatever the input contains.

Errors about input are an `InputError`, whose text is made `legible`. `visible` escapes control characters in any text
for a terminal; `quote` quotes input in a message; `nearest` gives the existing names nearest to a wrong one.
"""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Iterable, Sequence

MAX_MESSAGE = 900
"""Maximum length of a message, in characters: half a screen."""

MAX_QUOTED = 80
"""Maximum length of a quotation in a message, in characters: a line of a terminal."""

MAX_TEXT = 20_000
"""Maximum number of characters of a text from the code under test in a result: some hundred lines, with a traceback."""

MAX_LINE = 2_000
"""The same within a sentence, or of a value of a signal or message: half a browser window."""

_INVISIBLE = {"Cc", "Cf", "Cn", "Cs", "Zl", "Zp"}
"""Unicode categories of invisible characters, which are escaped. XML does not allow some of them."""
_GAP = " ... "

_CI_COMMAND = re.compile(r"^(\s*:)(?=:)|(##)(?=\w*\[)")
"""The start of a command in a CI service's log: GitHub (`::`, `##[`), Azure (`##vso[`), TeamCity."""


class InputError(Exception):
    """An input is wrong. The message says where, what was expected, what came, and what to do.

    Its text is legible, see `legible`: messages quote input.
    """

    def __str__(self) -> str:
        return legible(super().__str__())


def legible(text: str) -> str:
    """A message without invisible characters; of a long one the beginning, with the place, and the end, with advice."""
    if len(text) > MAX_MESSAGE:  # before characters are escaped, so that a text of megabytes costs nothing
        text = _shorten(text, MAX_MESSAGE)
    return _shorten(visible(text, keep="\n\t"), MAX_MESSAGE)


def cut(text: str, most: int = MAX_TEXT) -> str:
    """Somebody else's text, of a long one the beginning and the end, with how much is left out between them."""
    if len(text) <= most:
        return text
    end = most // 3
    gap = f" ... ({len(text) - most:,} of {len(text):,} characters are left out here) ... "
    return str.__getitem__(text, slice(most - end)) + gap + str.__getitem__(text, slice(len(text) - end, None))


def quote(value: object) -> str:
    """A value as Python writes it, shortened: `'set_param gaze = ... = 1'`."""
    if isinstance(value, str):
        return repr(_shorten(value, MAX_QUOTED))
    if isinstance(value, int) and value.bit_length() > 64:  # Python refuses to write numbers of thousands of digits
        return f"a number of about {value.bit_length() * 30103 // 100_000 + 1} digits"
    try:
        return _shorten(repr(value), MAX_QUOTED)
    except (RecursionError, ValueError):  # nested too deeply, or with such a number in it
        return f"a {type(value).__name__}"


EXCERPT_WIDTH = 2 * 80
"""Maximum number of characters of a source line in an error message: two lines of a terminal with 80 columns."""


def excerpt(line: str, column: int) -> tuple[str, int]:
    """The part of a line around a column (from 0), of at most `EXCERPT_WIDTH` characters, and the column in it.

    Invisible characters are question marks there, so that what stands below a character is in its column.
    """
    start = max(0, column - EXCERPT_WIDTH // 2) if column >= EXCERPT_WIDTH else 0
    shown = line[start : start + EXCERPT_WIDTH]
    return "".join(char if char == "\t" or char.isprintable() else "?" for char in shown), column - start


def visible(text: str, keep: str = "") -> str:
    """Text with control, format, surrogate and unassigned characters written as escapes.

    A test's name may hold any character; an escape sequence would recolour a terminal, and a text-direction mark would
    let a page show another name than the one that ran. `keep` lists characters to leave unchanged, such as `\\n`.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        char if char in keep or unicodedata.category(char) not in _INVISIBLE else _escape(char) for char in text
    )


def harmless_line(text: str) -> str:
    """A line for a terminal or the log of a CI service: visible, and no command to either.

    >>> harmless_line("  ::add-mask::a \x1b[31m")
    '  : :add-mask::a \\x1b[31m'
    """
    return _CI_COMMAND.sub(lambda begin: f"{begin[0]} ", visible(text))


def _shorten(text: str, most: int) -> str:
    if len(text) <= most:
        return text
    end = (most - len(_GAP)) // 3
    return text[: most - len(_GAP) - end] + _GAP + text[len(text) - end :]


def _escape(char: str) -> str:
    code = ord(char)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


SHOWN = 12
"""Number of known names listed where none is similar."""


def nearest(name: str, allowed: Iterable[str]) -> str:
    """The allowed names most similar to `name`, as the end of an error message; empty if there are none.

    >>> nearest("leg_redy", ["leg_ready", "request"])
    '; nearest: leg_ready'
    >>> nearest("x", ["leg_ready", "request"])
    '; known: leg_ready, request'
    """
    names = list(dict.fromkeys(allowed))
    similar = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    if similar:
        return "; nearest: " + ", ".join(similar)
    if not names:
        return ""
    return f"; known: {list_names(names, SHOWN)}"


def list_names(names: Sequence[str], most: int = 3) -> str:
    """The first names, and how many more there are.

    >>> list_names(["a", "b", "c", "d", "e"])
    'a, b, c and 2 more'
    """
    return ", ".join(names[:most]) + and_more(len(names) - most)


def and_more(count: int) -> str:
    """` and 2 more`; empty if there are none."""
    return f" and {count:,} more" if count > 0 else ""
