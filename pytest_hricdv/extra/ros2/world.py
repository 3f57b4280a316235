"""The simulated world in the ROS graph: sensors that publish, devices that subscribe and serve, people that call.

What blocks here blocks a node of the kernel, in simulated time. Messages are those of ROS; nothing of `rclpy` is used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from pytest_hricdv.extra.ros2 import qos
from pytest_hricdv.extra.ros2.actions import part_names
from pytest_hricdv.extra.ros2.contexts import DEFAULT_DOMAIN, Context, Node
from pytest_hricdv.extra.ros2.handles import Awaited
from pytest_hricdv.extra.ros2.services import Client, Service
from pytest_hricdv.extra.ros2.topics import Publisher, Subscription
from pytest_hricdv.extra.ros2.vocabulary import loaded
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import US_PER_S
from pytest_hricdv.runtime.virtual.identifiers import uuid4

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

T = TypeVar("T")
_LOOKS_EVERY_S = 0.01
"""How often a client looks whether there is a server. Chosen: servers appear in the first milliseconds, if they do."""

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
        _wait("subscription", self._subscription, timeout_s)
        return self.poll()


class WorldNode:
    """A node of the world in the ROS graph.

    Args:
        kernel: of the run.
        name: in the graph, and of the sender in the record.
        namespace: it is in.
    """

    def __init__(self, kernel: Kernel, name: str, namespace: str = "/") -> None:
        self._kernel = kernel
        self._node = Node(name, namespace, Context([], DEFAULT_DOMAIN, kernel), None, True, False)

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
                _wait("service", service, None)
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


class ServiceClient:
    """A client of a service."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Ask with a request that has these fields; the response, or None if there is none within `timeout_s`."""
        return _answer(self._client, self._client.kind.Request(**fields), timeout_s)


class ActionCaller:
    """A client of an action: one goal after the other."""

    def __init__(self, node: Node, name: str, kind: Any) -> None:
        self._types, names, profile = kind.Impl, part_names(name), qos.Profile()
        self._goal = Client(node, self._types.SendGoalService, names["send_goal"], profile)
        self._result = Client(node, self._types.GetResultService, names["get_result"], profile)

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Send a goal that has these fields, and wait until it is over.

        Returns:
            Its `status`, as `action_msgs/msg/GoalStatus` numbers it, and its `result`; None if the goal was not
            accepted, or is not over within `timeout_s`.
        """
        kernel = self._goal.kernel
        end_s = kernel.now_s + timeout_s
        request = self._types.SendGoalService.Request()
        request.goal_id.uuid = list(uuid4().bytes)
        for name, value in fields.items():
            setattr(request.goal, name, value)
        answer = _answer(self._goal, request, timeout_s)
        if answer is None or not answer.accepted:
            return None
        wanted = self._types.GetResultService.Request()
        wanted.goal_id.uuid = request.goal_id.uuid
        return _answer(self._result, wanted, end_s - kernel.now_s)


def _class(kind: str | type[Any], folder: str) -> Any:
    return loaded(kind, folder) if isinstance(kind, str) else kind


def _answer(client: Client, request: Any, timeout_s: float) -> Any | None:
    """The response to a request, which waits for a server; responses to earlier ones, too late, are dropped."""
    kernel = client.kernel
    end_s = kernel.now_s + timeout_s
    # The graph wakes nobody when a server comes, as in `rclpy`, which looks every 0.25 s.
    while not client.service_server_is_available():
        if kernel.now_s + _LOOKS_EVERY_S > end_s:
            return None
        kernel.sleep(_LOOKS_EVERY_S)
    number = client.send_request(request)
    while True:
        _wait("client", client, max(end_s - kernel.now_s, 0.0))
        info, response = client.take_response(client.kind.Response)
        if info is None:
            return None
        if info.request_id.sequence_number == number:
            return response


def _wait(kind: str, entity: Awaited, timeout_s: float | None) -> None:
    waiting = WaitSet()
    getattr(waiting, f"add_{kind}")(entity)
    waiting.wait(-1 if timeout_s is None else round(timeout_s * US_PER_S) * 1000)
