"""Service introspection: requests and responses as messages of a topic, for those who want to look on."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from pytest_hricdv.extra.ros2.clocks import Clock
from pytest_hricdv.extra.ros2.contexts import Node
from pytest_hricdv.extra.ros2.messages import copy_message
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.topics import Publisher

_NS_PER_S = 1_000_000_000


class IntrospectionState(IntEnum):
    """As `ServiceIntrospectionState`."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


class ServiceEvent(IntEnum):
    """As `service_msgs/msg/ServiceEventInfo` numbers them."""

    REQUEST_SENT = 0
    REQUEST_RECEIVED = 1
    RESPONSE_SENT = 2
    RESPONSE_RECEIVED = 3


class Introspection:
    """Publishes what one end of a service sends and receives.

    Args:
        kind: of the service.
        clock: stamps the events.
        state: whether the events have the request and the response.
    """

    def __init__(
        self, node: Node, kind: type[Any], service: str, clock: Clock, profile: Profile, state: IntrospectionState
    ) -> None:
        self._kind: Any = kind
        self._clock = clock
        self._has_contents = state is IntrospectionState.CONTENTS
        self._publisher = Publisher(node, self._kind.Event, f"{service}/_service_event", profile)

    def publish(self, event: ServiceEvent, client: int, sequence_number: int, content: Any) -> None:
        """Publish one event of the request of that number of a client, which its pointer names."""
        message = self._kind.Event()
        message.info.event_type = int(event)
        message.info.stamp.sec, message.info.stamp.nanosec = divmod(self._clock.now_ns(), _NS_PER_S)
        message.info.client_gid = list(client.to_bytes(16, "big"))
        message.info.sequence_number = sequence_number
        if self._has_contents:
            is_request = event in (ServiceEvent.REQUEST_SENT, ServiceEvent.REQUEST_RECEIVED)
            setattr(message, "request" if is_request else "response", [copy_message(content)])
        self._publisher.publish(message)

    def close(self) -> None:
        """Publish no more."""
        self._publisher.destroy_when_not_in_use()
