"""A typed message bus in virtual time.

A run has one `Bus` (`Run.bus`), which records each message. A node publishes and subscribes through its own `NodeBus`;
a `Subscription` is its queue of messages. The class of a message is its topic, so that types are checked.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from pytest_hricdv.runtime.kernel import Kernel, Node
from pytest_hricdv.runtime.message_fields import fields_of, record_fields
from pytest_hricdv.runtime.record import Recorder, Value

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

M = TypeVar("M")


def topic_of(kind: type[object]) -> str:
    """The topic's name: the class name in snake case (`HumanReady` -> `human_ready`)."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", kind.__name__).lower()


class Subscription(Generic[M]):
    """A queue of the messages of one topic since the subscription began (or since `clear`)."""

    def __init__(self, bus: Bus, kind: type[M]) -> None:
        self._bus = bus
        self._kind = kind
        self._queue: deque[M] = deque()
        self._waiting: Node | None = None
        self.has_outside = False
        """Whether the queue ever had a message that the code under test did not send."""

    def poll(self) -> M | None:
        """The oldest message not yet taken, or None; never blocks. `Kernel.count_poll` detects endless polling."""
        self._bus.kernel.count_poll()
        if not self._queue:
            return None
        if self.has_outside:
            self._bus.note_taking()
        return self._queue.popleft()

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
    """Replaces the delivery of a message: one copy is delivered at each delay (s) after publication.

    The record calls it by its name: "lost" (no delay), "late" (one delay), "doubled" (two).
    """

    name: str
    delays_s: tuple[float, ...] = ()


@dataclass(frozen=True)
class MessageInTransit:
    """A message on its way; see `Bus.carry`."""

    sender: str
    topic: str
    fields: Mapping[str, Value]
    deliver: Callable[[], None]
    is_heard: Callable[[], bool]
    source: object


class Bus:
    """Delivers messages to all subscribers at the instant of publication, and records them.

    Args:
        kernel: its clock gives the time stamps.
        kinds: the message classes of this bus, see `fields_of`; others are refused.
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
        self.senders: dict[str, bool] = {}
        """Sender -> whether it is the code under test."""
        self.notice_taking: Callable[[], None] | None = None
        """Called when a message is taken from a queue that held one from outside the code under test."""
        self.transport: Callable[[str, str], float] | None = None
        """How long a message with this sender and topic is on its way (s); None: no time."""
        self._faults: dict[str, deque[MessageFault]] = {}
        self._fields = {kind: fields_of(kind) or () for kind in kinds}
        self._subscriptions: dict[type[Any], list[Subscription[Any]]] = {kind: [] for kind in self._fields}
        self._waiting_publishers: dict[type[Any], list[Node]] = {kind: [] for kind in self._fields}

    @property
    def topics(self) -> frozenset[str]:
        """The names of the topics of its messages."""
        return frozenset(map(topic_of, self._fields))

    def note_taking(self) -> None:
        """Note that the running node has taken what somebody outside its code may have given."""
        if self.notice_taking is not None:
            self.notice_taking()

    def port(self, sender: str) -> NodeBus:
        """The bus bound to one sender."""
        return NodeBus(self, sender)

    def subscribe(self, kind: type[M]) -> Subscription[M]:
        """Subscribe to one kind of message. Raises TypeError for a kind that was not declared."""
        subscription = Subscription(self, self._require_declared(kind))
        self._subscriptions[kind].append(subscription)
        waiting, self._waiting_publishers[kind] = self._waiting_publishers[kind], []
        for node in waiting:
            self.kernel.wake(node)
        return subscription

    def has_subscribers(self, kind: type[Any]) -> bool:
        """Whether there is a subscriber; without one, a publisher need not publish."""
        return bool(self._subscriptions[self._require_declared(kind)])

    def wait_for_subscriber(self, kind: type[Any]) -> None:
        """Block the calling node until `kind` has a subscriber; returns at once if it has one."""
        while not self.has_subscribers(kind):
            self._waiting_publishers[kind].append(self.kernel.current())
            self.kernel.block()

    def publish(self, sender: str, message: object) -> None:
        """Deliver and record a message, unless a disturbance awaits it. Raises TypeError for an undeclared class."""
        kind = self._require_declared(type(message))
        fields = self._fields_to_record(message)
        self.kernel.last_messages[sender] = message
        deliver, topic = partial(self._deliver, sender, message), topic_of(kind)
        delay_s = 0.0 if self.transport is None else self.transport(sender, topic)
        self.carry(sender, topic, fields, deliver, partial(self.has_subscribers, kind), delay_s=delay_s)

    def carry(
        self,
        sender: str,
        topic: str,
        fields: Mapping[str, Value],
        deliver: Callable[[], None],
        is_heard: Callable[[], bool],
        source: object = None,
        delay_s: float = 0.0,
        is_lost: bool = False,
    ) -> None:
        """Record a message and let it be delivered, unless a disturbance awaits it.

        Args:
            fields: the message's fields, as the record has them.
            deliver: delivers it; called once for each copy that arrives.
            is_heard: whether there is anybody to deliver it to.
            source: what it is, where it is not a message of this bus (see `RecordedMessage`).
            delay_s: time until its delivery (s), unless a disturbance comes in its place; recorded as by `disturb`.
            is_lost: whether it never arrives; recorded as by `disturb`.

        Raises:
            SystemExit: the caller is in another thread than the run (see `Kernel.require_own_thread`).
        """
        self.kernel.require_own_thread(f"{sender} published {topic}")
        if sender not in self.senders:
            self.senders[sender] = self._by_code()
        message = MessageInTransit(sender, topic, fields, deliver, is_heard, source)
        faults = self._faults.get(topic) if self._faults else None
        if faults:
            self._carry_with_fault(faults.popleft(), message)
        elif is_lost:
            self._carry_with_fault(MessageFault("lost"), message)
        elif delay_s:
            self._carry_later(message, delay_s)
        else:
            self._record(message)
            deliver()

    def _carry_later(self, message: MessageInTransit, delay_s: float) -> None:
        by_code = self._by_code()
        if by_code:
            self._record(message)

        def arrive() -> None:
            self.kernel.sleep(delay_s)
            if not by_code:
                self._record(message)
            message.deliver()

        self.kernel.spawn(f"{message.topic} on its way", arrive)

    def _record(self, message: MessageInTransit) -> None:
        self.recorder.message(self.kernel.now_s, message.sender, message.topic, message.fields, message.source)

    def _fields_to_record(self, message: object) -> dict[str, Value]:
        """The fields of a message as the record has them."""
        try:
            return record_fields(message, self._fields[type(message)])
        except TypeError as error:
            where = f"message {type(message).__name__} at {self.kernel.now_s:.6f} s"
            raise TypeError(f"{where}: {error}") from None

    def disturb(self, topic: str, fault: MessageFault) -> None:
        """Disturb the next message of a topic; several disturbances await one message each, in order.

        The record has the message when the code under test could know of it: a message of the code when it is
        published, any other one when it is delivered, each copy of it. A late copy without a listener is recorded as
        unheard: the code under test owes it no answer.
        """
        self._faults.setdefault(topic, deque()).append(fault)

    def _carry_with_fault(self, fault: MessageFault, message: MessageInTransit) -> None:
        # Ask now: a late copy is delivered by a separate node, which hides the caller.
        by_code = self._by_code()
        self._record_disturbance(f"{fault.name} {message.topic}", message)
        if by_code:
            self._record(message)

        def deliver_after(delay_s: float) -> None:
            if delay_s:
                self.kernel.sleep(delay_s)
            if delay_s and not message.is_heard():
                self._record_disturbance(f"unheard {message.topic}", message)
                return
            if not by_code:
                self._record(message)
            message.deliver()

        for delay_s in fault.delays_s:
            if delay_s:
                self.kernel.spawn(f"{fault.name} {message.topic}", partial(deliver_after, delay_s))
            else:
                deliver_after(delay_s)

    def _record_disturbance(self, event: str, message: MessageInTransit) -> None:
        self.recorder.disturbance(self.kernel.now_s, message.sender, event, message.fields)

    def _deliver(self, sender: str, message: object) -> None:
        is_outside = not self.senders[sender]
        for subscription in tuple(self._subscriptions[type(message)]):
            subscription.has_outside |= is_outside
            subscription.deliver(message)

    def unsubscribe(self, kind: type[Any], subscription: Subscription[Any]) -> None:
        """Remove a subscription; called by `Subscription.close`."""
        if subscription in self._subscriptions[kind]:
            self._subscriptions[kind].remove(subscription)

    def _require_declared(self, kind: type[M]) -> type[M]:
        if kind not in self._fields:
            declared = ", ".join(sorted(k.__name__ for k in self._fields))
            raise TypeError(f"{kind.__name__} is not a message of this bus; declared: {declared}")
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
