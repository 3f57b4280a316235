"""Absences: what does not happen after a message with some values, as it does after others, up to the next round."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate
from pytest_hricdv.extra.suggestion.views import Event, Runs, next_after

LEAST_OTHERWISE = 0.6
"""After the other values it happens in so many cases at least (chosen)."""


def absences(runs: Runs, events: Sequence[Event]) -> Iterator[Candidate]:
    """Of the values of each topic, against all that happens to others."""
    broad = [event for event in events if event.text.startswith("on(") and not event.narrow and not event.is_state]
    by_topic = {event.subject: event for event in broad}
    for trigger in events:
        whole = by_topic.get(trigger.subject)
        if not trigger.narrow or trigger.is_state or whole is None or trigger.count < LEAST_SUPPORT:
            continue
        rest = tuple(
            tuple(time_s for time_s in every if time_s not in {*mine})
            for every, mine in zip(whole.times, trigger.times, strict=True)
        )
        if sum(map(len, rest)) < LEAST_SUPPORT:
            continue
        for event in events:
            if event.author == "person" or event.subject == trigger.subject or event.is_state:
                continue
            yield from _absence(runs, trigger, rest, event, broad)


def _absence(
    runs: Runs, trigger: Event, rest: tuple[tuple[float, ...], ...], event: Event, rounds: Sequence[Event]
) -> Iterator[Candidate]:
    for again in sorted(rounds, key=lambda other: (other.author != "person", other.text)):
        if again.subject in (event.subject, trigger.subject):
            continue
        if _share(runs, trigger.times, event, again) > 0.0 or _share(runs, rest, event, again) < LEAST_OTHERWISE:
            continue
        this = f"({event.text})" if "&" in event.text else event.text
        yield Candidate(
            "absence",
            f"After {trigger.words}, {event.words} does not happen before {again.words}",
            trigger.text,
            f"always(!{this}) until {again.text}",
            frozenset({trigger.subject, event.subject, again.subject}),
            trigger.count,
            "",
            0.8,
        )
        return


def _share(runs: Runs, times: Sequence[Sequence[float]], event: Event, again: Event) -> float:
    """After how many of these times the event happens before the next round."""
    total = happened = 0
    for run, triggers in enumerate(times):
        for time_s in triggers:
            end_s = next_after(again.times[run], time_s) or runs.logs[run].end_s
            then_s = next_after(event.times[run], time_s)
            total += 1
            happened += then_s is not None and then_s < end_s
    return happened / max(1, total)
