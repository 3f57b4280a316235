"""What a stream says: a topic whose messages come again and again, so that none of them is an event.

That it says something else than before is one, where it says few things: the gear of a drive, the colour of a light, a
speed of a table.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise

from pytest_hricdv.extra.suggestion.candidate import CHECKSUM, LEAST_SUPPORT, is_quantity, number
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage
from pytest_hricdv.extra.suggestion.views import Event, Runs
from pytest_hricdv.runtime.plain import Value

MOST_A_RUN = 200
"""What happens more often in a run is no event (chosen)."""

MOST_CONTENTS = 12
"""With more, what a field says is no choice of the code (chosen)."""

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


def content_events(runs: Runs) -> Iterator[Event]:
    """When each stream that no person sends begins to say each of its contents."""
    for topic, fields in runs.vocabulary.messages.items():
        author = runs.author(topic)
        if author == "person":
            continue
        for member, kind in fields.items():
            if kind is float and not is_quantity(member) and not member.endswith(CHECKSUM):
                continue
            values = held_contents(runs, topic, member)
            if len(values) < 2:
                continue
            name = f"{topic}.{member}"
            for value in values:
                times = tuple(_begins(messages, member, value) for messages in runs.messages[topic])
                text, title = f"rise({equality(name, value)})", f"begin of {words(name, value)}"
                yield Event(text, topic, author, times, narrow=True, is_state=runs.state == name, words=title)


def _begins(messages: Sequence[StoredMessage], member: str, value: Value) -> tuple[float, ...]:
    """When (s) the field begins to have a value; of several messages at an instant the last counts."""
    settled = {message.time_s: message.fields[member] == value for message in messages}
    before = (False, *settled.values())
    return tuple(time_s for (time_s, now), then in zip(settled.items(), before, strict=False) if now and not then)


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
    return f"{name} {value if isinstance(value, str) else number(float(value))}"
