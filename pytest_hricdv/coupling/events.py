"""Detects declared events in messages and in changes of signals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

from pytest_hricdv.monitor import MonitorSet, PastFormula, Value
from pytest_hricdv.monitor.analysis import names_of, topics_of

ORDER_S = 1e-9
"""Events with one time stamp are kept apart by this much: the resolution of the monitors."""


class EventOccurrence(NamedTuple):
    """An instant at which declared events happened.

    Args:
        time_s: when (s).
        name: the topic of the message, or the signals that changed; as `text` where only time went by.
        text: the same with values, for people; where only time went by, the conditions that became true.
        numbers: of the conditions that are true with it.
    """

    time_s: float
    name: str
    text: str
    numbers: tuple[int, ...]


class Events:
    """Evaluates conditions at each message, in their order, and at each instant at which signals change.

    For a requirement, all updates with one time stamp are one instant, and of several messages of a topic the last one
    counts. Here each message is an instant of its own: a controller that reports three states without time passing has
    been in three states. Changes of signals with one time stamp are one instant still.

    Args:
        conditions: formulas that are true only at isolated instants (`analysis.is_instantaneous`).
        names: further signals whose values are needed.
    """

    def __init__(self, conditions: Iterable[PastFormula], names: Iterable[str] = ()) -> None:
        formulas = tuple(conditions)
        self._texts = tuple(map(str, formulas))
        self._monitors = MonitorSet()
        for number, condition in enumerate(formulas):
            self._monitors.watch(condition, partial(self._differs, number))
        self.topics = topics_of(formulas)
        """The topics whose messages are read."""
        self.signals = frozenset(name for name in (*names_of(formulas), *names) if "." not in name)
        """The signals that are read."""
        self._sources = frozenset().union(*(formula.sources for formula in formulas))
        self.values: dict[str, Value] = {}
        """The last value of each signal, and of each field as `topic.field`."""
        self._numbers: list[tuple[float, int]] = []
        """When conditions became true (s), and which."""
        self._now_s = -math.inf
        self._signals_s = -math.inf
        self._changes: dict[str, Value] = {}
        """Signals that have changed at the instant `_signals_s`, which is not judged yet."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> Iterator[EventOccurrence]:
        """A message of a topic in `topics` has arrived: what has happened up to it."""
        yield from self.advance(time_s)
        self.values.update((f"{topic}.{name}", value) for name, value in fields.items())
        self._monitors.message(self._now_s, topic, fields)
        yield from self._judge(time_s, topic, _message_text(topic, fields))

    def signal(self, time_s: float, name: str, value: Value) -> Iterator[EventOccurrence]:
        """A signal in `signals` has a new value: what has happened before this instant."""
        if time_s > self._signals_s:
            yield from self.advance(time_s)
        self.values[name] = value
        self._signals_s = time_s
        self._monitors.signal(self._now_s, name, value)
        if name in self._sources:
            self._changes[name] = value

    @property
    def has_changes(self) -> bool:
        """Whether signals have changed at an instant that is not judged yet."""
        return bool(self._changes)

    def flush(self) -> Iterator[EventOccurrence]:
        """The events caused by the last changes of signals."""
        if self._changes:
            text = ", ".join(f"{name} = {_value_text(value)}" for name, value in self._changes.items())
            names = " ".join(self._changes)
            self._changes.clear()
            yield from self._judge(self._signals_s, names, text)

    def advance(self, time_s: float) -> Iterator[EventOccurrence]:
        """Time has reached `time_s`: what has happened before, also what only takes time.

        `rise(historically[0:2](near))` becomes true when somebody was near for 2 s, whatever else is going on then.
        """
        yield from self.flush()
        # The monitors' clock is ahead by the instants that were kept apart, and may not go back.
        self._now_s = max(time_s, self._now_s)
        self._monitors.advance(self._now_s)
        due = sorted(self._numbers)
        self._numbers.clear()
        for began_s, changes in groupby(due, key=itemgetter(0)):
            numbers = tuple(number for _, number in changes)
            text = ", ".join(self._texts[number] for number in numbers)
            yield EventOccurrence(began_s, text, text, numbers)

    def _judge(self, time_s: float, name: str, text: str) -> Iterator[EventOccurrence]:
        self._now_s += ORDER_S
        self._monitors.advance(self._now_s)
        if self._numbers:
            yield EventOccurrence(time_s, name, text, tuple(sorted(number for _, number in self._numbers)))
            self._numbers.clear()

    def _differs(self, number: int, time_s: float, holds: bool) -> None:
        if holds:
            self._numbers.append((time_s, number))


def _message_text(topic: str, fields: Mapping[str, Value]) -> str:
    values = ", ".join(f"{name}={_value_text(value)}" for name, value in fields.items())
    return f"{topic}({values})" if fields else topic


def _value_text(value: Value) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value) if isinstance(value, bool) else f"{value:g}"
