"""Events of quality of service: their types and what they say. They are not simulated yet; code that does not ask for
one of its own runs without, as `rclpy` allows for middlewares that lack them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class UnsupportedEventTypeError(RuntimeError):
    """As of the extension: this middleware does not have such events."""


class SubscriptionEventType(IntEnum):
    """As `rcl_subscription_event_type_t`."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class PublisherEventType(IntEnum):
    """As `rcl_publisher_event_type_t`."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


@dataclass
class CountStatus:
    """How often something happened, and how often since it was last asked."""

    total_count: int = 0
    total_count_change: int = 0


@dataclass
class QosIncompatibleStatus(CountStatus):
    """The same, and the policy that did not match last."""

    last_policy_kind: int = 0


@dataclass
class LivelinessChangedStatus:
    """How many publishers are alive, and how many are not."""

    alive_count: int = 0
    not_alive_count: int = 0
    alive_count_change: int = 0
    not_alive_count_change: int = 0


@dataclass
class MatchedStatus(CountStatus):
    """How many match now."""

    current_count: int = 0
    current_count_change: int = 0


class EventHandle:
    """As `rcl_event_t`. Raises UnsupportedEventTypeError."""

    def __init__(self, endpoint: object, event_type: IntEnum) -> None:
        raise UnsupportedEventTypeError(f"{event_type.name} is not simulated yet")
