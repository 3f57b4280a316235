"""The record of a run: all messages and all changes of signals with their simulated times, and a hash over them."""

from __future__ import annotations

import hashlib
import json
import math
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

Value = float | bool | int | str

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class Listener(Protocol):
    """Receives each event during the run; the monitors are listeners."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None: ...

    def signal(self, time_s: float, name: str, value: float | bool) -> None: ...


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """One message: its time (s), sender, topic and fields."""

    time_s: float
    sender: str
    topic: str
    fields: Mapping[str, Value]

    def __str__(self) -> str:
        values = " ".join(f"{name}={value}" for name, value in self.fields.items())
        return f"{self.time_s:9.3f} {self.sender:>8} {self.topic} {values}".rstrip()


@dataclass(frozen=True)
class Record:
    """The events of a run. `signals` maps a name to its changes (times in s, values).

    `sha256` is over all messages and signals, bit by bit: equal hashes mean equal runs.
    """

    messages: tuple[RecordedMessage, ...]
    signals: Mapping[str, tuple[array[float], array[float]]]
    sha256: str


@dataclass
class Recorder:
    """Records a run, and passes each event to the listeners at once."""

    listeners: list[Listener] = field(default_factory=list)
    messages: list[RecordedMessage] = field(default_factory=list)
    _signals: dict[str, tuple[array[float], array[float]]] = field(default_factory=dict)
    _last: dict[str, float | bool] = field(default_factory=dict)

    def message(self, time_s: float, sender: str, topic: str, fields: Mapping[str, Value]) -> None:
        """Record one message."""
        self.messages.append(RecordedMessage(time_s, sender, topic, fields))
        for listener in self.listeners:
            listener.message(time_s, topic, fields)

    def signal(self, time_s: float, name: str, value: float | bool) -> None:
        """Record a signal's value from `time_s` on; an unchanged value is not recorded again.

        Raises:
            ValueError: the value is NaN or infinite (an error of the world, which no monitor may judge as passed).
        """
        if self._last.get(name) == value and name in self._last:
            return
        if not math.isfinite(value):
            raise ValueError(f"signal {name} is {value!r} at {time_s:.6f} s: expected a finite number")
        self._last[name] = value
        series = self._signals.get(name)
        if series is None:
            series = self._signals[name] = (array("d"), array("d"))
        series[0].append(time_s)
        series[1].append(value)
        for listener in self.listeners:
            listener.signal(time_s, name, value)

    def finish(self) -> Record:
        """The finished record."""
        digest = hashlib.sha256()
        for message in self.messages:
            line = [message.time_s, message.sender, message.topic, dict(message.fields)]
            digest.update(json.dumps(line, sort_keys=True).encode())
        for name in sorted(self._signals):
            times, values = self._signals[name]
            digest.update(name.encode() + times.tobytes() + values.tobytes())
        return Record(tuple(self.messages), dict(self._signals), digest.hexdigest())
