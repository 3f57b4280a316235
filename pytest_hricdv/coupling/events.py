"""Finds declared events in a run, such as `on(request)`, and the literals that an agent gets for them.

`parse_heard` makes an `EventPattern` of each `PerceptMapping`, and `parse_event` of other declarations. `Events` finds
them in a run's messages and signals, for interactive agents and the oracle (`ConformanceMonitor`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

from pytest_hricdv._base.message import nearest
from pytest_hricdv.bdi import Structure, Term, Variable
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.logic.substitution import substitute_only
from pytest_hricdv.coupling.agent_names import AgentNames, term_of
from pytest_hricdv.coupling.percept_mapping import PERCEPT, CouplingError, PerceptMapping
from pytest_hricdv.monitor import FormulaSource, MonitorSet, PastFormula, Value, Vocabulary, parse_condition
from pytest_hricdv.monitor.analysis import names_of, topics_of

Bindings = dict[Variable, Term]  # variable of an event's literal -> its value


@dataclass(frozen=True)
class EventPattern:
    """A pattern of a literal, and the condition that fills in its variables.

    Args:
        owner: names the declaration in errors.
        pattern: the literal; None for a plan's label.
        condition: when it happens.
        sources: variable -> the signal or `topic.field` that it stands for.
    """

    owner: str
    pattern: Structure | None
    condition: PastFormula
    sources: Mapping[Variable, str]

    def bindings(self, values: Mapping[str, Value]) -> Bindings:
        """The values of the variables, by the last values of signals and fields.

        Raises:
            CouplingError: a signal has no value yet.
        """
        if unknown := [name for name in self.sources.values() if name not in values]:
            raise CouplingError(f"{self.owner}: {unknown[0]} has no value yet; signals need one from the start")
        return {variable: term_of(values[name]) for variable, name in self.sources.items()}

    def literal(self, bindings: Bindings) -> Structure:
        """The pattern with its variables replaced."""
        literal = None if self.pattern is None else substitute_only(self.pattern, bindings)
        assert isinstance(literal, Structure), self.owner
        return literal


def parse_event(owner: str, pattern: Structure | None, when: str, vocabulary: Vocabulary) -> EventPattern:
    """The event that a declaration means.

    Raises:
        CouplingError: a variable of the literal that nothing in the run is called after.
        RequirementError: the condition does not parse, or holds for a time.
    """
    source = FormulaSource(when, owner=owner)
    condition = parse_condition(when, vocabulary, source)
    if not condition.is_instantaneous:
        advice = "it holds for a time; name the event: on(topic) & ..., rise(...), or fall(...)"
        raise source.error(0, len(when), "expected an event", advice)
    return EventPattern(owner, pattern, condition, _sources(owner, pattern, condition, vocabulary))


def parse_heard(
    declared: Iterable[PerceptMapping], names: AgentNames, others: Iterable[str], vocabulary: Vocabulary
) -> tuple[EventPattern, ...]:
    """The events that an agent hears.

    Args:
        declared: what it hears.
        others: the other agents of the model.
        vocabulary: signals and messages.

    Raises:
        CouplingError: a literal or a source that the model does not have, or as `parse_event`.
        RequirementError: as `parse_event`.
    """
    declared, others = tuple(declared), tuple(others)
    for hears in declared:
        if hears.source != PERCEPT and hears.source not in others:
            raise CouplingError(f"{hears.owner}: no agent {hears.source!r}{nearest(hears.source, others)}")
    return tuple(
        parse_event(hears.owner, names.literal_of_percept(hears), hears.when, vocabulary) for hears in declared
    )


def _sources(
    owner: str, pattern: Structure | None, condition: PastFormula, vocabulary: Vocabulary
) -> dict[Variable, str]:
    fields = {
        field: f"{topic}.{field}" for topic in sorted(topics_of([condition])) for field in vocabulary.messages[topic]
    }
    # A field of the event's own message comes before a signal of the same name.
    sources = {name: name for name in vocabulary.signals} | fields
    bound: dict[Variable, str] = {}
    for variable in sorted(variables_of(pattern)) if pattern is not None else ():
        name = variable[:1].lower() + variable[1:]
        if name not in sources:
            raise CouplingError(
                f"{owner}: {variable} is neither a field of its message nor a signal{nearest(name, sources)}"
            )
        bound[variable] = sources[name]
    return bound


ORDER_S = 1e-9
"""Events with one time stamp are kept apart by this much: the resolution of the monitors."""


class EventOccurrence(NamedTuple):
    """An instant at which declared events happened.

    Args:
        name: the topic of the message, or the signals that changed; as `text` where only time went by.
        text: the same with values, for people; where only time went by, the conditions that became true.
        numbers: the numbers of the conditions that are true with it.
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

        `rise(historically[0:2](near))` becomes true when somebody was near for 2 s, whatever else happens then.
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
