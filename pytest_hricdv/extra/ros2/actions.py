"""Simulates the action clients and servers of `rclpy`, after the ROS 2 design article "Actions".

`extension` gives `rclpy` the classes `ActionClient`, `ActionServer` and `ActionGoalHandle`, which have a goal's state
machine. An action consists of three `services` and two `topics`, whose names `part_names` lists. The simulated world
serves actions with the same classes (`world_action_server`).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import partialmethod
from typing import Any

from pytest_hricdv.extra.ros2.clocks import Clock, RosTimer
from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.handles import Destroyable, RCLError
from pytest_hricdv.extra.ros2.messages import NS_PER_S, stamp_ns
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import Client, IntrospectionState, RequestId, ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher, TopicSubscription
from pytest_hricdv.extra.ros2.wait_set import WaitSet


class GoalEvent(IntEnum):
    """What changes the state of a goal, numbered like `rcl_action_goal_event_t`."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


class GoalState(IntEnum):
    """The states of a goal, numbered as in `action_msgs/msg/GoalStatus`."""

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
"""The state machine of a goal: its state and an event -> its next state; other events are errors."""


def part_names(action: str) -> dict[str, str]:
    """Part of an action, such as `send_goal` -> the full name of its service or topic."""
    parts = ("send_goal", "get_result", "cancel_goal", "feedback", "status")
    return {part: f"{action}/_action/{part}" for part in parts}


class ActionClient(Destroyable):
    """Like `rcl_action_client_t`. Raises ValueError for a wrong name."""

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
        """The numbers of subscriptions, guard conditions, timers, clients and services it waits for."""
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


_UNKNOWN_GOAL, _GOAL_OVER = 2, 3
"""Return codes of `action_msgs/srv/CancelGoal`."""


def _key(goal_info: Any) -> bytes:
    return bytes(goal_info.goal_id.uuid)


@dataclass
class _Goal:
    """A goal that was accepted, and when it was over (ns of the server's clock)."""

    info: Any
    state: GoalState = GoalState.ACCEPTED
    over_ns: int | None = None

    @property
    def is_active(self) -> bool:
        return self.state <= GoalState.CANCELING

    @property
    def may_be_canceled(self) -> bool:
        return (self.state, GoalEvent.CANCEL_GOAL) in NEXT_STATE


class ActionServer(Destroyable):
    """Like `rcl_action_server_t`.

    Args:
        result_timeout: how long the result of a goal that is over is kept (s; negative: for ever).

    Raises:
        ValueError: a wrong name.
    """

    def __init__(
        self,
        node: GraphNode,
        clock: Clock,
        kind: Any,
        name: str,
        goal: Profile,
        result: Profile,
        cancel: Profile,
        feedback: Profile,
        status: Profile,
        result_timeout: float,
    ) -> None:
        super().__init__(node.kernel)
        names, types = part_names(name), kind.Impl
        self._types = types
        self._clock = clock
        self._goal = ServiceServer(node, types.SendGoalService, names["send_goal"], goal)
        self._cancel = ServiceServer(node, types.CancelGoalService, names["cancel_goal"], cancel)
        self._result = ServiceServer(node, types.GetResultService, names["get_result"], result)
        self._feedback = Publisher(node, types.FeedbackMessage, names["feedback"], feedback)
        self._status = Publisher(node, types.GoalStatusMessage, names["status"], status)
        self._keeps_ns = None if result_timeout < 0 else round(result_timeout * NS_PER_S)
        self._expiry = RosTimer(clock, node.context, self._keeps_ns or 0, autostart=False)
        self._goals: dict[bytes, _Goal] = {}
        self._indices: tuple[list[int], int] = ([], 0)

    def destroy(self) -> None:
        for entity in (self._goal, self._cancel, self._result, self._feedback, self._status, self._expiry):
            entity.destroy_when_not_in_use()

    def _take(self, part: str, kind: type[Any]) -> tuple[RequestId, Any] | tuple[None, None]:
        """Take the oldest request: its id and the request; (None, None) if there is none."""
        request, info = vars(self)[part].service_take_request(kind)
        return (None, None) if info is None else (info.request_id, request)

    take_goal_request = partialmethod(_take, "_goal")
    take_cancel_request = partialmethod(_take, "_cancel")
    take_result_request = partialmethod(_take, "_result")

    def _respond(self, part: str, header: RequestId, response: Any) -> None:
        """Answer a request."""
        vars(self)[part].service_send_response(response, header)

    send_goal_response = partialmethod(_respond, "_goal")
    send_cancel_response = partialmethod(_respond, "_cancel")
    send_result_response = partialmethod(_respond, "_result")

    def publish_feedback(self, message: Any) -> None:
        """Publish how far a goal is."""
        self._feedback.publish(message)

    def publish_status(self) -> None:
        """Publish the states of all goals."""
        array = self._types.GoalStatusMessage()
        from action_msgs.msg import GoalStatus  # type: ignore[import-not-found, unused-ignore]

        array.status_list = [GoalStatus(goal_info=goal.info, status=int(goal.state)) for goal in self._goals.values()]
        self._status.publish(array)

    def accept(self, goal_info: Any) -> _Goal:
        """Have a new goal. Raises RCLError for one that is there already."""
        if self.goal_exists(goal_info):
            raise RCLError("Failed to accept new goal: goal ID already exists")
        goal = self._goals[_key(goal_info)] = _Goal(goal_info)
        return goal

    def goal_exists(self, goal_info: Any) -> bool:
        """Whether it has a goal with this id."""
        return _key(goal_info) in self._goals

    def process_cancel_request(self, request: Any, response_type: type[Any]) -> Any:
        """The goals that a request means: by id, all up to a time, or all; and whether any of them is known."""
        response = response_type()
        key, until_ns = _key(request.goal_info), stamp_ns(request.goal_info.stamp)
        # action_msgs/srv/CancelGoal: an id of zeros and a time of 0 say nothing. Only an id: that goal. Only a time:
        # all up to it. Both: that goal, and all up to the time. Neither: all.
        has_key = any(key)
        if has_key and not until_ns:
            goal = self._goals.get(key)
            if goal is not None and goal.may_be_canceled:
                response.goals_canceling = [goal.info]
            else:
                response.return_code = _UNKNOWN_GOAL if goal is None else _GOAL_OVER
            return response
        every = not has_key and not until_ns
        response.goals_canceling = [
            goal.info
            for name, goal in self._goals.items()
            if goal.may_be_canceled and (every or name == key or stamp_ns(goal.info.stamp) <= until_ns)
        ]
        return response

    def notify_goal_done(self) -> None:
        """Note that goals are over: their results are forgotten some time after."""
        now_ns = self._clock.now_ns()
        for goal in self._goals.values():
            if not goal.is_active and goal.over_ns is None:
                goal.over_ns = now_ns
        self._set_expiry()

    def _set_expiry(self) -> None:
        over_ns = [goal.over_ns for goal in self._goals.values() if goal.over_ns is not None]
        if self._keeps_ns is None or not over_ns:
            self._expiry.cancel_timer()
            return
        # Not below 0: a result may be overdue, as it is checked only when the executor spins.
        self._expiry.change_timer_period(max(min(over_ns) + self._keeps_ns - self._clock.now_ns(), 0))
        self._expiry.reset_timer()

    def expire_goals(self, max_num_goals: int) -> tuple[Any, ...]:
        """Forget at most `max_num_goals` goals whose results were kept long enough; returns their infos."""
        now_ns, keeps_ns = self._clock.now_ns(), self._keeps_ns
        expired = [
            key
            for key, goal in self._goals.items()
            if keeps_ns is not None and goal.over_ns is not None and goal.over_ns + keeps_ns <= now_ns
        ]
        infos = tuple(self._goals.pop(key).info for key in expired[:max_num_goals])
        self._set_expiry()
        return infos

    def configure_introspection(self, clock: Clock, profile: Profile | None, state: IntrospectionState) -> None:
        """Publish what its services send and receive from now on, or no more."""
        for part in (self._goal, self._cancel, self._result):
            part.configure_introspection(clock, profile or Profile(), state)

    def get_num_entities(self) -> tuple[int, int, int, int, int]:
        """The numbers of subscriptions, guard conditions, timers, clients and services it waits for."""
        return 0, 0, 1, 0, 3

    def add_to_waitset(self, wait_set: WaitSet) -> None:
        """Wait for all of it."""
        services = [wait_set.add_service(service) for service in (self._goal, self._cancel, self._result)]
        self._indices = services, wait_set.add_timer(self._expiry)

    def is_ready(self, wait_set: WaitSet) -> tuple[bool, ...]:
        """Whether there is a goal, a cancellation, a request for a result, a goal to forget."""
        services, timer = self._indices
        asked = [wait_set.is_ready("service", index) for index in services]
        return (*asked, wait_set.is_ready("timer", timer))


class ActionGoalHandle(Destroyable):
    """Like `rcl_action_goal_handle_t`. Raises RCLError for a goal that the server has already."""

    def __init__(self, server: ActionServer, goal_info: Any) -> None:
        super().__init__(server.kernel)
        self._goal = server.accept(goal_info)

    def get_status(self) -> int:
        return int(self._goal.state)

    def is_active(self) -> bool:
        return self._goal.is_active

    def update_goal_state(self, event: GoalEvent) -> None:
        """Go on to the next state. Raises RCLError for an event that its state does not have."""
        state = NEXT_STATE.get((self._goal.state, event))
        if state is None:
            raise RCLError(f"Failed to update goal state: {self._goal.state.name} has no {event.name}")
        self._goal.state = state
