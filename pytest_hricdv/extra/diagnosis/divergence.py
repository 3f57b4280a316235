"""Divergence: the first event at which a failing run and a passing run of nearly the same test differ.

Two runs are compared stream by stream: the messages that one sender sends of one topic, or one signal. Numbers are left
out, and what repeats counts once: with a change to the test all later times differ a little, and with them what is
measured and how often it is sent, which says nothing. Of all streams, that counts which differs first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from pytest_hricdv.extra.diagnosis.records import ShownEvent
from pytest_hricdv.extra.diagnosis.runs import RunEvent, RunSummary

BEFORE, AFTER = 2, 4
"""Number of events shown before and after the runs diverge. Chosen: both lists fit on a screen side by side."""


MAX_VIOLATIONS = 3
"""Number of violations among these events. Chosen: the first ones matter."""


@dataclass(frozen=True)
class Divergence:
    """The point where two runs diverge.

    Args:
        failing: events of the failing run around it. passing: those of the passing run.
        at: index of the first different one, from 0; None if there is none.
    """

    failing: tuple[ShownEvent, ...] = ()
    passing: tuple[ShownEvent, ...] = ()
    at: int | None = None


Pair = tuple[RunEvent | None, RunEvent | None]
"""Events of one stream that differ, of the failing and of the passing run; None if the stream has no more."""


def find_divergence(failing: RunSummary, passing: RunSummary) -> Divergence:
    """Find the point where both runs diverge."""
    runs = changes(failing), changes(passing)
    violated = [
        ShownEvent(time_s=round(time_s, 3), text=f"{name} is violated")
        for name, time_s in sorted(failing.times_s.items(), key=lambda entry: (entry[1], entry[0]))
    ][:MAX_VIOLATIONS]
    pair = min(_differences(*runs), key=_time_s, default=None)
    if pair is None:
        return Divergence(failing=tuple(violated))
    places = [_place(run, event, _time_s(pair)) for run, event in zip(runs, pair, strict=True)]
    common = min(BEFORE, *places)
    shown = [
        [ShownEvent(time_s=round(event.time_s, 3), text=event.text) for event in run[place - common : place + AFTER]]
        for run, place in zip(runs, places, strict=True)
    ]
    after = sorted([*shown[0][common:], *violated], key=lambda event: event.time_s)
    return Divergence((*shown[0][:common], *after), tuple(shown[1]), common)


def changes(run: RunSummary) -> list[RunEvent]:
    """The events of a run, without those that repeat what the last one of their stream said."""
    last: dict[str, str] = {}
    kept = []
    for event in run.events:
        if last.get(event.stream) != event.value:
            kept.append(event)
        last[event.stream] = event.value
    return kept


def _differences(failing: Sequence[RunEvent], passing: Sequence[RunEvent]) -> Iterator[Pair]:
    """The first events that differ in each stream."""
    for stream in dict.fromkeys(event.stream for event in (*failing, *passing)):
        of_stream = ([event for event in run if event.stream == stream] for run in (failing, passing))
        for first, second in zip_longest(*of_stream):
            if first is None or second is None or first.value != second.value:
                yield first, second
                break


def _time_s(pair: Pair) -> float:
    return min(event.time_s for event in pair if event is not None)


def _place(run: Sequence[RunEvent], event: RunEvent | None, time_s: float) -> int:
    """The index of the event in a run, or where it would be."""
    if event is not None:
        return next(place for place, other in enumerate(run) if other is event)
    return sum(other.time_s < time_s for other in run)
