"""Bounds: how much of something a suite has to cover."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("statements", "branches", "plans", "assertions", "cross")


class BoundError(ValueError):
    """A bound is malformed; the text says what was expected."""


@dataclass(frozen=True)
class Bound:
    """A lower bound of coverage, in percent; `named` on the command line, where it applies to any selection."""

    kind: str
    percent: float
    named: bool = True


def bound(text: str, *, named: bool = True) -> Bound:
    """The bound that `KIND=PCT` says. Raises BoundError for another form, kind or percentage."""
    kind, equals, percentage = text.partition("=")
    kind = kind.strip()
    if not equals or kind not in KINDS:
        raise BoundError(f"{text}: expected KIND=PCT with KIND in {', '.join(KINDS)}")
    try:
        percent = float(percentage)
    except ValueError:
        raise BoundError(f"{text}: expected a percentage, got {percentage!r}") from None
    if not 0 <= percent <= 100:
        raise BoundError(f"{text}: expected a percentage from 0 to 100")
    return Bound(kind, percent, named)
