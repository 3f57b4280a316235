"""Clients of the simulated world: what blocks here blocks a node of the kernel, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pytest_hricdv.extra.ros2 import qos
from pytest_hricdv.extra.ros2.actions import part_names
from pytest_hricdv.extra.ros2.clocks import whole_ns
from pytest_hricdv.extra.ros2.contexts import Node
from pytest_hricdv.extra.ros2.handles import Awaited
from pytest_hricdv.extra.ros2.services import Client
from pytest_hricdv.extra.ros2.topics import Subscription
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.runtime.virtual.identifiers import uuid4

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_LOOKS_EVERY_S = 0.01
"""How often a client looks whether there is a server. Servers appear in the first milliseconds, if they do."""


class ServiceClient:
    """A client of a service."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Ask with a request that has these fields; the response, or None if there is none within `timeout_s`."""
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


def wait_for(kind: str, entity: Awaited, timeout_s: float | None) -> None:
    """Wait until a subscription, service or client has something, at most `timeout_s`; None: as long as it takes."""
    waiting = WaitSet()
    getattr(waiting, f"add_{kind}")(entity)
    waiting.wait(-1 if timeout_s is None else whole_ns(timeout_s))


_FEEDBACK_DEPTH = 1000
"""Feedback messages kept until they are taken, as for the subscriptions of the world: 100 s at 10 Hz."""


class SentGoal:
    """A goal that was sent, and accepted."""

    def __init__(
        self, node: Node, names: Mapping[str, str], types: Any, goal_id: Any, feedback: Subscription | None
    ) -> None:
        self._node, self._names, self._types, self._goal_id = node, names, types, goal_id
        self._feedback = feedback
        self._asked: Client | None = None
        self._response: Any = None

    def feedback(self, timeout_s: float) -> Any | None:
        """The oldest feedback not yet taken, as `NavigateToPose.Feedback`; None if there is none within `timeout_s`."""
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
        """Wait until the goal is over.

        Returns:
            Its `status`, as `action_msgs/msg/GoalStatus` numbers it, and its `result`; None if it is not over within
            `timeout_s`: call it again to go on waiting.
        """
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
        """Ask to cancel it; whether the server will. It is over when there is a result."""
        request = self._types.CancelGoalService.Request()
        request.goal_info.goal_id.uuid = self._goal_id
        client = self._client("cancel_goal", self._types.CancelGoalService)
        response = answer(client, request, timeout_s)
        client.destroy_when_not_in_use()
        return response is not None and bool(response.goals_canceling)

    def _client(self, part: str, kind: Any) -> Client:
        """One for each goal and question: several nodes of the kernel may wait at the same time."""
        return Client(self._node, kind, self._names[part], qos.Profile())


class ActionCaller:
    """A client of an action."""

    def __init__(self, node: Node, name: str, kind: Any) -> None:
        self._types, self._names = kind.Impl, part_names(name)
        self._node = node
        self._goal = Client(node, self._types.SendGoalService, self._names["send_goal"], qos.Profile())

    def call(self, timeout_s: float, **fields: Any) -> Any | None:
        """Send a goal that has these fields, and wait until it is over.

        Returns:
            Its `status`, as `action_msgs/msg/GoalStatus` numbers it, and its `result`; None if the goal was not
            accepted, or is not over within `timeout_s`.
        """
        kernel = self._node.kernel
        end_s = kernel.now_s + timeout_s
        goal = self._accepted(timeout_s, fields, None)
        return None if goal is None else goal.result(max(end_s - kernel.now_s, 0.0))

    def send(self, timeout_s: float, **fields: Any) -> SentGoal | None:
        """Send a goal that has these fields, beside others; None if it is not accepted within `timeout_s`."""
        # Before the goal is sent, so that no feedback is missed.
        profile = qos.Profile(depth=_FEEDBACK_DEPTH)
        feedback = Subscription(self._node, self._types.FeedbackMessage, self._names["feedback"], profile)
        goal = self._accepted(timeout_s, fields, feedback)
        if goal is None:
            feedback.destroy_when_not_in_use()
        return goal

    def _accepted(self, timeout_s: float, fields: Mapping[str, Any], feedback: Subscription | None) -> SentGoal | None:
        request = self._types.SendGoalService.Request()
        request.goal_id.uuid = list(uuid4().bytes)
        for name, value in fields.items():
            setattr(request.goal, name, value)
        goal = SentGoal(self._node, self._names, self._types, request.goal_id.uuid, feedback)
        response = answer(self._goal, request, timeout_s)
        if response is None or not response.accepted:
            return None
        goal.ask()  # at once, as clients do: the result is in the record when it is there, also if nobody takes it
        return goal
