"""Template response: an event is followed by another one, within one time and not before another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT, RequirementCandidate, above, below, number
from pytest_hricdv.extra.suggestion.events import RecordedEvent, Runs, next_after

MIN_ANSWERED = 0.9
"""A reaction follows before the next trigger in this share of cases; otherwise it does not react to it."""

MAX_BASE_RATE = 0.7
"""A window that contains the reaction at this share of all times says hardly anything about the trigger."""

CYCLE_S = 0.1
"""What happens at the same instant is asked for within this time: a cycle of control."""

MAX_OF_TRIGGER = 6
"""Reactions of a trigger that become candidates: messages first, then the fastest."""


@dataclass(frozen=True)
class _Delays:
    """The delays of a reaction after a trigger.

    Args:
        delays_s: of each case (s).
        prompt: how many came before the next trigger.
        open_s: how long (s) triggers without a reaction waited until the end of their run.
        by_people: number of cases in which a person acts between trigger and reaction.
    """

    delays_s: list[float]
    prompt: int
    open_s: list[float]
    by_people: int


def responses(runs: Runs, events: Sequence[RecordedEvent]) -> Iterator[RequirementCandidate]:
    """Responses of all pairs whose second event the code under test or the world causes.

    What holds for all messages of a topic is not repeated for some of them.
    """
    general: set[tuple[str, str]] = set()
    for trigger in sorted(events, key=lambda event: event.is_part):
        if trigger.count < MIN_SUPPORT:
            continue
        candidates: list[tuple[RequirementCandidate, float]] = []
        for reaction in events:
            if reaction.author == "person" or reaction is trigger or (trigger.subject, reaction.text) in general:
                continue
            if reaction.subject != trigger.subject or not _coincide(reaction, trigger):
                candidates += _response(runs, trigger, reaction)
        if not trigger.is_part:
            general.update((trigger.subject, candidate.reaction) for candidate, _ in candidates)
        candidates.sort(key=lambda pair: (pair[0].of_state, "on(" not in pair[0].response, pair[1], pair[0].formula))
        yield from [candidate for candidate, _ in candidates[:MAX_OF_TRIGGER]]


def _coincide(one: RecordedEvent, other: RecordedEvent) -> bool:
    return any(not {*times}.isdisjoint(others) for times, others in zip(one.times, other.times, strict=True))


def _response(
    runs: Runs, trigger: RecordedEvent, reaction: RecordedEvent
) -> Iterator[tuple[RequirementCandidate, float]]:
    """The candidate with the longest delay (s), if the reaction follows."""
    delays = _delays(runs, trigger, reaction)
    if delays is None or len(delays.delays_s) < MIN_SUPPORT or delays.prompt < MIN_ANSWERED * len(delays.delays_s):
        return
    longest_s, shortest_s = max(delays.delays_s), min(delays.delays_s)
    if any(open_s > longest_s for open_s in delays.open_s):
        return
    if trigger.author != "person" and delays.by_people == len(delays.delays_s):
        return  # it reacts to the person
    base = _base_rate(runs, reaction, longest_s)
    # A message that is answered before the next one each time: that it takes long makes it no accident.
    is_exchange = delays.prompt == len(delays.delays_s) and not trigger.is_part and trigger.is_message
    if base > MAX_BASE_RATE and not is_exchange:
        return
    spread_s = longest_s - shortest_s
    upper = max(CYCLE_S, above(longest_s, spread_s))
    # People notice a second; a minimum far below the maximum says little.
    lower = below(shortest_s, spread_s) if shortest_s >= max(1.0, 0.4 * longest_s) else 0.0
    least = f"not before {number(lower)} s and " if lower else ""
    candidate = RequirementCandidate(
        "response",
        f"After {trigger.words}, {reaction.words} follows {least}within {number(upper)} s",
        trigger.text,
        f"eventually[{number(lower)}:{number(upper)}]({reaction.text})",
        frozenset({trigger.subject, reaction.subject}),
        len(delays.delays_s),
        f"observed {number(round(shortest_s, 3))} to {number(round(longest_s, 3))} s",
        max(0.0, 1.0 - base),
        trigger.is_state or reaction.is_state,
    )
    yield candidate, longest_s


def _delays(runs: Runs, trigger: RecordedEvent, reaction: RecordedEvent) -> _Delays | None:
    """None if most triggers are followed by nothing."""
    delays_s: list[float] = []
    open_s: list[float] = []
    prompt = by_people = 0
    for run, (log, triggers, reactions) in enumerate(zip(runs.logs, trigger.times, reaction.times, strict=True)):
        at_once = {*reactions}
        for place, time_s in enumerate(triggers):
            then_s = time_s if time_s in at_once else next_after(reactions, time_s)
            following_s = triggers[place + 1] if place + 1 < len(triggers) else log.end_s
            if then_s is None:
                open_s.append(log.end_s - time_s)
                if len(open_s) > len(delays_s) + 2 * len(runs.logs):
                    return None
            else:
                delays_s.append(then_s - time_s)
                prompt += then_s <= following_s
                act_s = next_after(runs.acts[run], time_s)
                by_people += act_s is not None and act_s <= then_s
    return _Delays(delays_s, prompt, open_s, by_people)


def _base_rate(runs: Runs, reaction: RecordedEvent, within_s: float) -> float:
    """The share of all times at which the reaction follows within this time."""
    covered_s = 0.0
    for log, times in zip(runs.logs, reaction.times, strict=True):
        before_s = 0.0
        for time_s in times:
            begin_s = max(before_s, time_s - within_s, 0.0)
            covered_s += max(0.0, min(time_s, log.end_s) - begin_s)
            before_s = time_s
    return covered_s / runs.total_s
