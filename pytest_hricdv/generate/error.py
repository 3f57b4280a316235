"""What goes wrong while tests are generated, said so that it can be put right."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class GenerateError(Exception):
    """A model, a belief space, a file of tests or a parameter that tests cannot be generated from.

    The message says what was expected, what came and, where there is one, the place as `file:line:column`.
    """


def nearest(name: str, known: Iterable[str]) -> str:
    """The known names most like `name`, as the end of an error message; empty if nothing is known."""
    names = list(dict.fromkeys(known))
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    if close:
        return "; nearest: " + ", ".join(close)
    if not names:
        return ""
    shown = ", ".join(names[:12])
    return f"; known: {shown}" + (f" and {len(names) - 12} more" if len(names) > 12 else "")
