"""Names that are probably misspelled."""

from __future__ import annotations

from collections.abc import Iterable

SHORTEST = 3
"""Minimum length of a name: shorter ones differ by one letter too often."""


def one_letter_away(name: str, known: Iterable[str]) -> str | None:
    """A known name that differs by one letter: inserted, deleted, replaced, or swapped with the next one."""
    return next((other for other in sorted(set(known)) if differs_by_one_letter(name, other)), None)


def differs_by_one_letter(name: str, other: str) -> bool:
    """Whether two names differ by one typing error; numbered names such as leg1 and leg2 do not."""
    if name == other or min(len(name), len(other)) < SHORTEST or abs(len(name) - len(other)) > 1:
        return False
    start = next((i for i, (a, b) in enumerate(zip(name, other, strict=False)) if a != b), min(len(name), len(other)))
    left, right = name[start:], other[start:]
    if any(rest[:1].isdigit() for rest in (left, right)):
        return False
    return (
        left[1:] == right[1:]
        or left[1:] == right
        or left == right[1:]
        or (len(left) > 1 and left[1::-1] == right[:2] and left[2:] == right[2:])
    )
