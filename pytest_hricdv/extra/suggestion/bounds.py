"""Bounds: of signals while something holds, and of fields in each message."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from pytest_hricdv.extra.suggestion.candidate import (
    CHECKSUM,
    LEAST_SUPPORT,
    Candidate,
    above,
    below,
    is_quantity,
    number,
)
from pytest_hricdv.extra.suggestion.contents import contents, equality, held_contents
from pytest_hricdv.extra.suggestion.occurrences import signal_conditions, state_conditions
from pytest_hricdv.extra.suggestion.views import Condition, Runs
from pytest_hricdv.runtime.plain import Value

TIGHTER = 0.6
"""A bound while something holds says more than the bound at all times where it is tighter by this factor (chosen)."""

LONG_S = 0.5
"""What holds for less time than that, in all runs, bounds nothing (chosen)."""


def bounds(runs: Runs) -> Iterator[Candidate]:
    """Of all numbers."""
    conditions = [
        condition for condition in (*signal_conditions(runs), *state_conditions(runs)) if _seconds(condition) >= LONG_S
    ]
    for name, kind in runs.vocabulary.signals.items():
        if kind is float:
            yield from _of_signal(runs, name, conditions)
    for topic, fields in runs.vocabulary.messages.items():
        for member, kind in fields.items():
            if kind is not float or runs.author(topic) == "person":
                continue
            if member.endswith(CHECKSUM):
                yield from _of_contents(runs, topic, member, contents(runs, topic, member))
            elif is_quantity(member):
                yield from _of_field(runs, topic, member)


def _seconds(condition: Condition) -> float:
    return sum(end_s - begin_s for run in condition.spans for begin_s, end_s in run)


def _of_signal(runs: Runs, name: str, conditions: Sequence[Condition]) -> Iterator[Candidate]:
    series = runs.series(name)
    every = [float(value) for _, values in series for value in values]
    if not every or min(every) == max(every):
        return
    least, most = min(every), max(every)
    moving = f"{name} > 0"
    rests = sum(value == 0.0 for value in every) >= len(series) / 2
    if rests and least >= 0.0:
        bound = above(most, 0.0)
        title = f"{_capital(name)} is at most {number(bound)}"
        seen = f"observed {number(round(most, 4))}"
        support = sum(value > 0.0 and before == 0.0 for _, values in series for before, value in _pairs(values))
        yield Candidate("bound", title, moving, f"{name} <= {number(bound)}", frozenset({name}), support, seen, 0.9)
    for condition in conditions:
        if condition.subject == name or condition.text.startswith("!"):
            continue
        inside = [*_inside(series, condition)]
        support = sum(map(len, condition.spans))
        if support < LEAST_SUPPORT or not inside:
            continue
        low, high = min(inside), max(inside)
        if high - least < TIGHTER * (most - least):
            bound = above(high, 0.5 * high) if high else above(0.02 * (most - least))
            yield _while(condition, f"{name} <= {number(bound)}", f"observed {number(round(high, 4))}", support, name)
        if most - low < TIGHTER * (most - least):
            bound = below(low, 0.5 * low)
            yield _while(condition, f"{name} >= {number(bound)}", f"observed {number(round(low, 4))}", support, name)


def _while(condition: Condition, response: str, seen: str, support: int, name: str) -> Candidate:
    return Candidate(
        "bound",
        f"While {condition.words}, {response.replace('<=', 'is at most').replace('>=', 'is at least')}",
        condition.text,
        response,
        frozenset({name, condition.subject}),
        support,
        seen,
        0.6,
        condition.is_state,
    )


def _inside(
    series: Sequence[tuple[Sequence[float], Sequence[float] | Sequence[str]]], condition: Condition
) -> Iterator[float]:
    """The values of a signal while a condition holds."""
    for (times, values), spans in zip(series, condition.spans, strict=True):
        place = 0
        for begin_s, end_s in spans:
            while place + 1 < len(times) and times[place + 1] <= begin_s:
                place += 1
            at = place
            while at < len(times) and times[at] < end_s:
                yield float(values[at])
                at += 1


def _pairs(values: Sequence[float] | Sequence[str]) -> Iterator[tuple[float, float]]:
    return pairwise(float(value) for value in values)


def _of_field(runs: Runs, topic: str, member: str) -> Iterator[Candidate]:
    values = [float(message.fields[member]) for run in runs.messages[topic] for message in run]
    if len(values) < LEAST_SUPPORT:
        return
    choices = [float(value) for value in held_contents(runs, topic, member)]
    if any(later != earlier + 1 for earlier, later in pairwise(choices)):
        yield from _of_contents(runs, topic, member, choices)
        return
    name, least, most = f"{topic}.{member}", min(values), max(values)
    whole = all(value == int(value) for value in values)
    if least == most:
        text, title = f"{name} == {number(least)}", f"{name} is {number(least)}"
    elif whole:
        text, title = (
            f"{name} >= {number(least)} & {name} <= {number(most)}",
            f"{name} is from {number(least)} to {number(most)}",
        )
    else:
        low, high = below(least, most - least), above(most, most - least)
        text, title = (
            f"{name} >= {number(low)} & {name} <= {number(high)}",
            f"{name} is from {number(low)} to {number(high)}",
        )
    seen = f"observed {number(round(least, 4))} to {number(round(most, 4))}"
    yield Candidate("bound", title, f"on({topic})", text, frozenset({topic}), len(values), seen, 0.5)


def _of_contents(runs: Runs, topic: str, member: str, values: Sequence[Value]) -> Iterator[Candidate]:
    """The few things that a field says: the code makes no others."""
    if not values:
        return
    name = f"{topic}.{member}"
    text = " | ".join(equality(name, value) for value in values)
    title = f"{name} is {' or '.join(number(float(value)) for value in values)}"
    if member.endswith(CHECKSUM):
        several = f"one of {len(values)} contents" if len(values) > 1 else "one content"
        title = f"{name.removesuffix(CHECKSUM)} has {several}, by its checksum"
    support = sum(map(len, runs.messages[topic]))
    yield Candidate("bound", title, f"on({topic})", text, frozenset({topic}), support, "", 0.5)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
