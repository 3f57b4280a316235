"""`bounds`: candidates that bound a signal while a condition holds, or a field of messages; `mining` calls it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.suggestion.candidate import (
    MIN_SUPPORT,
    RequirementCandidate,
    above,
    below,
    is_quantity,
    number,
)
from pytest_hricdv.extra.suggestion.events import Runs, Series, SignalCondition, signal_conditions
from pytest_hricdv.report.formatting import capitalize

TIGHTER = 0.6
"""A bound under a condition becomes a candidate if its range is less than this share of the range at all times."""


def bounds(runs: Runs) -> Iterator[RequirementCandidate]:
    """The bounds of all numbers that people do not set."""
    conditions = [condition for condition in signal_conditions(runs) if not condition.text.startswith("!")]
    for name, kind in runs.vocabulary.signals.items():
        if kind is float:
            yield from _signal_bounds(runs, name, conditions)
    for topic, fields in runs.vocabulary.messages.items():
        for member, kind in fields.items():
            if kind is float and is_quantity(member) and runs.author(topic) != "person":
                yield from _field_bounds(runs, topic, member)


def _signal_bounds(runs: Runs, name: str, conditions: Sequence[SignalCondition]) -> Iterator[RequirementCandidate]:
    series = runs.series(name)
    values = [float(value) for _, of_run in series for value in of_run]
    if not values or min(values) == max(values):
        return
    least, most = min(values), max(values)
    motions = next((condition for condition in conditions if condition.text == f"{name} > 0"), None)
    if least == 0.0 and motions is not None:
        upper = number(above(most))
        title, support = f"{capitalize(name)} is at most {upper}", sum(map(len, motions.spans))
        seen = f"observed {number(round(most, 4))}"
        yield RequirementCandidate(
            "bound", title, motions.text, f"{name} <= {upper}", frozenset({name}), support, seen, 0.9
        )
    for condition in conditions:
        inside = [*_values_while(series, condition)] if condition.subject != name else []
        if sum(map(len, condition.spans)) < MIN_SUPPORT or not inside:
            continue
        low, high = min(inside), max(inside)
        if high - least < TIGHTER * (most - least):
            upper_bound = above(high, 0.5 * high) if high else above(0.02 * (most - least))
            yield _while(condition, name, "<=", upper_bound, high)
        if most - low < TIGHTER * (most - least):
            yield _while(condition, name, ">=", below(low, 0.5 * low), low)


def _while(condition: SignalCondition, name: str, sign: str, bound: float, extreme: float) -> RequirementCandidate:
    words = "at most" if sign == "<=" else "at least"
    return RequirementCandidate(
        "bound",
        f"While {condition.words}, {name} is {words} {number(bound)}",
        condition.text,
        f"{name} {sign} {number(bound)}",
        frozenset({name, condition.subject}),
        sum(map(len, condition.spans)),
        f"observed {number(round(extreme, 4))}",
        0.6,
    )


def _values_while(series: Sequence[Series], condition: SignalCondition) -> Iterator[float]:
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


def _field_bounds(runs: Runs, topic: str, member: str) -> Iterator[RequirementCandidate]:
    values = [float(message.fields[member]) for run in runs.messages[topic] for message in run]
    if len(values) < MIN_SUPPORT:
        return
    name, least, most = f"{topic}.{member}", min(values), max(values)
    if least == most:
        text, title = f"{name} == {number(least)}", f"{name} is {number(least)}"
    else:
        is_whole = all(value == int(value) for value in values)
        low, high = (least, most) if is_whole else (below(least, most - least), above(most, most - least))
        text = f"{name} >= {number(low)} & {name} <= {number(high)}"
        title = f"{name} is from {number(low)} to {number(high)}"
    seen = f"observed {number(round(least, 4))} to {number(round(most, 4))}"
    yield RequirementCandidate("bound", title, f"on({topic})", text, frozenset({topic}), len(values), seen, 0.5)
