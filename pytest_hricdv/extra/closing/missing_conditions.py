"""Missing conditions: what an effect lacks to become another one, and the distance between effects.

Where texts of one length differ, as patterns of sensors do, each differing character is a condition of its own; what
else differs may be a consequence of a pattern. Only where no character differs, the effect as a whole is the condition.
"""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

from pytest_hricdv.extra.closing.interactions import Effect


class CharacterCondition(NamedTuple):
    """A character that is to be there: in which text of the effect, of which length, where in the text, and which."""

    text: int
    size: int
    place: int
    wanted: str


class EffectCondition(NamedTuple):
    """An effect that is to be there instead of the present one."""

    present: Effect
    wanted: Effect


MissingCondition = CharacterCondition | EffectCondition


def find_missing(effect: Effect, wanted: Effect) -> tuple[MissingCondition, ...]:
    """The conditions that an effect lacks to be the wanted one."""
    characters = tuple(
        CharacterCondition(number, len(text), place, right)
        for number, (text, other) in enumerate(zip(chain(*effect), chain(*wanted), strict=False))
        if len(text) == len(other)
        for place, (left, right) in enumerate(zip(text, other, strict=True))
        if left != right
    )
    return characters or ((EffectCondition(effect, wanted),) if effect != wanted else ())


def is_met(effect: Effect, condition: MissingCondition) -> bool:
    """Whether an effect meets a condition that another one misses."""
    if isinstance(condition, EffectCondition):
        return effect == condition.wanted
    return character(effect, condition) == condition.wanted


def is_missing(effect: Effect, condition: MissingCondition) -> bool:
    """Whether an effect misses a condition. One that has nothing comparable neither meets nor misses it."""
    if isinstance(condition, EffectCondition):
        return effect == condition.present
    return character(effect, condition) not in ("", condition.wanted)


def effect_distance(effect: Effect, other: Effect) -> float:
    """The distance of two effects: 1 for each different text, or for texts of equal length, such as patterns of
    sensors, the share of different characters."""
    return sum(_text_distance(left, right) for left, right in zip(chain(*effect), chain(*other), strict=False))


def _text_distance(left: str, right: str) -> float:
    if left == right or len(left) != len(right):
        return float(left != right)
    return sum(a != b for a, b in zip(left, right, strict=True)) / len(left)


def character(effect: Effect, condition: CharacterCondition) -> str:
    """The character that is there; empty if the text is of another length."""
    texts = tuple(chain(*effect))
    is_alike = condition.text < len(texts) and len(texts[condition.text]) == condition.size
    return texts[condition.text][condition.place] if is_alike else ""


def is_changed(before: Effect, after: Effect, condition: CharacterCondition) -> bool:
    """Whether the character is another one, in a text of the same length."""
    return character(after, condition) not in ("", character(before, condition))


def are_comparable(effect: Effect, other: Effect) -> bool:
    """Whether effects are of the same cross products."""
    return [outcome[0] for outcome in effect] == [outcome[0] for outcome in other]
