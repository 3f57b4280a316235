"""The queue of events that have happened in a run and that an agent has not perceived yet."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pytest_hricdv.bdi import Structure
from pytest_hricdv.coupling.events import EventOccurrence, Events
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.monitor import Value
from pytest_hricdv.online.role import Role


class HeardEvent(NamedTuple):
    """Something that has happened: when (s), what the agent hears, who says so, and whether it is a goal."""

    time_s: float
    literal: Structure
    source: str
    is_goal: bool


class EventInbox:
    """Collects what one agent is to hear, up to when it listens.

    Args:
        role: of the agent.
    """

    def __init__(self, role: Role) -> None:
        self._role = role
        self._events = Events(
            [event.condition for event in role.percepts],
            [name for event in role.percepts for name in event.sources.values()],
        )
        self._heard: deque[HeardEvent] = deque()
        self._error: CouplingError | None = None
        """Raised when the agent listens, not when it occurs: then it would look like an error of the running node."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        if topic in self._events.topics:
            self._note(self._events.message(time_s, topic, fields))

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        if name in self._events.signals:
            self._note(self._events.signal(time_s, name, value))

    @property
    def has_news(self) -> bool:
        """Whether there may be something to listen to."""
        return bool(self._heard or self._error) or self._events.has_changes

    def listen(self) -> Iterable[HeardEvent]:
        """All events since the agent listened last, in order.

        Raises:
            CouplingError: a part of an event has no value yet.
        """
        # Signals change at instants that are judged when the next one begins: the last one would wait for ever.
        self._note(self._events.flush())
        if self._error is not None:
            raise self._error
        heard, self._heard = self._heard, deque()
        return heard

    def _note(self, occurrences: Iterable[EventOccurrence]) -> None:
        for occurrence in occurrences:
            for number in occurrence.numbers:
                event, declared = self._role.percepts[number], self._role.declaration.percepts[number]
                try:
                    literal = event.literal(event.bindings(self._events.values))
                except CouplingError as error:
                    self._error = self._error or error
                else:
                    self._heard.append(HeardEvent(occurrence.time_s, literal, declared.source, declared.is_goal))
