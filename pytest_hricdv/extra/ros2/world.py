"""The simulated world in the ROS graph: sensors that publish, devices that subscribe and serve, people that call.

What blocks here blocks a node of the kernel, in simulated time. Messages are those of ROS; nothing of `rclpy` is used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from pytest_hricdv.extra.ros2 import qos
from pytest_hricdv.extra.ros2.contexts import DEFAULT_DOMAIN, Context, Node
from pytest_hricdv.extra.ros2.services import Client, Service
from pytest_hricdv.extra.ros2.topics import Publisher, Subscription
from pytest_hricdv.extra.ros2.vocabulary import loaded
from pytest_hricdv.extra.ros2.world_action_server import Execute, ServedAction, ServedGoal
from pytest_hricdv.extra.ros2.world_client import ActionCaller, ServiceClient, wait_for
from pytest_hricdv.runtime import Kernel

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

T = TypeVar("T")
_LATCHED = qos.Profile(depth=1, durability=qos.TRANSIENT_LOCAL)


class MessageQueue(Generic[T]):
    """A queue of the messages of a topic, as `runtime.Subscription` is one of the bus."""

    def __init__(self, subscription: Subscription) -> None:
        self._subscription = subscription

    def poll(self) -> Any | None:
        """The oldest message not yet taken, or None; never blocks."""
        self._subscription.kernel.count_poll()
        taken = self._subscription.take_message(self._subscription.kind, False)
        return None if taken is None else taken[0]

    def wait(self, timeout_s: float) -> Any | None:
        """Block until there is a message, at most `timeout_s`; None on time-out."""
        wait_for("subscription", self._subscription, timeout_s)
        return self.poll()


class WorldNode:
    """A node of the world in the ROS graph.

    Args:
        kernel: of the run.
        name: in the graph, and of the sender in the record.
        namespace: it is in.
        context: with remappings, of a process that it stands for.
    """

    def __init__(self, kernel: Kernel, name: str, namespace: str = "/", context: Context | None = None) -> None:
        self._kernel = kernel
        self._node = Node(name, namespace, context or Context([], DEFAULT_DOMAIN, kernel), None, True, False)

    @property
    def graph_node(self) -> Node:
        """The node that it is in the graph."""
        return self._node

    def publisher(self, topic: str, kind: str | type[Any], depth: int = 10, *, latched: bool = False) -> Publisher:
        """A publisher: call its `publish(message)`.

        Args:
            kind: the type, as "std_msgs/msg/String", or its class.
            latched: whether a later subscription gets the last message ("transient local").
        """
        profile = _LATCHED if latched else qos.Profile(depth=depth)
        return Publisher(self._node, _class(kind, "msg"), topic, profile)

    def subscribe(self, topic: str, kind: str | type[Any], depth: int = 1000) -> MessageQueue[Any]:
        """A queue of the messages of a topic from now on. It takes what any publisher offers."""
        profile = qos.Profile(depth=depth, reliability=qos.BEST_EFFORT)
        return MessageQueue(Subscription(self._node, _class(kind, "msg"), topic, profile))

    def serve(self, name: str, kind: str | type[Any], answer: Callable[[Any, Any], Any]) -> None:
        """Serve from now on: `answer(request, response)` returns the response, and may block."""
        srv = _class(kind, "srv")
        service = Service(self._node, srv, name, qos.Profile())

        def serving() -> None:
            while True:
                wait_for("service", service, None)
                request, info = service.service_take_request(srv.Request)
                if info is not None:
                    service.service_send_response(answer(request, srv.Response()), info.request_id)

        self._kernel.spawn(f"{self._node.get_node_name()}: {name}", serving)

    def client(self, name: str, kind: str | type[Any]) -> ServiceClient:
        """A client of a service."""
        return ServiceClient(Client(self._node, _class(kind, "srv"), name, qos.Profile()))

    def action(self, name: str, kind: str | type[Any]) -> ActionCaller:
        """A client of an action."""
        return ActionCaller(self._node, name, _class(kind, "action"))

    def serve_action(
        self,
        name: str,
        kind: str | type[Any],
        execute: Execute,
        *,
        accept: Callable[[Any], bool] = lambda goal: True,
        may_cancel: Callable[[ServedGoal], bool] = lambda goal: True,
    ) -> None:
        """Serve an action from now on.

        Args:
            execute: called with each goal that was accepted (`ServedGoal`), in a node of the kernel of its own; it may
                block, and ends the goal with `succeed`, `abort` or `cancel`.
            accept: whether a goal is accepted, by its message.
            may_cancel: whether a goal is cancelled when a client asks for it.
        """
        ServedAction(self._node, name, _class(kind, "action"), execute, accept, may_cancel)


class StartedSystem:
    """The world's side of a system that was started."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        """Of the run: stand-ins wait in its time."""

    def node(self, name: str, namespace: str = "/") -> WorldNode:
        """A node of the world in the ROS graph, such as a simulated sensor."""
        return WorldNode(self.kernel, name, namespace)


def _class(kind: str | type[Any], folder: str) -> Any:
    return loaded(kind, folder) if isinstance(kind, str) else kind
