"""Relations: what the fields of a message have to do with each other, with signals, counts and times before it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate, between, is_quantity, number, rounded
from pytest_hricdv.extra.suggestion.stored_run import StoredMessage
from pytest_hricdv.extra.suggestion.views import Event, Runs, last_before

CLOSE = 0.05
"""Two numbers are the same where they differ by this part of their range at most (chosen)."""

MOST_COUNTED = 2
"""A field counts so many events at most, those that are listed: others happen as often (chosen)."""

Case = tuple[int, StoredMessage]
"""A run, and a message in it."""


def relations(runs: Runs, events: Sequence[Event]) -> Iterator[Candidate]:
    """Of all messages that the code under test, or the world, sends."""
    for topic, fields in runs.vocabulary.messages.items():
        if runs.author(topic) == "person":
            continue
        cases: list[Case] = [
            (run, message) for run, messages in enumerate(runs.messages[topic]) for message in messages
        ]
        if len(cases) < LEAST_SUPPORT:
            continue
        numbers = [name for name, kind in fields.items() if kind is float and is_quantity(name)]
        yield from _counted(runs, topic, cases, numbers, events)
        for member in numbers:
            yield from _signals(runs, topic, member, cases)
            yield from _durations(runs, topic, member, cases, events)
            for flag in (name for name, kind in fields.items() if kind is bool):
                yield from _threshold(topic, flag, member, cases)
        yield from _fields(topic, numbers, cases)
        yield from _others(runs, topic, cases)


def _relation(topic: str, title: str, text: str, cases: int, others: frozenset[str], seen: str = "") -> Candidate:
    return Candidate("relation", title, f"on({topic})", text, others | {topic}, cases, seen, 0.8)


def _count(event: Event, run: int, time_s: float) -> int:
    return bisect_right(event.times[run], time_s)


def _counted(
    runs: Runs, topic: str, cases: Sequence[Case], numbers: Sequence[str], events: Sequence[Event]
) -> Iterator[Candidate]:
    counted: dict[str, int] = {}
    # Messages first, and of those the topic itself: what is counted by them is not counted by signals again.
    for event in sorted(events, key=lambda other: (not other.text.startswith("on("), other.subject != topic)):
        if event.is_state or event.count < LEAST_SUPPORT:
            continue
        counts = [_count(event, run, message.time_s) for run, message in cases]
        subjects = frozenset({event.subject})
        if len({*counts}) == 1 and counts[0] and not event.narrow and event.text.startswith("on("):
            text = f"count({event.text}) == {counts[0]}"
            title = f"At {topic}, {event.words} has happened {counts[0]} time{'s' if counts[0] > 1 else ''}"
            yield _relation(topic, title, text, len(cases), subjects)
        for member in numbers:
            differences = {
                float(message.fields[member]) - count for (_, message), count in zip(cases, counts, strict=True)
            }
            if len({*counts}) > 1 and len(differences) == 1 and (shift := differences.pop()) in (-1.0, 0.0, 1.0):
                sign, word = {1.0: (" + 1", ", plus 1"), -1.0: (" - 1", ", minus 1"), 0.0: ("", "")}[shift]
                text = f"{topic}.{member} == count({event.text}){sign}"
                title = f"{topic}.{member} is how often {event.words} has happened{word}"
                counted[member] = counted.get(member, 0) + 1
                if counted[member] <= MOST_COUNTED:
                    yield _relation(topic, title, text, len(cases), subjects)


def _signals(runs: Runs, topic: str, member: str, cases: Sequence[Case]) -> Iterator[Candidate]:
    for name, kind in runs.vocabulary.signals.items():
        if kind is not float:
            continue
        every = [float(value) for _, values in runs.series(name) for value in values]
        values = [runs.value_at(name, run, message.time_s) for run, message in cases]
        if not every or None in values or max(every) == min(every):
            continue
        numbers = [float(value) for value in values]  # type: ignore[arg-type]
        whole = max(every) - min(every)
        yield from _same(topic, member, cases, numbers, whole, name, name, frozenset({name}))


def _durations(
    runs: Runs, topic: str, member: str, cases: Sequence[Case], events: Sequence[Event]
) -> Iterator[Candidate]:
    ends = [event for event in events if event.text == f"on({topic})"]
    for event in events:
        if not ends or event.subject == topic or event.count < LEAST_SUPPORT:
            continue
        begins = [last_before(event.times[run], message.time_s) for run, message in cases]
        if None in begins:
            continue
        lasted = [message.time_s - begin_s for (_, message), begin_s in zip(cases, begins, strict=True)]  # type: ignore[operator]
        text = f"timebetween({event.text}, on({topic}))"
        words, whole = f"the time since {event.words}", max(lasted) - min(lasted)
        yield from _same(topic, member, cases, lasted, whole, text, words, frozenset({event.subject}))


def _same(
    topic: str,
    member: str,
    cases: Sequence[Case],
    values: Sequence[float],
    whole: float,
    text: str,
    words: str,
    subjects: frozenset[str],
) -> Iterator[Candidate]:
    fields = [float(message.fields[member]) for _, message in cases]
    worst = max(abs(mine - other) for mine, other in zip(fields, values, strict=True))
    if whole <= CLOSE * max(map(abs, values)) or worst > CLOSE * whole:
        return
    room = rounded(max(2.0 * worst, 0.01 * whole), up=True)
    name = f"{topic}.{member}"
    response = f"{name} - {text} <= {number(room)} & {text} - {name} <= {number(room)}"
    title = f"{name} is {words}, to {number(room)}"
    yield _relation(topic, title, response, len(cases), subjects, f"observed {number(rounded(worst, up=True))}")


def _threshold(topic: str, flag: str, member: str, cases: Sequence[Case]) -> Iterator[Candidate]:
    with_flag = [float(message.fields[member]) for _, message in cases if message.fields[flag]]
    without = [float(message.fields[member]) for _, message in cases if not message.fields[flag]]
    if len(with_flag) < 2 or len(without) < 2:
        return
    for low, high, sign in ((with_flag, without, "<="), (without, with_flag, ">")):
        if max(low) < min(high):
            middle = between(max(low), min(high))
            name, negated = f"{topic}.{member}", ">" if sign == "<=" else "<="
            text = (
                f"{topic}.{flag} & {name} {sign} {number(middle)} | !{topic}.{flag} & {name} {negated} {number(middle)}"
            )
            title = f"{topic} has {flag} exactly where {name} {sign} {number(middle)}"
            seen = f"observed {number(max(low))} and {number(min(high))}"
            yield _relation(topic, title, text, len(cases), frozenset(), seen)


def _fields(topic: str, numbers: Sequence[str], cases: Sequence[Case]) -> Iterator[Candidate]:
    # What never changes bounds the others, which is said as a bound.
    moving = [name for name in numbers if len({message.fields[name] for _, message in cases}) > 1]
    for first in moving:
        for second in moving:
            if first != second and all(message.fields[first] <= message.fields[second] for _, message in cases):  # type: ignore[operator]
                text = f"{topic}.{first} <= {topic}.{second}"
                yield _relation(topic, f"{topic}.{first} is at most {topic}.{second}", text, len(cases), frozenset())


def _others(runs: Runs, topic: str, cases: Sequence[Case]) -> Iterator[Candidate]:
    """A field has the value that a field of another message had last."""
    mine = runs.vocabulary.messages[topic]
    for other, fields in runs.vocabulary.messages.items():
        if other == topic:
            continue
        latest = (_last(runs.messages[other][run], message.time_s) for run, message in cases)
        lasts = [last for last in latest if last is not None]
        if len(lasts) < len(cases):
            continue
        for member, kind in mine.items():
            for name, other_kind in fields.items():
                pairs = [
                    (message.fields[member], last.fields[name]) for (_, message), last in zip(cases, lasts, strict=True)
                ]
                if kind is other_kind is float and all(a == b for a, b in pairs) and len({*pairs}) > 1:
                    text = f"{topic}.{member} == {other}.{name}"
                    title = f"{topic}.{member} is that of the last {other}"
                    yield _relation(topic, title, f"once(on({other})) & {text}", len(cases), frozenset({other}))


def _last(messages: Sequence[StoredMessage], time_s: float) -> StoredMessage | None:
    before = [message for message in messages if message.time_s <= time_s]
    return before[-1] if before else None
