"""Names that are probably meant to be another one."""

from __future__ import annotations

from collections.abc import Iterable

SHORTEST = 3
"""Shorter names are all near each other."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """A known name that is one letter away: one more, one less, another, or two next to each other swapped."""
    return next((other for other in sorted(set(known)) if is_near(name, other)), None)


def is_near(name: str, other: str) -> bool:
    """Whether two names differ by one slip of the finger; numbered names such as leg1 and leg2 do not count."""
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
