"""What an effect lacks to be another one, and how far effects are apart.

What it lacks are letters, where texts of one length differ, as patterns of bits do; what else differs may be a
consequence of a pattern. Only where no letter is lacking, it is all that differs together.
"""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

from pytest_hricdv.extra.closing.interactions import Effect


class Letter(NamedTuple):
    """A letter that an effect lacks: in which of its texts, of which length, where in the text, and which one."""

    number: int
    size: int
    place: int
    wanted: str


class Whole(NamedTuple):
    """An effect that is present instead of the one that is wanted."""

    present: Effect
    wanted: Effect


Lack = Letter | Whole


def lacking(effect: Effect, wanted: Effect) -> tuple[Lack, ...]:
    """What an effect lacks to be the one that is wanted."""
    letters = tuple(
        Letter(number, len(one), place, there)
        for number, (one, other) in enumerate(zip(chain(*effect), chain(*wanted), strict=False))
        if len(one) == len(other)
        for place, (here, there) in enumerate(zip(one, other, strict=True))
        if here != there
    )
    return letters or ((Whole(effect, wanted),) if effect != wanted else ())


def has(effect: Effect, lack: Lack) -> bool:
    """Whether an effect has what another one lacks."""
    if isinstance(lack, Whole):
        return effect == lack.wanted
    return letter_of(effect, lack) == lack.wanted


def is_without(effect: Effect, lack: Lack) -> bool:
    """Whether an effect lacks it. One that is not alike neither has it nor is without it."""
    if isinstance(lack, Whole):
        return effect == lack.present
    return letter_of(effect, lack) not in ("", lack.wanted)


def apart(one: Effect, two: Effect) -> float:
    """How far two effects are apart: 1 for each text that differs, but for texts of one length, as patterns of bits
    are, the share of their characters that differ."""
    texts = zip(chain(*one), chain(*two), strict=False)
    return sum(_differing(left, right) for left, right in texts)


def _differing(left: str, right: str) -> float:
    if left == right or len(left) != len(right):
        return float(left != right)
    return sum(a != b for a, b in zip(left, right, strict=True)) / len(left)


def letter_of(effect: Effect, lack: Letter) -> str:
    """The letter that is there; empty where the text is of another length."""
    texts = tuple(chain(*effect))
    is_alike = lack.number < len(texts) and len(texts[lack.number]) == lack.size
    return texts[lack.number][lack.place] if is_alike else ""


def is_changed(before: Effect, after: Effect, lack: Letter) -> bool:
    """Whether a letter is another one in a text of the same length."""
    return letter_of(after, lack) not in ("", letter_of(before, lack))


def are_comparable(one: Effect, other: Effect) -> bool:
    """Whether effects are of the same cross products."""
    return [each[0] for each in one] == [each[0] for each in other]
