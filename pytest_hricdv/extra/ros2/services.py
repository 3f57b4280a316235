"""Simulates the services and clients of `rclpy`: requests and responses wait in queues until they are taken.

`extension` gives `ServiceServer` and `Client` to `rclpy`; actions, managed nodes and the simulated world use them, too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import Any

from pytest_hricdv.extra.ros2.clocks import Clock, system_ns
from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.graph import GraphEntity
from pytest_hricdv.extra.ros2.handles import QueueHandle
from pytest_hricdv.extra.ros2.messages import copy_message, set_stamp, type_name
from pytest_hricdv.extra.ros2.qos import Profile, effective
from pytest_hricdv.extra.ros2.topics import Publisher
from pytest_hricdv.runtime.kernel import Node as KernelNode
from pytest_hricdv.runtime.source_location import place_of

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class IntrospectionState(IntEnum):
    """What is published about requests and responses: nothing, their times, or also their fields."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


class ServiceEvent(IntEnum):
    """The published events of a service, numbered as in `service_msgs/msg/ServiceEventInfo`."""

    REQUEST_SENT = 0
    REQUEST_RECEIVED = 1
    RESPONSE_SENT = 2
    RESPONSE_RECEIVED = 3


class Introspection:
    """Publishes what one end of a service sends and receives; `state` says whether with requests and responses."""

    def __init__(
        self, node: GraphNode, kind: type[Any], service: str, clock: Clock, profile: Profile, state: IntrospectionState
    ) -> None:
        self._kind: Any = kind
        self._clock = clock
        self._has_contents = state is IntrospectionState.CONTENTS
        self._publisher = Publisher(node, self._kind.Event, f"{service}/_service_event", profile)

    def publish(self, event: ServiceEvent, client: int, sequence_number: int, content: Any) -> None:
        """Publish one event of a request, which the client (a number) and the sequence number identify."""
        message = self._kind.Event()
        message.info.event_type = int(event)
        set_stamp(message.info.stamp, self._clock.now_ns())
        message.info.client_gid = list(client.to_bytes(16, "big"))
        message.info.sequence_number = sequence_number
        if self._has_contents:
            is_request = event in (ServiceEvent.REQUEST_SENT, ServiceEvent.REQUEST_RECEIVED)
            setattr(message, "request" if is_request else "response", [copy_message(content)])
        self._publisher.publish(message)

    def close(self) -> None:
        """Publish no more."""
        self._publisher.destroy_when_not_in_use()


@dataclass(frozen=True)
class RequestId:
    """Like `rmw_request_id_t`: the number of a request and its client."""

    sequence_number: int
    client: Client


@dataclass(frozen=True)
class ServiceInfo:
    """Like `rmw_service_info_t`, times in ns."""

    request_id: RequestId
    source_timestamp: int
    received_timestamp: int


class _ServiceEndpoint(GraphEntity, QueueHandle):
    """The base of services and clients: a name, a queue, and introspection."""

    def __init__(self, node: GraphNode, kind: type[Any], name: str) -> None:
        super().__init__(node.kernel)
        self.node, self.kind, self.full_name = node, kind, node.resolve(name)
        self._introspection: Introspection | None = None
        node.admit(self.full_name, kind)

    def _on_leave(self) -> None:
        if self._introspection is not None:
            self._introspection.close()

    def configure_introspection(self, clock: Clock, profile: Profile, state: IntrospectionState) -> None:
        """Publish what it sends and receives from now on, or no more."""
        if self._introspection is not None:
            self._introspection.close()
        is_on = state is not IntrospectionState.OFF
        arguments = (self.node, self.kind, self.full_name, clock, profile, state)
        self._introspection = Introspection(*arguments) if is_on else None

    def _tell(self, event: ServiceEvent, request_id: RequestId, content: Any) -> None:
        if self._introspection is not None:
            self._introspection.publish(event, request_id.client.pointer, request_id.sequence_number, content)

    def _send(self, direction: str, content: Any, deliver: Callable[[Any], None], is_heard: Callable[[], bool]) -> None:
        """Deliver a request or a response, which does not change any more."""
        sent, carrier = copy_message(content), self.node.graph.carrier
        if carrier is None:
            deliver(sent)
            return
        sender = self.node.get_fully_qualified_name()
        reliable = "a service or an action is carried reliably"
        carrier.carry(sender, self.full_name, direction, sent, partial(deliver, sent), is_heard, lambda: reliable)


class ServiceServer(_ServiceEndpoint):
    """Like `rcl_service_t`. Raises ValueError for a wrong name."""

    def __init__(self, node: GraphNode, kind: type[Any], name: str, profile: Profile) -> None:
        super().__init__(node, kind, name)
        self._profile = effective(profile)
        self._join(node.graph.services)

    @property
    def name(self) -> str:
        return self.full_name

    @property
    def qos(self) -> dict[str, Any]:
        return self._profile.to_dict()

    def deliver(self, request: Any, request_id: RequestId) -> None:
        self._enqueue(request, request_id, system_ns(self.kernel))

    set_on_new_request_callback = QueueHandle.set_callback
    clear_on_new_request_callback = QueueHandle.clear_callback

    def service_take_request(self, kind: type[Any]) -> tuple[Any, ServiceInfo] | tuple[None, None]:
        """The oldest request, and whose it is; (None, None) if there is none."""
        if not self._queue:
            return None, None
        request, request_id, sent_ns, _ = self._queue.popleft()
        self._tell(ServiceEvent.REQUEST_RECEIVED, request_id, request)
        return request, ServiceInfo(request_id, sent_ns, sent_ns)

    def service_send_response(self, response: Any, header: RequestId) -> None:
        """Answer a request."""
        self._tell(ServiceEvent.RESPONSE_SENT, header, response)
        client = header.client
        self._send("response", response, lambda sent: client.deliver(copy_message(sent), header), lambda: True)


@dataclass(frozen=True)
class UnservedRequest:
    """A request for which there was no server: when it was sent (s of simulated time), and at which line."""

    time_s: float
    place: str


class Client(_ServiceEndpoint):
    """Like `rcl_client_t`. Raises ValueError for a wrong name."""

    def __init__(self, node: GraphNode, kind: type[Any], name: str, profile: Profile) -> None:
        super().__init__(node, kind, name)
        self._sent = self._answered = 0
        self.asked_by: KernelNode | None = None
        """The node of the kernel that asked last."""
        self.lost: dict[int, UnservedRequest] = {}
        """Number of a request -> where it was sent, of those that no server got."""
        self.missed_since_s: float | None = None
        """Since when a server has been looked for, and not been found (s of simulated time)."""
        self._join(node.graph.clients)

    def _on_leave(self) -> None:
        super()._on_leave()
        self._queue.clear()  # responses on their way are lost

    @property
    def service_name(self) -> str:
        """The full name of the service."""
        return self.full_name

    def servers(self) -> list[ServiceServer]:
        every = self.node.graph.services.get(self.full_name, ())
        return [service for service in every if type_name(service.kind) == type_name(self.kind)]

    def service_server_is_available(self) -> bool:
        """Whether there is a server; counts as a poll."""
        self.kernel.count_poll()
        is_served = bool(self.servers())
        if is_served:
            self.missed_since_s = None
        elif self.missed_since_s is None:
            self.missed_since_s = self.kernel.now_s
        return is_served

    def send_request(self, request: Any) -> int:
        """Ask; returns the number of the request. Without a server the request is lost, as in a middleware."""
        self._sent += 1
        self.asked_by = self.kernel.own_node()
        if not self.servers():
            # The caller's location: readers look there for the reason.
            self.lost[self._sent] = UnservedRequest(self.kernel.now_s, place_of(sys._getframe(1)))
        self._tell(ServiceEvent.REQUEST_SENT, RequestId(self._sent, self), request)
        self._send("request", request, partial(self._deliver_request, RequestId(self._sent, self)), self._is_served)
        return self._sent

    def _deliver_request(self, request_id: RequestId, request: Any) -> None:
        for server in self.servers():
            server.deliver(copy_message(request), request_id)

    def _is_served(self) -> bool:
        return bool(self.servers())

    def deliver(self, response: Any, request_id: RequestId) -> None:
        self._answered = request_id.sequence_number
        self._enqueue(response, request_id, system_ns(self.kernel))

    set_on_new_response_callback = QueueHandle.set_callback
    clear_on_new_response_callback = QueueHandle.clear_callback

    def is_unanswered(self) -> bool:
        """Whether the last request has no response yet."""
        return self._answered < self._sent

    def was_answered_before(self) -> bool:
        """Whether a response has been there since before the present instant."""
        return bool(self._queue) and self._queue[0][2] < system_ns(self.kernel)

    def take_response(self, kind: type[Any]) -> tuple[ServiceInfo, Any] | tuple[None, None]:
        """Take the oldest response: its request's id and the response; (None, None) if there is none."""
        if not self._queue:
            return None, None
        response, request_id, sent_ns, _ = self._queue.popleft()
        self._tell(ServiceEvent.RESPONSE_RECEIVED, request_id, response)
        return ServiceInfo(request_id, sent_ns, sent_ns), response
