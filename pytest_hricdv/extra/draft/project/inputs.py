"""What a person can say to a drafted robot: the variants of each message that the robot receives.

A variant is a combination of values, such as `{"kind": "stop"}` or a low number. Each becomes a command of the person.
"""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise, product

from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, CodeLine, Message, MessageField

MAX_VARIANTS = 12
"""Most variants of a message: enough for three bools, or for four texts with a low, usual or high number."""

OTHER = "something else"
"""A text that the code does not compare with."""


@dataclass(frozen=True)
class Variant:
    """A message with certain values.

    Args:
        name: its word in commands and in the model; empty if it is the only one.
        values: field -> source text of the value, as pairs.
        location: the location of the value in the code.
        ranges: field -> source text of the range, as pairs, of numbers that the code compares with others.
        is_usual: whether the code compares with its text, and its numbers are the usual ones for this text.
    """

    name: str
    values: tuple[tuple[str, str], ...]
    location: CodeLine
    ranges: tuple[tuple[str, str], ...] = ()
    is_usual: bool = True


@dataclass(frozen=True)
class Input:
    """A message that the robot receives, with its variants and number fields."""

    message: Message
    name: str
    variants: tuple[Variant, ...]
    numbers: tuple[MessageField, ...]

    @property
    def commands(self) -> tuple[tuple[str, Variant], ...]:
        """The name of each command, with its variant."""
        return tuple(
            (f"{self.name}_{variant.name}" if variant.name else self.name, variant) for variant in self.variants
        )

    def without(self, commands: Collection[str]) -> Input:
        """The input without some commands."""
        kept = tuple(variant for command, variant in self.commands if command not in commands)
        return Input(self.message, self.name, kept, self.numbers)


def is_open(part: MessageField) -> bool:
    """Whether a field may also have texts that the code does not compare with."""
    return part.kind == "str" and bool(part.values) and not part.by_type


def _uniform(low: float, high: float, unit: str) -> str:
    return f"Uniform({low:g}, {high:g}" + (f', "{unit}")' if unit else ")")


MAX_BOUNDARIES = 4
"""Most numbers of the code that separate the ranges of a value."""


def number_levels(part: MessageField, *, boundaries: bool = False) -> list[tuple[str, str, str, CodeLine]]:
    """The ranges of a field between the numbers that the code compares it with; the usual one first.

    If `boundaries`, each of these numbers is a range, too, for code that tests for equality.
    """
    if part.observed:
        low, high = part.observed
        margin = 0.0 if part.type == "int" else (high - low) / 10
        least = max(low - margin, 0.0) if low >= 0 else low - margin
        return [(f"seen_{word(part.name)}", part.name, _uniform(least, high + margin, part.unit),
                 part.location)]  # fmt: skip
    low, high = min(part.compared), max(part.compared)
    width = max(abs(low), abs(high), 3.0 if part.type == "int" else 0.0) or 1.0
    ends = _thin(sorted({*part.compared}))
    gaps = list(pairwise(ends))
    ranges = [(f"mid{'' if len(gaps) == 1 else f'_{number}'}", *gap) for number, gap in enumerate(gaps, start=1)]
    ranges += [("high", high + width / 4, high + width), ("low", low - width, low - width / 4)]
    ranges += [(f"at_{'minus_' if end < 0 else ''}{word(f'n{abs(end):g}')[1:]}", end, end) for end in ends
               if boundaries]  # fmt: skip
    return [(f"{level}_{word(part.name)}", part.name, _uniform(a, b, part.unit), part.location)
            for level, a, b in ranges]  # fmt: skip


def _thin(numbers: list[float]) -> list[float]:
    """At most `MAX_BOUNDARIES` numbers: the first, the last, and evenly spaced ones between them."""
    last = len(numbers) - 1
    count = min(len(numbers), MAX_BOUNDARIES)
    return [numbers[round(number * last / max(count - 1, 1))] for number in range(count)]


_Choice = tuple[str, str, str, CodeLine]
"""A value or range of a field: its word, the field, the source text, and its location."""


def variants_of(message: Message) -> Input:
    """Make the variants of a message from the values and numbers that the code compares its fields with."""
    choices = [options for part in message.fields if (options := _options(message, part))]
    numbers = tuple(part for part in message.fields if part.kind == "float")
    floats = {part.name for part in numbers}
    variants: list[Variant] = []
    for combination in _combine(choices):
        is_choice = [len(options) > 1 or len(choices) == 1 for options in choices]
        name = "_".join(choice[0] for choice, named in zip(combination, is_choice, strict=True) if choice[0] and named)
        values = tuple((choice[1], choice[2]) for choice in combination if choice[1] not in floats)
        ranges = tuple((choice[1], choice[2]) for choice in combination if choice[1] in floats)
        location = combination[0][3] if combination else message.location
        if all(variant.name != name for variant in variants):
            usual = {choice[0] for choice in choices} if values else set(combination)
            is_known = all(source != f'"{OTHER}"' for _, source in values)
            is_usual = is_known and all(part in usual for part in combination if part[1] in floats)
            variants.append(Variant(name, values, location, ranges, is_usual))
    return Input(message, word(message.topic), tuple(variants), numbers)


def _options(message: Message, part: MessageField) -> list[_Choice]:
    """The choices for one field; none if the variants of the message do not differ in it."""
    if part.kind == "str":
        source = _source if message.module != OWN_MODULE else _text
        texts = [(word(value.text), part.name, source(part, value.text), value.location) for value in part.values]
        if is_open(part):
            texts.append(("other", part.name, f'"{OTHER}"', part.values[0].location))
        return texts or [("", part.name, '"text"', part.location)]
    if part.kind == "bool":
        yes = ("with_" + word(part.name), part.name, "True", part.location)
        return [yes, ("no_" + word(part.name), part.name, "False", part.location)]
    return number_levels(part) if part.kind == "float" and part.compared else []


def _combine(choices: list[list[_Choice]]) -> list[tuple[_Choice, ...]]:
    """All combinations, or if there are too many, some that together contain each choice."""
    combinations = list(product(*choices))
    if len(combinations) <= MAX_VARIANTS:
        return combinations
    first = [choice[0] for choice in choices]
    rows = [tuple(first)]
    for number, choice in enumerate(choices):  # each option with the first option of all others
        rows += [(*first[:number], option, *first[number + 1 :]) for option in choice[1:]]
    return rows[: max(MAX_VARIANTS, *(len(choice) for choice in choices))]


def _text(_: MessageField, text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _source(part: MessageField, text: str) -> str:
    """The source text of a value: a text, or a member of an enumeration."""
    if part.by_type and part.type.isidentifier() and not part.type.startswith("Literal") and part.imports:
        return f"member({part.type}, {json.dumps(text, ensure_ascii=False)})"
    return json.dumps(text, ensure_ascii=False)
