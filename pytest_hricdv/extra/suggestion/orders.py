"""Orders: no event without another one before it, at most once after it, and not sooner or later after it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise

from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate, above, below, number
from pytest_hricdv.extra.suggestion.responses import AT_ONCE_S, EARLY_S, MOST_BETWEEN
from pytest_hricdv.extra.suggestion.views import Event, Runs, last_before, next_after

MOST_OF_ONE = 4
"""So many causes of an event are candidates, those first that were nearest to it (chosen)."""

MOST_COUNTED = 2
"""Of an event, so many causes that happen as often at least are candidates, the rarest first (chosen)."""


def precedences(runs: Runs, events: Sequence[Event]) -> Iterator[Candidate]:
    """Of all pairs of events whose second one the code under test, or the world, causes."""
    for event in events:
        if event.author == "person" or event.count < LEAST_SUPPORT:
            continue
        made = [
            (candidate, lag_s)
            for cause in events
            if not cause.is_state and _may_cause(cause, event)
            for candidate, lag_s in _precedence(runs, event, cause)
        ]
        made.sort(key=lambda pair: (pair[1], pair[0].formula))
        yield from [candidate for candidate, _ in made[:MOST_OF_ONE]]
        is_counted = event.text.startswith("on(") and not event.is_state
        yield from _no_more_often(event, events) if is_counted else ()


def _may_cause(cause: Event, event: Event) -> bool:
    """Whether one may be the reason of the other: another thing, or another value of the same message."""
    if cause.subject != event.subject:
        return True
    return cause.is_message and event.is_message and cause.narrow and event.narrow and not _overlap(cause, event)


def _overlap(one: Event, other: Event) -> bool:
    return any(not {*mine}.isdisjoint(others) for mine, others in zip(one.times, other.times, strict=True))


def _no_more_often(event: Event, events: Sequence[Event]) -> Iterator[Candidate]:
    """Messages of which there are never more than of others before: who is asked twice at once may answer twice."""
    made: list[tuple[int, Candidate]] = []
    for cause in events:
        is_cause = cause.text.startswith("on(") and not cause.is_state and _may_cause(cause, event)
        if not is_cause or not _are_fewer(event, cause):
            continue
        title = f"{_capital(event.words)} happens no more often than {cause.words}"
        response = f"count({event.text}) <= count({cause.text})"
        subjects = frozenset({event.subject, cause.subject})
        surprise = 1.0 / (1.0 + cause.count / event.count / 2)
        of_event = Candidate("precedence", title, event.text, response, subjects, event.count, "", surprise)
        made.append((cause.count, of_event))
    made.sort(key=lambda pair: (pair[0], pair[1].formula))
    yield from [candidate for _, candidate in made[:MOST_COUNTED]]


def _are_fewer(event: Event, cause: Event) -> bool:
    """Whether at each event there were as many causes at least."""
    return all(
        number_of <= bisect_right(causes, time_s)
        for times, causes in zip(event.times, cause.times, strict=True)
        for number_of, time_s in enumerate(times, 1)
    )


def _precedence(runs: Runs, event: Event, cause: Event) -> Iterator[tuple[Candidate, float]]:
    lags_s: list[float] = []
    between = 0
    for run, (times, causes) in enumerate(zip(event.times, cause.times, strict=True)):
        before_s = float("-inf")
        for time_s in times:
            cause_s = last_before(causes, time_s)
            if cause_s is None or cause_s < before_s:
                return
            lags_s.append(time_s - cause_s)
            act_s = next_after(runs.acts[run], cause_s)
            between += act_s is not None and act_s <= time_s
            before_s = time_s
    # A cause that happens again and again before each event excludes little.
    if cause.count > 8 * event.count:
        return
    shortest_s, longest_s = min(lags_s), max(lags_s)
    this = f"({event.text})" if "&" in event.text else event.text
    that = f"({cause.text})" if "&" in cause.text else cause.text
    response, title = (
        f"previously(!{this} since {that})",
        f"{_capital(event.words)} happens once at most after {cause.words}, and never without it",
    )
    surprise = 1.0 / (1.0 + cause.count / max(1, event.count) / 2)
    subjects = frozenset({event.subject, cause.subject})
    yield (
        Candidate("precedence", title, event.text, response, subjects, len(lags_s), "", surprise, event.is_state),
        longest_s,
    )
    spread_s = longest_s - shortest_s
    if cause.author != "person" and between > MOST_BETWEEN * len(lags_s):
        return  # the person decides how long it takes
    if shortest_s >= EARLY_S and shortest_s >= 0.4 * longest_s:
        least = below(shortest_s, spread_s)
        yield (
            Candidate(
                "precedence",
                f"{_capital(event.words)} comes {number(least)} s after {cause.words} at the earliest",
                event.text,
                f"time_since({cause.text}) >= {number(least)}",
                subjects,
                len(lags_s),
                f"observed {number(round(shortest_s, 3))} s",
                surprise,
                event.is_state,
            ),
            longest_s,
        )
    if longest_s <= 3.0 * max(shortest_s, 1.0):
        most = max(AT_ONCE_S, above(longest_s, spread_s))
        yield (
            Candidate(
                "precedence",
                f"{_capital(event.words)} comes {number(most)} s after {cause.words} at the latest",
                event.text,
                f"time_since({cause.text}) <= {number(most)}",
                subjects,
                len(lags_s),
                f"observed {number(round(longest_s, 3))} s",
                surprise * 0.8,
                event.is_state,
            ),
            longest_s,
        )


def successions(runs: Runs) -> Iterator[Candidate]:
    """Which state the code under test comes from, for each of its states."""
    topic, _, name = runs.state.partition(".")
    if not runs.state or not runs.values(runs.state):
        return
    before: dict[str, set[str]] = {}
    counts: dict[str, int] = {}
    first: set[str] = set()
    for run in runs.messages[topic]:
        values = [str(message.fields[name]) for message in run]
        first |= {*values[:1]}
        for earlier, later in pairwise(values):
            before.setdefault(later, set()).add(earlier)
            counts[later] = counts.get(later, 0) + 1
    for later, predecessors in sorted(before.items()):
        if later in first or len(predecessors) > 3 or counts[later] < LEAST_SUPPORT:
            continue
        names = sorted(predecessors)
        yield Candidate(
            "precedence",
            f"State {later} comes after {' or '.join(names)} only",
            f'on({topic}) & {runs.state} == "{later}"',
            " | ".join(f'last({runs.state}) == "{text}"' for text in names),
            frozenset({topic}),
            counts[later],
            "",
            0.6,
            of_state=True,
        )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
