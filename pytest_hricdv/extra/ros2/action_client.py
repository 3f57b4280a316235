"""Action clients of `rclpy`."""

from __future__ import annotations

from typing import Any

from pytest_hricdv.extra.ros2.actions import part_names
from pytest_hricdv.extra.ros2.clocks import Clock
from pytest_hricdv.extra.ros2.contexts import Node
from pytest_hricdv.extra.ros2.handles import Destroyable
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import Client, IntrospectionState
from pytest_hricdv.extra.ros2.topics import Subscription
from pytest_hricdv.extra.ros2.wait_set import WaitSet


class ActionClient(Destroyable):
    """As `rcl_action_client_t`. Raises ValueError for a wrong name."""

    def __init__(
        self,
        node: Node,
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
        self._feedback = Subscription(node, types.FeedbackMessage, names["feedback"], feedback)
        self._status = Subscription(node, types.GoalStatusMessage, names["status"], status)
        self._indices: tuple[list[int], list[int]] = ([], [])

    def destroy(self) -> None:
        """Leave the graph."""
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

    def take_goal_response(self, kind: type[Any]) -> tuple[int, Any] | tuple[None, None]:
        """The number of the request, and the response; (None, None) if there is none, as of the following ones."""
        return self._take(self.goal, kind)

    def take_cancel_response(self, kind: type[Any]) -> tuple[int, Any] | tuple[None, None]:
        """Likewise of a cancellation."""
        return self._take(self._cancel, kind)

    def take_result_response(self, kind: type[Any]) -> tuple[int, Any] | tuple[None, None]:
        """Likewise of a result."""
        return self._take(self._result, kind)

    @staticmethod
    def _take(client: Client, kind: type[Any]) -> tuple[int, Any] | tuple[None, None]:
        info, response = client.take_response(kind)
        return (None, None) if info is None else (info.request_id.sequence_number, response)

    def take_feedback(self, kind: type[Any]) -> Any:
        """The oldest feedback; None if there is none."""
        taken = self._feedback.take_message(kind, False)
        return None if taken is None else taken[0]

    def take_status(self, kind: type[Any]) -> Any:
        """The oldest status; None if there is none."""
        taken = self._status.take_message(kind, False)
        return None if taken is None else taken[0]

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
