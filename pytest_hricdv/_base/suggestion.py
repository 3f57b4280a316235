"""Suggests existing names for unknown ones, as the end of an error message."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

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
    shown = ", ".join(names[:SHOWN])
    return f"; known: {shown}" + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
