"""Actions, as the ROS 2 design article "Actions" says: states of a goal, names of an action's parts, and clients."""

from __future__ import annotations

from enum import IntEnum
from functools import partialmethod
from typing import Any

from pytest_hricdv.extra.ros2.clocks import Clock
from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.handles import Destroyable
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import Client, IntrospectionState
from pytest_hricdv.extra.ros2.topics import TopicSubscription
from pytest_hricdv.extra.ros2.wait_set import WaitSet


class GoalEvent(IntEnum):
    """As `rcl_action_goal_event_t`."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


class GoalState(IntEnum):
    """As `action_msgs/msg/GoalStatus` numbers them."""

    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


NEXT_STATE = {
    (GoalState.ACCEPTED, GoalEvent.EXECUTE): GoalState.EXECUTING,
    (GoalState.ACCEPTED, GoalEvent.CANCEL_GOAL): GoalState.CANCELING,
    (GoalState.EXECUTING, GoalEvent.CANCEL_GOAL): GoalState.CANCELING,
    (GoalState.EXECUTING, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
    (GoalState.EXECUTING, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.CANCELING, GoalEvent.SUCCEED): GoalState.SUCCEEDED,
    (GoalState.CANCELING, GoalEvent.ABORT): GoalState.ABORTED,
    (GoalState.CANCELING, GoalEvent.CANCELED): GoalState.CANCELED,
}
"""The state machine of a goal."""


def part_names(action: str) -> dict[str, str]:
    """Part of an action -> the name of its service or topic."""
    parts = ("send_goal", "get_result", "cancel_goal", "feedback", "status")
    return {part: f"{action}/_action/{part}" for part in parts}


class ActionClient(Destroyable):
    """As `rcl_action_client_t`. Raises ValueError for a wrong name."""

    def __init__(
        self,
        node: GraphNode,
        kind: Any,
        name: str,
        goal: Profile,
        result: Profile,
        cancel: Profile,
        feedback: Profile,
        status: Profile,
    ) -> None:
        super().__init__(node.kernel)
        names, types = part_names(name), kind.Impl
        self._node = node
        self.goal = Client(node, types.SendGoalService, names["send_goal"], goal)
        self._cancel = Client(node, types.CancelGoalService, names["cancel_goal"], cancel)
        self._result = Client(node, types.GetResultService, names["get_result"], result)
        self._feedback = TopicSubscription(node, types.FeedbackMessage, names["feedback"], feedback)
        self._status = TopicSubscription(node, types.GoalStatusMessage, names["status"], status)
        self._indices: tuple[list[int], list[int]] = ([], [])

    def destroy(self) -> None:
        for entity in (self.goal, self._cancel, self._result, self._feedback, self._status):
            entity.destroy_when_not_in_use()

    def is_action_server_available(self) -> bool:
        """Whether somebody serves the action."""
        topics = (self._feedback, self._status)
        clients = (self.goal, self._cancel, self._result)
        heard = all(subscription.get_publisher_count() for subscription in topics)
        return all(client.service_server_is_available() for client in clients) and heard

    def send_goal_request(self, request: Any) -> int:
        """Ask for a goal; returns the number of the request, as the following ones."""
        return self.goal.send_request(request)

    def send_cancel_request(self, request: Any) -> int:
        """Ask to cancel goals."""
        return self._cancel.send_request(request)

    def send_result_request(self, request: Any) -> int:
        """Ask for the result of a goal."""
        return self._result.send_request(request)

    def _take_response(self, part: str, kind: type[Any]) -> tuple[int, Any] | tuple[None, None]:
        """The number of the request, and the response; (None, None) if there is none."""
        info, response = vars(self)[part].take_response(kind)
        return (None, None) if info is None else (info.request_id.sequence_number, response)

    take_goal_response = partialmethod(_take_response, "goal")
    take_cancel_response = partialmethod(_take_response, "_cancel")
    take_result_response = partialmethod(_take_response, "_result")

    def _take_message(self, part: str, kind: type[Any]) -> Any:
        """The oldest message of a topic; None if there is none."""
        message = vars(self)[part].take_message(kind, False)
        return None if message is None else message[0]

    take_feedback = partialmethod(_take_message, "_feedback")
    take_status = partialmethod(_take_message, "_status")

    def configure_introspection(self, clock: Clock, profile: Profile | None, state: IntrospectionState) -> None:
        """Publish what its services send and receive from now on, or no more."""
        for part in (self.goal, self._cancel, self._result):
            part.configure_introspection(clock, profile or Profile(), state)

    def get_num_entities(self) -> tuple[int, int, int, int, int]:
        """How many subscriptions, guard conditions, timers, clients and services it waits for."""
        return 2, 0, 0, 3, 0

    def add_to_waitset(self, wait_set: WaitSet) -> None:
        """Wait for all of it."""
        subscriptions = [wait_set.add_subscription(subscription) for subscription in (self._feedback, self._status)]
        clients = [wait_set.add_client(client) for client in (self.goal, self._cancel, self._result)]
        self._indices = subscriptions, clients

    def is_ready(self, wait_set: WaitSet) -> tuple[bool, ...]:
        """Whether there is feedback, a status, a response to a goal, to a cancellation, a result."""
        subscriptions, clients = self._indices
        heard = [wait_set.is_ready("subscription", index) for index in subscriptions]
        return (*heard, *(wait_set.is_ready("client", index) for index in clients))
