"""`StartedSystem`, through which the simulated world takes part in the ROS graph: it publishes, subscribes and serves.

`Ros2Overlay.start` makes it, and testbenches get it from `run.ros2`. Its method `node` returns a `WorldNode`. Methods
that block do so in simulated time. Messages are those of ROS; nothing of `rclpy` is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pytest_hricdv.declarations.ros2 import (
    Caller,
    RosActionCaller,
    RosQueue,
    RosSentGoal,
    RosWorldNode,
)
from pytest_hricdv.extra.ros2 import qos
from pytest_hricdv.extra.ros2.actions import part_names
from pytest_hricdv.extra.ros2.clocks import whole_ns
from pytest_hricdv.extra.ros2.contexts import DEFAULT_DOMAIN, Context, GraphNode
from pytest_hricdv.extra.ros2.handles import Waitable
from pytest_hricdv.extra.ros2.messages import import_type
from pytest_hricdv.extra.ros2.services import Client, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.extra.ros2.world_action_server import Execute, ServedAction, ServedGoal
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual.clocks import uuid4

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_LATCHED = qos.Profile(depth=1, durability=qos.TRANSIENT_LOCAL)  # later subscriptions get the last message


class MessageQueue(RosQueue):
    """A queue of the messages of a topic."""

    def __init__(self, subscription: TopicSubscription) -> None:
        self._subscription = subscription

    def poll(self) -> Any | None:
        self._subscription.kernel.count_poll()
        taken = self._subscription.take_message(self._subscription.kind, False)
        return None if taken is None else taken[0]

    def wait(self, timeout_s: float) -> Any | None:
        wait_for("subscription", self._subscription, timeout_s)
        return self.poll()


class WorldNode(RosWorldNode):
    """A node of the world in the ROS graph.

    Args:
        name: its name in the graph, and as a sender in the record.
        context: the context, with remappings, of a process that it replaces.
    """

    def __init__(self, kernel: Kernel, name: str, namespace: str = "/", context: Context | None = None) -> None:
        self._kernel = kernel
        self._node = GraphNode(name, namespace, context or Context([], DEFAULT_DOMAIN, kernel), None, True, False)

    @property
    def graph_node(self) -> GraphNode:
        """The node that it is in the graph."""
        return self._node

    def publisher(self, topic: str, kind: str | type[Any], depth: int = 10, *, latched: bool = False) -> Publisher:
        profile = _LATCHED if latched else qos.Profile(depth=depth)
        return Publisher(self._node, _class(kind, "msg"), topic, profile)

    def subscribe(self, topic: str, kind: str | type[Any], depth: int = 1000) -> MessageQueue:
        profile = qos.Profile(depth=depth, reliability=qos.BEST_EFFORT)
        return MessageQueue(TopicSubscription(self._node, _class(kind, "msg"), topic, profile))

    def serve(self, name: str, kind: str | type[Any], answer: Callable[[Any, Any], Any]) -> None:
        srv = _class(kind, "srv")
        service = ServiceServer(self._node, srv, name, qos.Profile())

        def serve_requests() -> None:
            while True:
                wait_for("service", service, None)
                request, info = service.service_take_request(srv.Request)
                if info is not None:
                    service.service_send_response(answer(request, srv.Response()), info.request_id)

        self._kernel.spawn(f"{self._node.get_node_name()}: {name}", serve_requests)

    def client(self, name: str, kind: str | type[Any]) -> ServiceClient:
        return ServiceClient(Client(self._node, _class(kind, "srv"), name, qos.Profile()))

    def action(self, name: str, kind: str | type[Any]) -> ActionCaller:
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
        ServedAction(self._node, name, _class(kind, "action"), execute, accept, may_cancel)


class StartedSystem:
    """The world's side of a system that was started."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        """The kernel of the run: fakes wait in its time."""

    def node(self, name: str, namespace: str = "/") -> WorldNode:
        """A node of the world in the ROS graph, such as a simulated sensor."""
        return WorldNode(self.kernel, name, namespace)


def _class(kind: str | type[Any], folder: str) -> Any:
    return import_type(kind, folder) if isinstance(kind, str) else kind


_LOOKS_EVERY_S = 0.01
"""Period (s) at which a client looks for a server. Servers appear in the first milliseconds, if they do."""


class ServiceClient(Caller):
    """A client of a service."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        return answer(self._client, self._client.kind.Request(**fields), timeout_s)


def answer(client: Client, request: Any, timeout_s: float) -> Any | None:
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
        wait_for("client", client, max(end_s - kernel.now_s, 0.0))
        info, response = client.take_response(client.kind.Response)
        if info is None:
            return None
        if info.request_id.sequence_number == number:
            return response


def wait_for(kind: str, entity: Waitable, timeout_s: float | None) -> None:
    """Wait until a subscription, service or client has something, at most `timeout_s`; None: as long as it takes."""
    waiting = WaitSet()
    getattr(waiting, f"add_{kind}")(entity)
    waiting.wait(-1 if timeout_s is None else whole_ns(timeout_s))


_FEEDBACK_DEPTH = 1000
"""Feedback messages kept until they are taken, as for the subscriptions of the world: 100 s at 10 Hz."""


class SentGoal(RosSentGoal):
    """A goal that was sent, and accepted."""

    def __init__(
        self, node: GraphNode, names: Mapping[str, str], types: Any, goal_id: Any, feedback: TopicSubscription | None
    ) -> None:
        self._node, self._names, self._types, self._goal_id = node, names, types, goal_id
        self._feedback = feedback
        self._asked: Client | None = None
        self._response: Any = None

    def feedback(self, timeout_s: float) -> Any | None:
        feedback, kernel = self._feedback, self._node.kernel
        assert feedback is not None, "whoever gets a goal hears its feedback"
        end_s = kernel.now_s + timeout_s
        while True:
            wait_for("subscription", feedback, max(end_s - kernel.now_s, 0.0))
            taken = feedback.take_message(feedback.kind, False)
            if taken is None:
                return None
            message, _ = taken
            if bytes(message.goal_id.uuid) == bytes(self._goal_id):  # else of another goal
                return message.feedback

    def result(self, timeout_s: float) -> Any | None:
        if self._response is not None:
            return self._response
        assert self._asked is not None, "who is accepted has asked"
        wait_for("client", self._asked, timeout_s)
        _, self._response = self._asked.take_response(self._asked.kind.Response)
        if self._response is not None:
            self._asked.destroy_when_not_in_use()
        return self._response

    def ask(self) -> None:
        """Ask for the result, which comes when the goal is over."""
        self._asked = self._client("get_result", self._types.GetResultService)
        request = self._types.GetResultService.Request()
        request.goal_id.uuid = self._goal_id
        self._asked.send_request(request)

    def cancel(self, timeout_s: float) -> bool:
        request = self._types.CancelGoalService.Request()
        request.goal_info.goal_id.uuid = self._goal_id
        client = self._client("cancel_goal", self._types.CancelGoalService)
        response = answer(client, request, timeout_s)
        client.destroy_when_not_in_use()
        return response is not None and bool(response.goals_canceling)

    def _client(self, part: str, kind: Any) -> Client:
        """A client for each goal and question: several kernel nodes may wait at the same time."""
        return Client(self._node, kind, self._names[part], qos.Profile())


class ActionCaller(RosActionCaller):
    """A client of an action."""

    def __init__(self, node: GraphNode, name: str, kind: Any) -> None:
        self._types, self._names = kind.Impl, part_names(name)
        self._node = node
        self._goal = Client(node, self._types.SendGoalService, self._names["send_goal"], qos.Profile())

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        kernel = self._node.kernel
        end_s = kernel.now_s + timeout_s
        goal = self._send_goal(timeout_s, fields, None)
        return None if goal is None else goal.result(max(end_s - kernel.now_s, 0.0))

    def send(self, timeout_s: float, **fields: Any) -> SentGoal | None:
        # Before the goal is sent, so that no feedback is missed.
        profile = qos.Profile(depth=_FEEDBACK_DEPTH)
        feedback = TopicSubscription(self._node, self._types.FeedbackMessage, self._names["feedback"], profile)
        goal = self._send_goal(timeout_s, fields, feedback)
        if goal is None:
            feedback.destroy_when_not_in_use()
        return goal

    def _send_goal(
        self, timeout_s: float, fields: Mapping[str, Any], feedback: TopicSubscription | None
    ) -> SentGoal | None:
        request = self._types.SendGoalService.Request()
        request.goal_id.uuid = list(uuid4().bytes)
        for name, value in fields.items():
            setattr(request.goal, name, value)
        goal = SentGoal(self._node, self._names, self._types, request.goal_id.uuid, feedback)
        response = answer(self._goal, request, timeout_s)
        if response is None or not response.accepted:
            return None
        goal.ask()  # at once, as clients do, so that the record has the result even if nobody takes it
        return goal
