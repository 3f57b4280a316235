"""`Log`: the signals and messages of a finished run, for `evaluate`, `explain` and `watch`, instant by instant."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import Protocol

from pytest_hricdv.monitor.evaluation_state import Nanoseconds, Value, nanoseconds

Series = tuple[Sequence[float], Sequence[float] | Sequence[str]]
"""The times (s) at which a signal changes, and its value from each time on."""
Update = tuple[str, "Value | Mapping[str, object]"]
"""A signal and its new value, or a topic and the fields of a message."""


class LogMessage(Protocol):
    """One message of a log."""

    @property
    def time_s(self) -> float: ...

    @property
    def topic(self) -> str: ...

    @property
    def fields(self) -> Mapping[str, object]: ...


@dataclass(frozen=True)
class Log:
    """A logged run; of a recorded run: `Log({**record.signals, **record.texts}, record.messages, end_s)`.

    Attributes:
        signals: name -> times (s, not decreasing), and the value from each time on; a bool may be written 0.0 or 1.0.
        messages: the messages, in the order of time.
        end_s: when the run ended (s).
    """

    signals: Mapping[str, Series]
    messages: Sequence[LogMessage]
    end_s: float

    @property
    def start_s(self) -> float:
        """When the run began: the time of its first update (s)."""
        firsts = [times[0] for times, _ in self.signals.values() if len(times)]
        firsts += [message.time_s for message in self.messages[:1]]
        return min(firsts, default=self.end_s)

    @property
    def end_ns(self) -> Nanoseconds:
        """When the run ended (ns)."""
        return nanoseconds(self.end_s)

    def instants(self, names: Iterable[str], topics: Iterable[str]) -> Iterator[tuple[Nanoseconds, list[Update]]]:
        """The instants in the order of time, with their updates: (signal, value) or (topic, fields of the message).

        The first and the last instant of the run are always included, with or without an update.
        """
        wanted = frozenset(topics)
        streams: list[Iterable[tuple[Nanoseconds, Update]]] = [
            [(nanoseconds(self.start_s), ("", {})), (self.end_ns, ("", {}))],
            (
                (nanoseconds(message.time_s), (message.topic, message.fields))
                for message in self.messages
                if message.topic in wanted
            ),
        ]
        for name in names:
            times, values = self.signals.get(name, ((), ()))
            streams.append(_updates(name, times, values))
        # Merged as they are read: a log of a long run is not copied as a whole.
        merged = heapq.merge(*streams, key=itemgetter(0))
        for now_ns, group in groupby(merged, key=itemgetter(0)):
            yield now_ns, [update for _, update in group if update[0]]


def _updates(name: str, times: Sequence[float], values: Sequence[Value]) -> Iterator[tuple[Nanoseconds, Update]]:
    for time_s, value in zip(times, values, strict=True):
        yield nanoseconds(time_s), (name, value)
