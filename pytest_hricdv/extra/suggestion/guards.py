"""At an event: what holds whenever it happens, of signals, of scopes between other events, and of its own numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate, number, rounded
from pytest_hricdv.extra.suggestion.occurrences import scope, signal_conditions, state_conditions
from pytest_hricdv.extra.suggestion.views import Condition, Event, Runs

MOST_SHARE = 0.8
"""What holds at so much of all times says little of an event (chosen)."""

NARROW = 0.15
"""The values of a number at an event are narrow where they take this part of all its values at most (chosen)."""

MOST_SCOPES = 12
"""So many scopes are tried, those first that are between messages of the most topics (chosen)."""


def guards(runs: Runs, events: Sequence[Event]) -> Iterator[Candidate]:
    """What holds at each event that the code under test, or the world, causes."""
    every = (*signal_conditions(runs), *state_conditions(runs))
    conditions = [condition for condition in every if condition.share > 0.0]
    scopes = scopes_of(runs, events)
    said: set[tuple[str, str]] = set()
    for event in sorted(events, key=lambda other: other.narrow):
        if event.author == "person" or event.is_state or event.count < LEAST_SUPPORT:
            continue
        for candidate in _at(runs, event, conditions, scopes):
            key = event.subject, candidate.response
            # What holds at all messages of a topic is not said again of some of them.
            if not (event.narrow and key in said):
                yield candidate
            said.add(key)


def _at(runs: Runs, event: Event, conditions: Sequence[Condition], scopes: Sequence[Condition]) -> Iterator[Candidate]:
    for condition in conditions:
        is_other = condition.subject != event.subject and condition.text not in event.text
        if is_other and condition.share <= MOST_SHARE and _holds(event, condition):
            yield _guard(event, condition, condition.text)
    yield from _one_of(runs, event, conditions)
    for condition in scopes:
        # A scope that the event ends says the same as an order.
        is_end = condition.subject.split()[1] == event.subject
        if not is_end and condition.share <= MOST_SHARE and _holds(event, condition, before=True):
            yield _guard(event, condition, f"previously({condition.text})")
    yield from _narrow(runs, event)


def _holds(event: Event, condition: Condition, *, before: bool = False) -> bool:
    return all(condition.holds(run, time_s, before=before) for run, times in enumerate(event.times) for time_s in times)


def _guard(event: Event, condition: Condition, text: str) -> Candidate:
    when = condition.words if condition.words.startswith("between") else f"with {condition.words}"
    return Candidate(
        "at event",
        f"{_capital(event.words)} happens {when} only",
        event.text,
        text,
        frozenset({event.subject, *condition.subject.split()}),
        event.count,
        f"true {condition.share:.0%} of the time",
        1.0 - condition.share,
        condition.is_state,
    )


def _one_of(runs: Runs, event: Event, conditions: Sequence[Condition]) -> Iterator[Candidate]:
    """Of a text: the two or three values that it has at an event."""
    for name, kind in runs.vocabulary.signals.items():
        if kind is not str or name == event.subject:
            continue
        values = {str(runs.value_at(name, run, time_s)) for run, times in enumerate(event.times) for time_s in times}
        share = sum(
            condition.share
            for condition in conditions
            if condition.subject == name and any(condition.text.endswith(f'"{value}"') for value in values)
        )
        if 2 <= len(values) <= 3 and share <= MOST_SHARE:
            text = " | ".join(f'{name} == "{value}"' for value in sorted(values))
            words = f"{name} {' or '.join(sorted(values))}"
            yield _guard(event, Condition(text, name, (), share, words), text)


def _narrow(runs: Runs, event: Event) -> Iterator[Candidate]:
    """Of a number: the values that it has at an event, where these are at one end of all its values."""
    for name, kind in runs.vocabulary.signals.items():
        if kind is not float or name == event.subject or f"& {name} " in event.text:
            continue
        values = [
            value
            for run, times in enumerate(event.times)
            for time_s in times
            if isinstance(value := runs.value_at(name, run, time_s), float)
        ]
        every = [float(value) for _, series in runs.series(name) for value in series]
        if len(values) < event.count or not every:
            continue
        least, most, whole = min(values), max(values), max(every) - min(every)
        if whole <= 0.0 or most - least > NARROW * whole:
            continue
        share = (most - least) / whole
        margin = max((most - least) / 2, 0.02 * whole)
        text = ""
        if least <= min(every) + NARROW * whole:
            text = f"{name} <= {number(rounded(most + margin, up=True))}"
        elif most >= max(every) - NARROW * whole:
            text = f"{name} >= {number(rounded(least - margin, up=False))}"
        if text:
            seen = f"observed {number(round(least, 4))} to {number(round(most, 4))}"
            yield Candidate(
                "at event",
                f"{_capital(event.words)} happens with {text} only",
                event.text,
                text,
                frozenset({event.subject, name}),
                event.count,
                seen,
                0.8 - share,
            )


def scopes_of(runs: Runs, events: Sequence[Event]) -> list[Condition]:
    """The times between an event and another one, which take turns."""
    plain = [event for event in events if not event.narrow and event.text.startswith("on(") and not event.is_state]
    made = [
        scope(runs, begin, end)
        for begin in plain
        for end in plain
        if begin.subject != end.subject and end.count >= LEAST_SUPPORT and _take_turns(begin, end)
    ]
    made.sort(key=lambda condition: (abs(condition.share - 0.5), condition.text))
    return made[:MOST_SCOPES]


def _take_turns(begin: Event, end: Event) -> bool:
    """Whether there is a begin before each end, after the end before."""
    turns = 0
    for begins, ends in zip(begin.times, end.times, strict=True):
        before_s = float("-inf")
        for time_s in ends:
            if not any(before_s <= other_s < time_s for other_s in begins):
                return False
            before_s = time_s
            turns += 1
    return turns >= LEAST_SUPPORT


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
