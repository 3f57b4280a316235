"""QoS events of publishers and subscriptions (DDS 1.4, 2.2.4.1): matches, mismatches, deadlines, liveliness, losses.

`topics` gives each publisher and subscription an `EndpointEvents`, which counts its events. `extension` gives `rclpy`
the class `EventHandle`, from which executors take the counts (`EventStatus`). As in DDS, a reader notices a lost
message when the next one of the same publisher arrives.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any, Protocol

from pytest_hricdv.extra.ros2.handles import RCLError, Waitable
from pytest_hricdv.extra.ros2.qos import MANUAL_BY_TOPIC, Profile, QosPolicyKind
from pytest_hricdv.runtime.kernel import Kernel


class UnsupportedEventTypeError(RCLError):
    """Like the error of `rclpy`'s extension, so that code can catch it; this middleware has all events."""


class SubscriptionEventType(IntEnum):
    """The kinds of events of a subscription, numbered like `rcl_subscription_event_type_t`."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class PublisherEventType(IntEnum):
    """The kinds of events of a publisher, numbered like `rcl_publisher_event_type_t`."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


@dataclass
class EventStatus(ABC):
    """Counts of one kind of event; fields that end with `_change` count since the status was last taken."""

    @abstractmethod
    def has_changed(self) -> bool:
        """Whether a field that ends with `_change` is not 0. Executors ask at each step."""

    def take(self) -> Any:
        """A copy; the fields that end with `_change` are then 0 again."""
        copy = replace(self)
        vars(self).update(dict.fromkeys((name for name in vars(self) if name.endswith("_change")), 0))
        return copy


@dataclass
class CountStatus(EventStatus):
    """The number of events."""

    total_count: int = 0
    total_count_change: int = 0

    def has_changed(self) -> bool:
        return self.total_count_change != 0

    def count(self, times: int = 1) -> None:
        """Count some more."""
        self.total_count += times
        self.total_count_change += times


@dataclass
class QosIncompatibleStatus(CountStatus):
    """The number of mismatches, and the policy of the last one (`rclpy.qos.QoSPolicyKind`)."""

    last_policy_kind: int = QosPolicyKind.RMW_QOS_POLICY_INVALID


@dataclass
class LivelinessChangedStatus(EventStatus):
    """The numbers of publishers that are alive, and that are not."""

    alive_count: int = 0
    not_alive_count: int = 0
    alive_count_change: int = 0
    not_alive_count_change: int = 0

    def has_changed(self) -> bool:
        return self.alive_count_change != 0 or self.not_alive_count_change != 0

    def change(self, alive: int, not_alive: int) -> None:
        """Count publishers that become alive, or not alive, or leave (negative)."""
        self.alive_count += alive
        self.alive_count_change += alive
        self.not_alive_count += not_alive
        self.not_alive_count_change += not_alive


@dataclass
class MatchedStatus(CountStatus):
    """The total and the present number of matches."""

    current_count: int = 0
    current_count_change: int = 0

    def has_changed(self) -> bool:
        return self.total_count_change != 0 or self.current_count_change != 0


@dataclass
class EndpointEvents:
    """The events of a publisher or a subscription."""

    matched: MatchedStatus = field(default_factory=MatchedStatus)
    incompatible: QosIncompatibleStatus = field(default_factory=QosIncompatibleStatus)
    wrong_type: CountStatus = field(default_factory=CountStatus)
    liveliness_changed: LivelinessChangedStatus = field(default_factory=LivelinessChangedStatus)
    deadline_missed: CountStatus = field(default_factory=CountStatus)
    liveliness_lost: CountStatus = field(default_factory=CountStatus)
    message_lost: CountStatus = field(default_factory=CountStatus)
    handles: list[Waitable] = field(default_factory=list)
    """The handles that wait for one of them."""

    def match(self, change: int, is_alive: bool = True) -> None:
        """Count one more match (1), or one less (-1), and whether it is alive."""
        if change > 0:
            self.matched.count()
        self.matched.current_count += change
        self.matched.current_count_change += change
        self.liveliness_changed.change(change if is_alive else 0, 0 if is_alive else change)
        self.wake()

    def revive(self, change: int) -> None:
        """Count a match that is alive again (1), or not any more (-1)."""
        self.liveliness_changed.change(change, -change)
        self.wake()

    def mismatch(self, policy: int) -> None:
        """Count a mismatch because of a policy."""
        self.incompatible.count()
        self.incompatible.last_policy_kind = policy
        self.wake()

    def differ(self) -> None:
        """Count an endpoint with messages of another type."""
        self.wrong_type.count()
        self.wake()

    def lose(self, count: int) -> None:
        """Count messages that did not arrive."""
        self.message_lost.count(count)
        self.wake()

    def wake(self) -> None:
        """Wake the nodes that wait for one of these events."""
        for handle in self.handles:
            handle.wake()


class EventSource(Protocol):
    """The interface of a publisher or a subscription that events need."""

    events: EndpointEvents
    profile: Profile
    last_ns: int | None

    @property
    def kernel(self) -> Kernel: ...

    def leases(self) -> list[Lease]: ...


class _LeaseHolder(EventSource, Protocol):
    """A publisher."""

    def subscriptions(self) -> Sequence[Any]: ...


class Lease:
    """The lease of a publisher that asserts its liveliness itself, for a time. Others are alive while they exist."""

    def __init__(self, publisher: _LeaseHolder) -> None:
        self._publisher = publisher
        profile = publisher.profile
        self._lease_ns = profile.finite_lease_ns if profile.liveliness == MANUAL_BY_TOPIC else 0
        self._asserted_ns: int | None = None
        self.is_alive = True
        """Whether it was alive when last checked."""

    def end_ns(self) -> int | None:
        """When it ends (ns of the kernel's time); None if it does not, or has already."""
        if not self._lease_ns or self._asserted_ns is None or not self.is_alive:
            return None
        return self._asserted_ns + self._lease_ns

    def renew(self) -> None:
        """It is alive now."""
        if not self._lease_ns:
            return
        self.look()
        self._asserted_ns = self._publisher.kernel.now_us * 1000
        if not self.is_alive:
            self._become(True)
        for endpoint in (self._publisher, *self._publisher.subscriptions()):
            endpoint.events.wake()  # who waits for the end of the lease waits longer

    def look(self) -> None:
        """Check whether it has ended."""
        end_ns = self.end_ns()
        if end_ns is not None and end_ns <= self._publisher.kernel.now_us * 1000:
            self._publisher.events.liveliness_lost.count()
            self._become(False)

    def _become(self, is_alive: bool) -> None:
        self.is_alive = is_alive
        for subscription in self._publisher.subscriptions():
            subscription.events.revive(1 if is_alive else -1)


_STATUS = {
    "DEADLINE_MISSED": "deadline_missed",
    "LIVELINESS_CHANGED": "liveliness_changed",
    "LIVELINESS_LOST": "liveliness_lost",
    "INCOMPATIBLE_QOS": "incompatible",
    "MESSAGE_LOST": "message_lost",
    "INCOMPATIBLE_TYPE": "wrong_type",
    "MATCHED": "matched",
}
"""Name of an event type, without what it is of -> the status among `EndpointEvents`."""
_PREFIX = re.compile("RCL_(SUBSCRIPTION|PUBLISHER)_(REQUESTED_|OFFERED_)?")


class EventHandle(Waitable):
    """Like `rcl_event_t`."""

    def __init__(self, endpoint: EventSource, event_type: SubscriptionEventType | PublisherEventType) -> None:
        super().__init__(endpoint.kernel)
        name = _STATUS[_PREFIX.sub("", event_type.name)]
        self._endpoint = endpoint
        self._status: EventStatus = getattr(endpoint.events, name)
        self._of_liveliness = name in ("liveliness_lost", "liveliness_changed")
        self._limit_ns = endpoint.profile.finite_deadline_ns if name == "deadline_missed" else 0
        self._counted_ns = -1  # up to when delays were counted
        endpoint.events.handles.append(self)

    def destroy(self) -> None:
        """Do not count any more."""
        self._endpoint.events.handles.remove(self)

    def due_ns(self) -> int | None:
        """When the next deadline is missed."""
        if self._of_liveliness:
            return min((end for lease in self._endpoint.leases() if (end := lease.end_ns()) is not None), default=None)
        last_ns = self._endpoint.last_ns
        if not self._limit_ns or last_ns is None:
            return None
        return max(last_ns, self._counted_ns) + self._limit_ns

    def is_ready(self) -> bool:
        """Whether something has changed since it was taken."""
        if self._of_liveliness:
            for lease in self._endpoint.leases():
                lease.look()
        elif self._limit_ns:
            self._count_delays()
        return self._status.has_changed()

    def _count_delays(self) -> None:
        now_ns = self.kernel.now_us * 1000
        while (due_ns := self.due_ns()) is not None and due_ns <= now_ns:
            assert isinstance(self._status, CountStatus)
            self._status.count()
            self._counted_ns = due_ns

    def take_event(self) -> Any:
        """Take the event's status."""
        self.is_ready()
        return self._status.take()
