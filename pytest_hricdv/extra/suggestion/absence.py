"""Template absence: an event that never follows a message with one value, though it follows other values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT, RequirementCandidate
from pytest_hricdv.extra.suggestion.events import RecordedEvent, Runs, next_after

MIN_OTHERWISE = 0.6
"""Share of the other values after which the event has to happen, for its absence to be significant."""


def absences(runs: Runs, events: Sequence[RecordedEvent]) -> Iterator[RequirementCandidate]:
    """Candidates for each value of a topic, compared with all other messages of the topic."""
    topics = [event for event in events if event.is_message and not event.is_part and not event.is_state]
    by_topic = {event.subject: event for event in topics}
    for trigger in events:
        every = by_topic.get(trigger.subject)
        if not trigger.is_part or trigger.is_state or every is None or trigger.count < MIN_SUPPORT:
            continue
        rest = tuple(
            tuple(time_s for time_s in times if time_s not in {*ours})
            for times, ours in zip(every.times, trigger.times, strict=True)
        )
        if sum(map(len, rest)) < MIN_SUPPORT:
            continue
        for event in events:
            if event.author != "person" and event.subject != trigger.subject and not event.is_state:
                yield from _absence(runs, trigger, rest, event, topics)


def _absence(
    runs: Runs,
    trigger: RecordedEvent,
    rest: tuple[tuple[float, ...], ...],
    event: RecordedEvent,
    rounds: Sequence[RecordedEvent],
) -> Iterator[RequirementCandidate]:
    """The absence up to the next message that begins a round; topics of people are tried first."""
    for again in sorted(rounds, key=lambda other: (other.author != "person", other.text)):
        if again.subject in (event.subject, trigger.subject):
            continue
        if _share(runs, trigger.times, event, again) > 0.0 or _share(runs, rest, event, again) < MIN_OTHERWISE:
            continue
        yield RequirementCandidate(
            "absence",
            f"After {trigger.words}, {event.words} does not happen before {again.words}",
            trigger.text,
            f"always(!{event.operand}) until {again.text}",
            frozenset({trigger.subject, event.subject, again.subject}),
            trigger.count,
            "",
            0.8,
        )
        return


def _share(runs: Runs, times: Sequence[Sequence[float]], event: RecordedEvent, again: RecordedEvent) -> float:
    """The share of these times after which the event happens before the next round."""
    total = happened = 0
    for run, triggers in enumerate(times):
        for time_s in triggers:
            end_s = next_after(again.times[run], time_s) or runs.logs[run].end_s
            then_s = next_after(event.times[run], time_s)
            total += 1
            happened += then_s is not None and then_s < end_s
    return happened / max(1, total)
