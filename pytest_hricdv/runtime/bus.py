"""A typed message bus in virtual time, and the record of a run.

The class of a message is its topic, so that types are checked. The record has all messages, all changes of signals and
all disturbances with their simulated times, and a hash over them.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import re
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from pytest_hricdv.runtime.kernel import Kernel, Node

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

Value = float | bool | int | str

M = TypeVar("M")


class Listener(Protocol):
    """Receives each event during the run; the monitors are listeners."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None: ...

    def signal(self, time_s: float, name: str, value: float | bool | str) -> None: ...


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """One message, or one disturbance: its time (s), sender, topic and fields."""

    time_s: float
    sender: str
    topic: str
    fields: Mapping[str, Value]

    @property
    def is_disturbance(self) -> bool:
        """Whether it is a disturbance, such as "disturb outage" or "lost request". Topics of messages are one word."""
        return " " in self.topic

    def __str__(self) -> str:
        values = " ".join(f"{name}={value}" for name, value in self.fields.items())
        return f"{self.time_s:9.3f} {self.sender:>8} {self.topic} {values}".rstrip()


@dataclass(frozen=True)
class Record:
    """The events of a run. `signals` maps a name to its changes (times in s, values); `texts` those that are strings.

    `messages` has the disturbances, too, in the order of time (see `RecordedMessage.is_disturbance`).
    `sha256` is over all messages and signals, bit by bit: equal hashes mean equal runs.
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

    def message(self, time_s: float, sender: str, topic: str, fields: Mapping[str, Value]) -> None:
        """Record one message."""
        self.messages.append(RecordedMessage(time_s, sender, topic, fields))
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

        Raises:
            ValueError: the value is NaN or infinite (an error of the world, which no monitor may judge as passed), or
                a text for a signal that had numbers, or the other way round.
        """
        if self._last.get(name) == value and name in self._last:
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

    def _require_new(self, time_s: float, name: str, value: float | bool | str) -> None:
        if name in self._last:
            before = f"and was {self._last[name]!r} before"
            raise ValueError(f"signal {name} is {value!r} at {time_s:.6f} s, {before}: expected values of one type")

    def finish(self) -> Record:
        """The finished record."""
        digest = hashlib.sha256()
        for message in self.messages:
            line = [message.time_s, message.sender, message.topic, dict(message.fields)]
            digest.update(json.dumps(line, sort_keys=True).encode())
        for name in sorted(self._signals):
            times, values = self._signals[name]
            digest.update(name.encode() + times.tobytes() + values.tobytes())
        for name in sorted(self._texts):
            times, texts = self._texts[name]
            digest.update(name.encode() + times.tobytes() + json.dumps(texts).encode())
        return Record(tuple(self.messages), dict(self._signals), digest.hexdigest(), dict(self._texts))


def topic_of(kind: type[object]) -> str:
    """The topic's name: the class name in snake case (`HumanReady` -> `human_ready`)."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", kind.__name__).lower()


def text_of(member: Enum) -> str:
    """How a member of an enumeration is recorded: by its value if this is a text, else by its name."""
    return member.value if isinstance(member.value, str) else member.name


class Subscription(Generic[M]):
    """A queue of the messages of one topic since the subscription began (or since `clear`)."""

    def __init__(self, bus: Bus, kind: type[M]) -> None:
        self._bus = bus
        self._kind = kind
        self._queue: deque[M] = deque()
        self._waiting: Node | None = None

    def poll(self) -> M | None:
        """The oldest message not yet taken, or None; never blocks. `Kernel.count_poll` detects endless polling."""
        self._bus.kernel.count_poll()
        return self._queue.popleft() if self._queue else None

    def wait(self, timeout_s: float) -> M | None:
        """Block until there is a message, at most `timeout_s`; None on time-out."""
        if not self._queue:
            self._waiting = self._bus.kernel.current()
            self._bus.kernel.block(timeout_s)
            self._waiting = None
        return self.poll()

    def clear(self) -> None:
        """Discard the messages so far."""
        self._queue.clear()

    def close(self) -> None:
        """End the subscription."""
        self._bus.unsubscribe(self._kind, self)

    def deliver(self, message: M) -> None:
        """Add a message to the queue; called by the bus."""
        self._queue.append(message)
        if self._waiting is not None:
            self._bus.kernel.wake(self._waiting)


@dataclass(frozen=True)
class MessageFault:
    """What happens to a message instead of its delivery: one copy is delivered at each delay (s) after publication.

    The record calls it by its name: "lost" (no delay), "late" (one delay), "doubled" (two).
    """

    name: str
    delays_s: tuple[float, ...] = ()


class Bus:
    """Delivers frozen dataclass messages to all subscribers at the instant of publication, and records them.

    Args:
        kernel: its clock gives the time stamps.
        kinds: the message classes of this bus; others are refused.
        recorder: records the messages.
        by_code: whether the caller is the code under test.
    """

    def __init__(
        self,
        kernel: Kernel,
        kinds: Iterable[type[Any]],
        recorder: Recorder,
        by_code: Callable[[], bool] = lambda: False,
    ) -> None:
        self.kernel = kernel
        self.recorder = recorder
        self._by_code = by_code
        self._faults: dict[str, deque[MessageFault]] = {}
        self._fields = {kind: tuple(f.name for f in dataclasses.fields(kind)) for kind in kinds}
        self._subscriptions: dict[type[Any], list[Subscription[Any]]] = {kind: [] for kind in self._fields}
        self._waiting_publishers: dict[type[Any], list[Node]] = {kind: [] for kind in self._fields}

    def port(self, sender: str) -> NodeBus:
        """The bus bound to one sender."""
        return NodeBus(self, sender)

    def subscribe(self, kind: type[M]) -> Subscription[M]:
        """Subscribe to one kind of message. Raises TypeError for a kind that was not declared."""
        subscription = Subscription(self, self._declared(kind))
        self._subscriptions[kind].append(subscription)
        waiting, self._waiting_publishers[kind] = self._waiting_publishers[kind], []
        for node in waiting:
            self.kernel.wake(node)
        return subscription

    def has_subscribers(self, kind: type[Any]) -> bool:
        """Whether there is a subscriber; without one, a publisher need not publish."""
        return bool(self._subscriptions[self._declared(kind)])

    def wait_for_subscriber(self, kind: type[Any]) -> None:
        """Block the calling node until `kind` has a subscriber; returns at once if it has one."""
        while not self.has_subscribers(kind):
            self._waiting_publishers[kind].append(self.kernel.current())
            self.kernel.block()

    def publish(self, sender: str, message: object) -> None:
        """Deliver and record a message, unless a fault awaits it. Raises TypeError for a kind that was not declared."""
        kind = self._declared(type(message))
        fields: dict[str, Value] = {}
        for name in self._fields[kind]:
            value = getattr(message, name)
            fields[name] = text_of(value) if isinstance(value, Enum) else value
        self.kernel.last_messages[sender] = message
        faults = self._faults.get(topic_of(kind)) if self._faults else None
        if faults:
            self._publish_with_fault(faults.popleft(), sender, message, fields)
            return
        self.recorder.message(self.kernel.now_s, sender, topic_of(kind), fields)
        self._deliver(message)

    def disturb(self, topic: str, fault: MessageFault) -> None:
        """Let a fault happen to the next message of a topic; several faults await one message each, in order.

        The record has the message when the code under test could know of it: a message of the code when it is
        published, any other one when it is delivered, each copy of it.
        """
        self._faults.setdefault(topic, deque()).append(fault)

    def _publish_with_fault(
        self, fault: MessageFault, sender: str, message: object, fields: Mapping[str, Value]
    ) -> None:
        topic, by_code = topic_of(type(message)), self._by_code()
        self.recorder.disturbance(self.kernel.now_s, sender, f"{fault.name} {topic}", fields)
        if by_code:
            self.recorder.message(self.kernel.now_s, sender, topic, fields)

        def deliver_after(delay_s: float) -> None:
            if delay_s:
                self.kernel.sleep(delay_s)
            if not by_code:
                self.recorder.message(self.kernel.now_s, sender, topic, fields)
            self._deliver(message)

        for delay_s in fault.delays_s:
            if delay_s:
                self.kernel.spawn(f"{fault.name} {topic}", partial(deliver_after, delay_s))
            else:
                deliver_after(delay_s)

    def _deliver(self, message: object) -> None:
        for subscription in tuple(self._subscriptions[type(message)]):
            subscription.deliver(message)

    def unsubscribe(self, kind: type[Any], subscription: Subscription[Any]) -> None:
        """Remove a subscription; called by `Subscription.close`."""
        if subscription in self._subscriptions[kind]:
            self._subscriptions[kind].remove(subscription)

    def _declared(self, kind: type[M]) -> type[M]:
        if kind not in self._fields:
            known = ", ".join(sorted(k.__name__ for k in self._fields))
            raise TypeError(f"{kind.__name__} is not a message of this bus; declared: {known}")
        return kind


class NodeBus:
    """The bus bound to one sender."""

    def __init__(self, bus: Bus, sender: str) -> None:
        self._bus = bus
        self.sender = sender

    def publish(self, message: object) -> None:
        """Publish a message as this sender."""
        self._bus.publish(self.sender, message)

    def subscribe(self, kind: type[M]) -> Subscription[M]:
        """Subscribe to one kind of message."""
        return self._bus.subscribe(kind)

    def has_subscribers(self, kind: type[Any]) -> bool:
        """Whether this kind has a subscriber."""
        return self._bus.has_subscribers(kind)

    def wait_for_subscriber(self, kind: type[Any]) -> None:
        """Block the calling node until this kind has a subscriber."""
        self._bus.wait_for_subscriber(kind)
