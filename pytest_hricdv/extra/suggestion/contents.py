"""What a stream says: a topic whose messages come again and again, so that none of them is an event.

That it says something else than before is one, where it says few things: the gear of a drive, the colour of a light, a
speed of a table.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise

from pytest_hricdv.extra.suggestion.candidate import CHECKSUM, LEAST_SUPPORT, Candidate, is_quantity, number
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage
from pytest_hricdv.extra.suggestion.views import Event, Runs
from pytest_hricdv.runtime.plain import Value

MOST_A_RUN = 200
"""What happens more often in a run is no event (chosen)."""

MOST_CONTENTS = 12
"""With more, what a field says is no choice of the code (chosen)."""

MOST_STEPS = 24
MOST_OF_STEPS = 0.5
"""With more changes from one to another, or a larger part of all, that there are no others says little (chosen)."""

LEAST_REPEATED = 5
"""What is chosen is said again, so many times on the average until something else is said (chosen)."""


def contents(runs: Runs, topic: str, member: str) -> list[Value]:
    """The few things that a field says, ascending; none where these are no choice of the code.

    Each is said in several runs: what a single one has may be of its parameters.
    """
    counts = Counter(value for messages in runs.messages[topic] for value in {told.fields[member] for told in messages})
    several = min(LEAST_SUPPORT, len(runs.runs))
    return sorted(counts) if len(counts) <= MOST_CONTENTS and min(counts.values(), default=0) >= several else []


def held_contents(runs: Runs, topic: str, member: str) -> list[Value]:
    """Likewise of a stream, which goes on saying one for a while; none of other topics."""
    values = [[message.fields[member] for message in messages] for messages in runs.messages[topic]]
    total = sum(map(len, values))
    changes = sum(before != value for said in values for before, value in pairwise(said))
    is_stream = total > MOST_A_RUN * len(runs.runs) and LEAST_REPEATED * changes <= total
    return contents(runs, topic, member) if is_stream else []


def _held_fields(runs: Runs) -> Iterator[tuple[str, str, list[Value]]]:
    """Topic, field and contents of each stream that no person sends, and that says several things."""
    for topic, fields in runs.vocabulary.messages.items():
        for member, kind in fields.items():
            is_told_apart = kind is not float or is_quantity(member) or member.endswith(CHECKSUM)
            if (
                is_told_apart
                and runs.author(topic) != "person"
                and len(values := held_contents(runs, topic, member)) > 1
            ):
                yield topic, member, values


def content_events(runs: Runs) -> Iterator[Event]:
    """When each stream begins to say each of its contents."""
    for topic, member, values in _held_fields(runs):
        name, author = f"{topic}.{member}", runs.author(topic)
        for value in values:
            times = tuple(_begins(messages, member, value) for messages in runs.messages[topic])
            text, title = f"rise({equality(name, value)})", f"begin of {words(name, value)}"
            yield Event(text, topic, author, times, narrow=True, is_state=runs.state == name, words=title)


def _begins(messages: Sequence[StoredMessage], member: str, value: Value) -> tuple[float, ...]:
    """When (s) the field begins to have a value; of several messages at an instant the last counts."""
    settled = {message.time_s: message.fields[member] == value for message in messages}
    before = (False, *settled.values())
    return tuple(time_s for (time_s, now), then in zip(settled.items(), before, strict=False) if now and not then)


def changes(runs: Runs) -> Iterator[Candidate]:
    """From what to what each stream changes: from forward to reverse by way of neutral only."""
    for topic, member, values in _held_fields(runs):
        pairs = Counter(pair for messages in runs.messages[topic] for pair in _steps(messages, member))
        possible = len(values) * (len(values) - 1)
        if len(values) < 3 or len(pairs) > min(MOST_STEPS, MOST_OF_STEPS * possible):
            continue
        name, several = f"{topic}.{member}", min(LEAST_SUPPORT, len(runs.runs))
        if min(pairs.values()) < several or not {value for pair in pairs for value in pair} <= {*values}:
            continue
        steps = [f"{equality(f'last({name})', a)} & {equality(name, b)}" for a, b in sorted(pairs)]
        listed = ", ".join(f"{_short(a)} to {_short(b)}" for a, b in sorted(pairs))
        title = f"{name} changes in {len(pairs)} of {possible} ways only: {listed}"
        if member.endswith(CHECKSUM):
            title = f"{name.removesuffix(CHECKSUM)} changes in {len(pairs)} of {possible} ways only, by its checksum"
        yield Candidate(
            "precedence", title, f"on({topic}) & {name} != last({name})", " | ".join(steps), frozenset({topic}),
            pairs.total(), "", 1.0 - len(pairs) / possible, of_state=runs.state == name,
        )  # fmt: skip


def _steps(messages: Sequence[StoredMessage], member: str) -> Iterator[tuple[Value, Value]]:
    """The changes of a field as they are judged: at each instant, of its last message and the one before that."""
    for place, (before, message) in enumerate(pairwise(messages), 2):
        is_last = place == len(messages) or messages[place].time_s > message.time_s
        if is_last and message.fields[member] != before.fields[member]:
            yield before.fields[member], message.fields[member]


def equality(name: str, value: Value) -> str:
    """That a field says this, as a formula: numbers are exact, as the code under test says the same ones each time.

    >>> equality("lamp.on", False), equality("drive.gear", "R"), equality("drive.turn", 1 / 3)
    ('!lamp.on', 'drive.gear == "R"', 'drive.turn == 0.3333333333333333')
    """
    if isinstance(value, bool):
        return name if value else f"!{name}"
    if isinstance(value, str):
        return f'{name} == "{value}"'
    return f"{name} == {int(value) if value == int(value) else repr(value)}"


def words(name: str, value: Value) -> str:
    """The same for people."""
    if isinstance(value, bool):
        return f"{'' if value else 'no '}{name}"
    if name.endswith(CHECKSUM):
        return f"{name.removesuffix(CHECKSUM)} with checksum {int(value)}"
    return f"{name} {_short(value)}"


def _short(value: Value) -> str:
    return value if isinstance(value, str) else number(float(value))
