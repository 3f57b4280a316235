"""The `Record` of a run: messages, changes of signals, and disturbances, with their times and a hash.

The run's `Recorder` makes it: it gets messages from the bus, and passes messages and signals to its `Listener`s, the
monitors. Values are Python's own bools, numbers and strings, also if a library such as numpy computed them.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from hashlib import sha256
from typing import Protocol

from pytest_hricdv._base import own_json as json

Value = float | bool | int | str
"""The type of a message's field or a signal's value in a record."""

_PLAIN = (bool, int, float, str)


def plain(value: object) -> Value | None:
    """The value as Python's own bool, number or string, also for a numpy scalar or 0-dimensional array; else None."""
    if isinstance(value, _PLAIN):
        return value
    item = getattr(value, "item", None)
    scalar = item() if callable(item) and getattr(value, "shape", None) == () else None
    return scalar if isinstance(scalar, _PLAIN) else None


def text_of(member: Enum) -> str:
    """How an enum member is recorded: by its value if this is a string, else by its name."""
    return member.value if isinstance(member.value, str) else member.name


__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class Listener(Protocol):
    """Receives each message and change of a signal during the run, from the `Recorder`; the monitors are listeners."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None: ...

    def signal(self, time_s: float, name: str, value: float | bool | str) -> None: ...


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """One message, or one disturbance: its time (s), sender, topic and fields.

    `source` is the object that the fields were read from, if it holds more, such as a ROS 2 message.
    """

    time_s: float
    sender: str
    topic: str
    fields: Mapping[str, Value]
    source: object = field(default=None, compare=False, repr=False)

    @property
    def is_disturbance(self) -> bool:
        """Whether it is a disturbance, such as "disturb outage" or "lost request". Topics are one word."""
        return " " in self.topic

    def __str__(self) -> str:
        values = " ".join(f"{name}={value}" for name, value in self.fields.items())
        return f"{self.time_s:9.3f} {self.sender:>8} {self.topic} {values}".rstrip()


@dataclass(frozen=True)
class Record:
    """The events of a run. `signals` maps a name to its changes (times in s, values); `texts` does so for strings.

    `messages` includes disturbances, in the order of time (see `RecordedMessage.is_disturbance`).
    `sha256` is over all messages and signals, bit for bit: equal hashes mean equal runs.
    """

    messages: tuple[RecordedMessage, ...]
    signals: Mapping[str, tuple[array[float], array[float]]]
    sha256: str
    texts: Mapping[str, tuple[array[float], list[str]]] = field(default_factory=dict)


@dataclass
class Recorder:
    """Records a run, and passes each event to the listeners at once."""

    listeners: list[Listener] = field(default_factory=list)
    messages: list[RecordedMessage] = field(default_factory=list)
    _signals: dict[str, tuple[array[float], array[float]]] = field(default_factory=dict)
    _texts: dict[str, tuple[array[float], list[str]]] = field(default_factory=dict)
    _last: dict[str, float | bool | str] = field(default_factory=dict)

    def message(
        self, time_s: float, sender: str, topic: str, fields: Mapping[str, Value], source: object = None
    ) -> None:
        """Record one message; for `source` see `RecordedMessage`."""
        self.messages.append(RecordedMessage(time_s, sender, topic, fields, source))
        for listener in self.listeners:
            listener.message(time_s, topic, fields)

    def disturbance(self, time_s: float, sender: str, event: str, fields: Mapping[str, Value]) -> None:
        """Record a disturbance, such as "lost request". Listeners do not hear of it: no requirement may depend on it.

        Raises:
            ValueError: the event is one word, which would be taken for a message.
        """
        event_message = RecordedMessage(time_s, sender, event, fields)
        if not event_message.is_disturbance:
            raise ValueError(f"disturbance {event!r}: expected at least two words")
        self.messages.append(event_message)

    def signal(self, time_s: float, name: str, value: float | bool | str) -> None:
        """Record a signal's value from `time_s` on; an unchanged value is not recorded again.

        A numpy scalar is recorded as Python's own number or bool.

        Raises:
            TypeError: the value is not a number, bool or string.
            ValueError: the value is NaN or infinite (an error of the world, which no monitor may judge as passed), or
                a string for a signal that had numbers, or vice versa.
        """
        plain_value = plain(value)
        if plain_value is None:
            raise TypeError(f"signal {name} is {value!r} at {time_s:.6f} s: expected a number, a bool or a string")
        value = plain_value
        if self._last.get(name) == value and name in self._last:  # as in most updates: this keeps the series short
            return
        if isinstance(value, str):
            self._add_text(time_s, name, value)
        else:
            if not math.isfinite(value):
                raise ValueError(f"signal {name} is {value!r} at {time_s:.6f} s: expected a finite number")
            series = self._signals.get(name)
            if series is None:
                self._require_new(time_s, name, value)
                series = self._signals[name] = (array("d"), array("d"))
            series[0].append(time_s)
            series[1].append(value)
        self._last[name] = value
        for listener in self.listeners:
            listener.signal(time_s, name, value)

    def _add_text(self, time_s: float, name: str, value: str) -> None:
        series = self._texts.get(name)
        if series is None:
            self._require_new(time_s, name, value)
            series = self._texts[name] = (array("d"), [])
        series[0].append(time_s)
        series[1].append(value)

    def changes(self) -> Iterator[tuple[str, Sequence[float], Sequence[float | str]]]:
        """The signals so far: name, times (s) and values of their changes, which grow with the run."""
        yield from ((name, times, values) for name, (times, values) in self._signals.items())
        yield from ((name, times, texts) for name, (times, texts) in self._texts.items())

    def _require_new(self, time_s: float, name: str, value: float | bool | str) -> None:
        if name in self._last:
            before = f"and was {self._last[name]!r} before"
            raise ValueError(f"signal {name} is {value!r} at {time_s:.6f} s, {before}: expected values of one type")

    def finish(self) -> Record:
        """The finished record."""
        digest = sha256()
        for message in self.messages:
            line = [message.time_s, message.sender, message.topic, dict(message.fields)]
            # JSON writes a float with the digits that identify it, so equal texts are equal bits.
            digest.update(json.dumps(line, sort_keys=True).encode())
        # By name: the order in which signals first changed within an instant is not part of the run.
        for name in sorted(self._signals):
            times, values = self._signals[name]
            digest.update(name.encode() + times.tobytes() + values.tobytes())
        for name in sorted(self._texts):
            times, texts = self._texts[name]
            digest.update(name.encode() + times.tobytes() + json.dumps(texts).encode())
        return Record(tuple(self.messages), dict(self._signals), digest.hexdigest(), dict(self._texts))
