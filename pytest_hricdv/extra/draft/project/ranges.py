"""Ranges of a drafted testbench that a recording shows, each with the words that say where it comes from."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.extra.draft.code_model import MessageField
from pytest_hricdv.extra.draft.observed import ObservedTopic, Spread, key_of
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.inputs import Input, number_levels
from pytest_hricdv.extra.draft.project.model import in_order

MAX_PATIENCE_S, PATIENCE = 60.0, 1.1
"""A person waits a little longer for an answer than the robot waits for anything, up to a limit: a run is to end."""

LATE, STAYS = 1.5, 5
"""Greatest factor of a late person's wait; and how many answer times a person stays at the end."""

MIN_LIMIT_S = 900.0
"""Least simulated time that a run gets."""


def command_lines(draft: Draft, thing: Input) -> Iterator[str]:
    """The lines of `SAYS` for a thing: each command with the numbers in it."""
    for command, kind in thing.commands:
        ranges = dict(kind.ranges)
        chosen = [(part.name, *number_range(draft, thing, part, ranges.get(part.name))) for part in thing.numbers]
        if all(not note or note.startswith("TODO: between") for _, _, note in chosen):
            numbers = ", ".join(f'"{name}": {text}' for name, text, _ in chosen)
            mark = next((note for _, _, note in chosen if note), str(kind.location))
            yield f'    "{command}": {{{numbers}}},  # {mark}'
            continue
        yield f'    "{command}": {{  # {kind.location}'
        yield from (f'        "{name}": {text},  # {note}' for name, text, note in chosen)
        yield "    },"


def number_range(draft: Draft, thing: Input, part: MessageField, of_code: str | None) -> tuple[str, str]:
    """The range of a number of a message, and a note on its source or on what is unknown; empty without one."""
    topic = topic_of(draft, thing)
    if topic is None or not any(number.name in topic.numbers for number in thing.numbers):
        return (of_code, "") if of_code is not None else (_unknown(part), "TODO: between which numbers?")
    return _range(part, topic.numbers.get(part.name), of_code)


def _range(part: MessageField, seen: Spread | None, of_code: str | None) -> tuple[str, str]:
    """The range of a number, and where it comes from; one on a side of what the code compares it with stays there."""
    whole = part.type == "int"
    comment = seen.comment(part.unit, _unit_of_count(part), whole=whole) if seen is not None else ""
    if of_code is not None:
        return of_code, f"of the code; {comment or 'nothing was observed'}"
    if seen is None:
        return _unknown(part), "TODO: between which numbers?"
    low, high = seen.ends(whole=whole)
    unit = f', "{part.unit}"' if part.unit else ""
    return f"Uniform({low!r}, {high!r}{unit})", comment


def _unknown(part: MessageField) -> str:
    """The range of a number of which nothing is known; whole ones are often counts, and 0 and 1 say little."""
    if part.observed:
        return number_levels(part)[0][2]
    ends = "0, 10" if part.type == "int" else "0.0, 1.0"
    return f"Uniform({ends}" + (f', "{part.unit}")' if part.unit else ")")


def _unit_of_count(part: MessageField) -> str:
    return "values" if part.type == "list" else "messages"


def topic_of(draft: Draft, thing: Input) -> ObservedTopic | None:
    """The observed topic of a message or device."""
    return draft.observed.topics.get(key_of(thing.message.topic)) if draft.observed is not None else None


def answer_s(draft: Draft) -> float:
    """How long a person waits for an answer (s)."""
    return max(draft.patience_s, min(draft.late_s[0], MAX_PATIENCE_S) * PATIENCE)


def limit_s(draft: Draft) -> float:
    """Longer than any visit: two rounds, in which all is said late, or all in order, and nothing is answered (s)."""
    late_s, waits_s = LATE * draft.late_s[0], answer_s(draft)
    round_s = max(len(draft.inputs) * (late_s + waits_s), len(in_order(draft)) * (2.0 + waits_s))
    return max(MIN_LIMIT_S, 100.0 * -(-(2 * round_s + STAYS * waits_s) // 100.0))
