"""Responses: after an event, another one within a time; which of several; and not before a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate, above, below, number
from pytest_hricdv.extra.suggestion.views import Event, Runs, next_after

LEAST_ANSWERED = 0.9
"""A reaction follows before the next trigger in so many cases at least: otherwise it is none to it (chosen)."""

MOST_BASE = 0.7
"""A window that has the reaction at so much of all times says hardly anything of the trigger (chosen)."""

AT_ONCE_S = 0.1
"""What happens at the same instant is asked for within this time: a cycle of control (chosen)."""

EARLY_S = 1.0
"""What comes at least so much later has a least time, too: people notice a second (chosen)."""

MOST_BETWEEN = 0.95
"""Where a person acts in between in more cases, the reaction is to the person (chosen)."""

MOST_ALTERNATIVES = 3
LEAST_PART = 0.05
"""Of several reactions each is the first in so many cases at least, and in two (chosen)."""

MUCH_SOONER = 0.5
"""Of some messages it is said again where it comes in half of the time (chosen)."""

MOST_OF_ONE = 6
"""So many reactions of a trigger are candidates (chosen)."""


@dataclass(frozen=True)
class _Delays:
    """How a reaction follows.

    Args:
        delays_s: of each case (s).
        prompt: how many came before the next trigger.
        open_s: for how long (s) there was none yet, at the end of a run.
        between: in how many cases a person acts after the trigger, and not after the reaction.
    """

    delays_s: list[float]
    prompt: int
    open_s: list[float]
    between: int


def responses(runs: Runs, events: Sequence[Event]) -> Iterator[Candidate]:
    """Of all pairs of events whose second one the code under test, or the world, causes.

    What holds of all messages of a topic is not said again of some of them.
    """
    said: dict[tuple[str, str], float] = {}
    for trigger in sorted(events, key=lambda event: event.narrow):
        if trigger.count < LEAST_SUPPORT:
            continue
        made = [
            (candidate, longest_s)
            for reaction in events
            if reaction.author != "person" and reaction is not trigger and not _is_part(reaction, trigger)
            for candidate, longest_s in _response(runs, trigger, reaction)
            if longest_s < MUCH_SOONER * said.get((trigger.subject, reaction.text), float("inf"))
        ]
        if not trigger.narrow:
            reactions = ((candidate.response.partition("](")[2].removesuffix(")"), s) for candidate, s in made)
            said.update({(trigger.subject, text): longest_s for text, longest_s in reactions})
        # Messages first: they are what somebody waits for.
        made.sort(key=lambda pair: ("on(" not in pair[0].response, pair[1], pair[0].formula))
        plain = [candidate for candidate, _ in made if not candidate.of_state][:MOST_OF_ONE]
        yield from plain
        yield from [candidate for candidate, _ in made if candidate.of_state][: MOST_OF_ONE // 2]
        yield from _alternatives(runs, trigger, events)


def _is_part(reaction: Event, trigger: Event) -> bool:
    """Whether both may be one and the same."""
    return reaction.subject == trigger.subject and any(
        not {*mine}.isdisjoint(others) for mine, others in zip(reaction.times, trigger.times, strict=True)
    )


def _response(runs: Runs, trigger: Event, reaction: Event) -> Iterator[tuple[Candidate, float]]:
    delays = _delays(runs, trigger, reaction)
    if delays is None or len(delays.delays_s) < LEAST_SUPPORT:
        return
    longest_s, shortest_s = max(delays.delays_s), min(delays.delays_s)
    if any(open_s > longest_s for open_s in delays.open_s):
        return
    if delays.prompt < LEAST_ANSWERED * len(delays.delays_s):
        return
    if trigger.author != "person" and delays.between > MOST_BETWEEN * len(delays.delays_s):
        return
    base = _base(runs, reaction, longest_s)
    # A message that is answered before the next one, each time: that it takes long makes it no accident.
    is_round = delays.prompt == len(delays.delays_s) and not trigger.narrow and trigger.text.startswith("on(")
    if base > MOST_BASE and not is_round:
        return
    spread_s = longest_s - shortest_s
    upper = max(AT_ONCE_S, above(longest_s, spread_s))
    lower = below(shortest_s, spread_s) if shortest_s >= EARLY_S and shortest_s >= 0.4 * longest_s else 0.0
    least = f"not before {number(lower)} s and " if lower else ""
    seen = f"{number(round(shortest_s, 3))} to {number(round(longest_s, 3))} s"
    candidate = Candidate(
        "response",
        f"After {trigger.words}, {reaction.words} follows {least}within {number(upper)} s",
        trigger.text,
        f"eventually[{number(lower)}:{number(upper)}]({reaction.text})",
        frozenset({trigger.subject, reaction.subject}),
        len(delays.delays_s),
        f"observed {seen}",
        1.0 - base,
        trigger.is_state or reaction.is_state,
    )
    yield candidate, longest_s


def _delays(runs: Runs, trigger: Event, reaction: Event) -> _Delays | None:
    """None where there is a case without a reaction that is long over."""
    delays_s: list[float] = []
    open_s: list[float] = []
    prompt = between = 0
    acts = runs.acts
    for run, (log, triggers, reactions) in enumerate(zip(runs.logs, trigger.times, reaction.times, strict=True)):
        here, place = {*reactions}, 0
        for number_of, time_s in enumerate(triggers):
            while place < len(reactions) and reactions[place] < time_s:
                place += 1
            then_s = time_s if time_s in here else reactions[place] if place < len(reactions) else None
            following_s = triggers[number_of + 1] if number_of + 1 < len(triggers) else log.end_s
            if then_s is None:
                open_s.append(log.end_s - time_s)
                if len(open_s) > len(delays_s) + 2 * len(runs.logs):
                    return None
            else:
                delays_s.append(then_s - time_s)
                prompt += then_s <= following_s
                act_s = next_after(acts[run], time_s)
                between += act_s is not None and act_s <= then_s
    return _Delays(delays_s, prompt, open_s, between)


def _base(runs: Runs, reaction: Event, within_s: float) -> float:
    """At which share of all times the reaction follows within this time."""
    covered_s = 0.0
    for log, times in zip(runs.logs, reaction.times, strict=True):
        before_s = 0.0
        for time_s in times:
            begin_s = max(before_s, time_s - within_s, 0.0)
            covered_s += max(0.0, min(time_s, log.end_s) - begin_s)
            before_s = time_s
    return covered_s / runs.total_s


def _alternatives(runs: Runs, trigger: Event, events: Sequence[Event]) -> Iterator[Candidate]:
    """Of a trigger that no single event always follows: the few of which one always does."""
    if trigger.narrow and trigger.is_state:
        return
    own = [event for event in events if not event.is_state and event.subject != trigger.subject]
    broad = [event for event in own if not event.narrow and "> 0" not in event.text]
    cases = [
        (run, time_s, min(triggers[place + 1] if place + 1 < len(triggers) else log.end_s, log.end_s))
        for run, (log, triggers) in enumerate(zip(runs.logs, trigger.times, strict=True))
        for place, time_s in enumerate(triggers)
    ]
    answers = {
        event.text: {
            case: then_s - case[1]
            for case in cases
            if (then_s := next_after(event.times[case[0]], case[1])) is not None and then_s <= case[2]
        }
        for event in broad
    }
    left = {*cases}
    chosen: list[Event] = []
    while left and len(chosen) < MOST_ALTERNATIVES:
        best = max(
            broad, key=lambda event: (len(left & answers[event.text].keys()), event.author == "robot"), default=None
        )
        if best is None or len(left & answers[best.text].keys()) < max(2, LEAST_PART * len(cases)):
            break
        left -= answers[best.text].keys()
        chosen.append(best)
    decided = [case for case in cases if case not in left]
    if len(chosen) < 2 or len(decided) < LEAST_SUPPORT or all(event.author == "person" for event in chosen):
        return
    firsts_s = [min(answers[event.text].get(case, float("inf")) for event in chosen) for case in decided]
    longest_s = max(firsts_s)
    if any(case[2] - case[1] > longest_s and case[2] < runs.logs[case[0]].end_s for case in left):
        return
    if any(runs.logs[case[0]].end_s - case[1] > longest_s for case in left):
        return
    base = sum(_base(runs, event, longest_s) for event in chosen)
    if base > 2.0 * MOST_BASE:
        return
    upper = max(AT_ONCE_S, above(longest_s, longest_s - min(firsts_s)))
    words = " or ".join(event.words for event in chosen)
    yield Candidate(
        "response",
        f"After {trigger.words}, {words} follows within {number(upper)} s",
        trigger.text,
        f"eventually[0:{number(upper)}]({' | '.join(event.text for event in chosen)})",
        frozenset({trigger.subject, *(event.subject for event in chosen)}),
        len(decided),
        f"observed {number(round(min(firsts_s), 3))} to {number(round(longest_s, 3))} s",
        max(0.0, 1.0 - base / 2),
    )
