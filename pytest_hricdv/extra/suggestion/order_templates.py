"""Templates of order and time, for `mining`: response, precedence and absence, after Dwyer et al.

- Response: an event is followed by another one, within one time and not before another.
- Precedence: an event happens only after another one, and at most once after each.
- Absence: an event never follows a message with one value, though it follows other values.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT, RequirementCandidate, above, below, number
from pytest_hricdv.extra.suggestion.events import RecordedEvent, Runs, last_before, next_after
from pytest_hricdv.report.formatting import capitalize

MAX_OF_EVENT = 4
"""Maximum number of candidates per event: those with the causes nearest in time before it."""


def precedences(events: Sequence[RecordedEvent]) -> Iterator[RequirementCandidate]:
    """Precedences of all pairs whose second event is caused by the code under test, or is a message of the world.

    Signals of the world are left out: a person may have changed them.
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
        delays_s: the delay of each case (s).
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
