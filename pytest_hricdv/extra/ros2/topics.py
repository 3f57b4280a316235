"""Simulates the publishers (`Publisher`) and subscriptions (`TopicSubscription`) of `rclpy`.

`extension` gives them to `rclpy`; services, actions and the simulated world use them, too. A message arrives at the
instant at which it is published, as a copy, unless the testbench declares delays (`delivery`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from functools import partial
from typing import Any, NoReturn

from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.events import EndpointEvents, Lease
from pytest_hricdv.extra.ros2.graph import GraphEntity, note
from pytest_hricdv.extra.ros2.handles import QueueHandle, RCLError
from pytest_hricdv.extra.ros2.messages import copy_message, deserialize, serialize, type_name
from pytest_hricdv.extra.ros2.qos import BEST_EFFORT, Profile, effective, last_policy, mismatches, policies_text

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class _TopicEndpoint(GraphEntity):
    """The base of publishers and subscriptions."""

    node: GraphNode
    profile: Profile
    events: EndpointEvents
    last_ns: int | None = None
    """The time of the last message sent or received, in the kernel's time (ns)."""

    def _admit(self) -> None:
        """Check that the topic has no other type.

        Raises:
            InputError: the testbench declares another type, or another process uses one.
            RCLError: the same process uses another type.
        """
        self.node.admit(self.full_name, self.kind)
        graph, own = self.node.graph, type_name(self.kind)
        for endpoint in (*graph.publishers.get(self.full_name, ()), *graph.subscriptions.get(self.full_name, ())):
            if endpoint.node.context is self.node.context and type_name(endpoint.kind) != own:
                raise RCLError(
                    f"Failed to create {type(self).__name__.lower()}: existing topic name {self.full_name} with "
                    f"incompatible type {type_name(endpoint.kind)}, not {own}"
                )

    def get_topic_name(self) -> str:
        return self.full_name

    def matches(self, subscription: TopicSubscription) -> bool:
        """Whether messages of this publisher reach it."""
        same_type = type_name(self.kind) == type_name(subscription.kind)
        return same_type and not mismatches(self.profile, subscription.profile)


def _match(publisher: Publisher, subscription: TopicSubscription) -> None:
    """Count an event at both ends, which match or do not; to be called when one of them is new."""
    same_type = type_name(publisher.kind) == type_name(subscription.kind)
    faults = mismatches(publisher.profile, subscription.profile)
    for endpoint in (publisher, subscription):
        if not same_type:
            endpoint.events.differ()
        elif faults:
            endpoint.events.mismatch(last_policy(publisher.profile, subscription.profile))
        else:
            endpoint.events.match(1)
    if same_type and faults:
        note(publisher.kernel, _mismatch(publisher, subscription))


def _mismatch(publisher: Publisher, subscription: TopicSubscription) -> str:
    """Note a mismatch for the report: otherwise only those who wait for the event learn of it."""
    ends = f"{publisher.node.get_fully_qualified_name()} to {subscription.node.get_fully_qualified_name()}"
    policies = policies_text(publisher.profile, subscription.profile)
    return f"{publisher.full_name}: no message goes from {ends}, their qualities of service do not match ({policies})"


class Publisher(_TopicEndpoint):
    """Like `rcl_publisher_t`. Raises ValueError for a wrong topic."""

    def __init__(self, node: GraphNode, kind: type[Any], topic: str, profile: Profile) -> None:
        super().__init__(node.kernel)
        self.node, self.kind, self.full_name, self.profile = node, kind, node.resolve(topic), effective(profile)
        self._admit()
        self.events = EndpointEvents()
        self.lease = Lease(self)
        self._published = 0
        self._kept: deque[tuple[Any, dict[str, Any]]] = deque(maxlen=self.profile.queue_length)
        self._join(node.graph.publishers)
        for subscription in node.graph.subscriptions.get(self.full_name, ()):
            _match(self, subscription)

    def _on_leave(self) -> None:
        for subscription in self.subscriptions():
            subscription.events.match(-1, self.lease.is_alive)

    def leases(self) -> list[Lease]:
        return [self.lease]

    def assert_liveliness(self) -> None:
        """Say that it is alive, without a message."""
        self.lease.renew()

    def subscriptions(self) -> list[TopicSubscription]:
        """The subscriptions that it reaches."""
        subscriptions = self.node.graph.subscriptions.get(self.full_name, ())
        return [subscription for subscription in subscriptions if self.matches(subscription)]

    def get_subscription_count(self) -> int:
        """The number of subscriptions that its messages reach."""
        return len(self.subscriptions())

    def publish(self, message: Any) -> None:
        """Deliver a copy to each subscription that matches.

        Raises:
            TypeError: a message of another type.
            RCLError: the context is shut down.
        """
        self.node.context.require_valid(f"publish on {self.full_name}")
        if not isinstance(message, self.kind):
            raise TypeError(f"{self.full_name}: expected a {type_name(self.kind)}, not {message!r}")
        self._published += 1
        self.last_ns = self.kernel.now_us * 1000
        self.lease.renew()
        stamp_ns = system_ns(self.kernel)
        info = {
            "source_timestamp": stamp_ns,
            "publication_sequence_number": self._published,
            "publisher_gid": {
                "implementation_identifier": "pytest_hricdv",
                "data": self.pointer.to_bytes(16, "big"),
            },
        }
        carrier = self.node.graph.carrier
        if carrier is None:
            self._deliver(message, info)
            return
        # A copy now, for the record, and one for each subscription: senders and callbacks change what they have.
        sent, sender = copy_message(message), self.node.get_fully_qualified_name()
        deliver = partial(self._deliver, sent, info)
        carrier.carry(sender, self.full_name, "", sent, deliver, self._is_heard, self._reliable)

    def _reliable(self) -> str:
        """The receivers to whom its messages are delivered reliably, in words; empty if there are none."""
        if self.profile.reliability == BEST_EFFORT:
            return ""
        readers = [other for other in self.subscriptions() if other.profile.reliability != BEST_EFFORT]
        names = [end.node.get_fully_qualified_name() for end in (self, *readers[:1])]
        return f"{names[0]} publishes and {names[1]} subscribes reliably" if readers else ""

    def _deliver(self, message: Any, info: dict[str, Any]) -> None:
        if self.profile.is_transient_local:
            self._kept.append((copy_message(message), info))
        for subscription in self.subscriptions():
            subscription.deliver(copy_message(message), info, self.profile.finite_lifespan_ns)

    def _is_heard(self) -> bool:
        return bool(self.subscriptions())

    def publish_raw(self, data: bytes) -> None:
        """Publish the message that these bytes are. Raises CdrError if they are none."""
        self.publish(deserialize(data, self.kind))

    def send_kept(self, subscription: TopicSubscription) -> None:
        """Deliver the messages that it has kept to a new subscription."""
        if self.matches(subscription) and subscription.profile.is_transient_local:
            for message, info in self._kept:
                subscription.deliver(copy_message(message), info, self.profile.finite_lifespan_ns)

    def wait_for_all_acked(self, timeout: object) -> bool:
        """Whether all has arrived: it has, at once."""
        return True


class TopicSubscription(_TopicEndpoint, QueueHandle):
    """Like `rcl_subscription_t`.

    Args:
        filtered: a filter expression and its parameters; None: all messages.

    Raises:
        ValueError: a wrong topic.
        RCLError: a filter expression, which is not simulated.
    """

    def __init__(
        self,
        node: GraphNode,
        kind: type[Any],
        topic: str,
        profile: Profile,
        filtered: tuple[str, Sequence[str]] | None = None,
    ) -> None:
        super().__init__(node.kernel)
        self.set_content_filter(*(filtered or ("", ())))
        self.node, self.kind, self.full_name = node, kind, node.resolve(topic)
        self.profile = effective(profile, receives=True)
        self._admit()
        self._queue = deque(maxlen=self.profile.queue_length)
        self.events = EndpointEvents()
        self._received = 0
        self._last_numbers: dict[bytes, int] = {}
        """Publisher -> the number of its last message that came."""
        self._join(node.graph.subscriptions)
        for publisher in node.graph.publishers.get(self.full_name, ()):
            _match(publisher, self)
            publisher.send_kept(self)

    def _on_leave(self) -> None:
        for publisher in self.node.graph.publishers.get(self.full_name, ()):
            if publisher.matches(self):
                publisher.events.match(-1)

    def is_ready(self) -> bool:
        """Whether there is a message."""
        while self._queue and self._is_stale(*self._queue[0][1:3]):
            self._queue.popleft()
        return bool(self._queue)

    def _is_stale(self, info: dict[str, Any], lifespan_ns: int) -> bool:
        """Whether the lifespan of a message is over (DDS 1.4, 2.2.3.16)."""
        return lifespan_ns > 0 and info["source_timestamp"] + lifespan_ns <= system_ns(self.kernel)

    def set_content_filter(self, expression: str, parameters: Sequence[str]) -> None:
        """Raises RCLError, unless all messages are to be taken."""
        if expression:
            raise RCLError(f"content filters are not simulated: {expression}; filter the messages in the callback")

    set_on_new_message_callback = QueueHandle.set_callback
    clear_on_new_message_callback = QueueHandle.clear_callback

    def is_cft_enabled(self) -> bool:
        return False

    def get_content_filter(self) -> NoReturn:
        """Raises RCLError: it has none."""
        raise RCLError("failed to get content filter for the topic: content filter is not set")

    def deliver(self, message: Any, info: dict[str, Any], lifespan_ns: int = 0) -> None:
        """Add a message to the queue, unless its lifespan is over; the oldest one goes if there are too many."""
        self._notice_lost(info)
        if self._is_stale(info, lifespan_ns):
            return
        self._received += 1
        self.last_ns = self.kernel.now_us * 1000
        stamp_ns = system_ns(self.kernel)
        received = {"received_timestamp": stamp_ns, "reception_sequence_number": self._received}
        self._enqueue(message, {**info, **received}, lifespan_ns)

    def _notice_lost(self, info: dict[str, Any]) -> None:
        """A reader of DDS sees by the numbers of messages that some before this one are missing."""
        publisher, number = info["publisher_gid"]["data"], info["publication_sequence_number"]
        last = self._last_numbers.get(publisher, number - 1)  # who comes later has missed nothing
        if number > last + 1:
            self.events.lose(number - last - 1)
        self._last_numbers[publisher] = max(number, last)

    def take_message(self, kind: type[Any], raw: bool) -> tuple[Any, dict[str, Any]] | None:
        """The oldest message and when it was sent and came; None if there is none."""
        if not self.is_ready():
            return None
        message, info, _, _ = self._queue.popleft()
        return (serialize(message, kind) if raw else message), info

    def leases(self) -> list[Lease]:
        """The leases of the publishers that reach it."""
        publishers = self.node.graph.publishers.get(self.full_name, ())
        return [publisher.lease for publisher in publishers if publisher.matches(self)]

    def get_publisher_count(self) -> int:
        """The number of publishers that reach it."""
        return sum(publisher.matches(self) for publisher in self.node.graph.publishers.get(self.full_name, ()))
