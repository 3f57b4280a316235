"""Template precedence: an event happens only after another one, and at most once after each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT, RequirementCandidate
from pytest_hricdv.extra.suggestion.events import RecordedEvent, last_before
from pytest_hricdv.report.formatting import capitalize

MAX_OF_EVENT = 4
"""Causes of an event that become candidates: those nearest to it."""


def precedences(events: Sequence[RecordedEvent]) -> Iterator[RequirementCandidate]:
    """Precedences of all pairs whose second event is caused by the code under test, or is a message of the world.

    A signal of the world may have changed for a person.
    """
    for event in events:
        is_answer = event.author == "robot" or (event.author == "world" and event.is_message)
        if not is_answer or event.count < MIN_SUPPORT:
            continue
        candidates = [
            (lag_s, _precedence(event, cause))
            for cause in events
            if not cause.is_state and _may_cause(cause, event) and (lag_s := _longest_lag_s(event, cause)) is not None
        ]
        candidates.sort(key=lambda pair: (pair[0], pair[1].formula))
        yield from [candidate for _, candidate in candidates[:MAX_OF_EVENT]]


def _may_cause(cause: RecordedEvent, event: RecordedEvent) -> bool:
    """Whether one may be the reason of the other: about something else, or about other messages of the topic."""
    # A cause that happens again and again before each event excludes little.
    if cause.count > 8 * event.count:
        return False
    if cause.subject != event.subject:
        return True
    are_parts = cause.is_message and event.is_message and cause.is_part and event.is_part
    return are_parts and all({*ours}.isdisjoint(others) for ours, others in zip(cause.times, event.times, strict=True))


def _longest_lag_s(event: RecordedEvent, cause: RecordedEvent) -> float | None:
    """The longest time (s) from a cause to the event; None if an event has no cause of its own."""
    longest_s = 0.0
    for times, causes in zip(event.times, cause.times, strict=True):
        before_s = float("-inf")
        for time_s in times:
            cause_s = last_before(causes, time_s)
            if cause_s is None or cause_s < before_s:
                return None
            longest_s = max(longest_s, time_s - cause_s)
            before_s = time_s
    return longest_s


def _precedence(event: RecordedEvent, cause: RecordedEvent) -> RequirementCandidate:
    return RequirementCandidate(
        "precedence",
        f"{capitalize(event.words)} happens at most once after {cause.words}, and never without it",
        event.text,
        f"previously(!{event.operand} since {cause.operand})",
        frozenset({event.subject, cause.subject}),
        event.count,
        "",
        1.0 / (1.0 + cause.count / event.count / 2),
        event.is_state,
    )
