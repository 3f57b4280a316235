"""Action servers of the simulated world, which decides on goals, feedback and results.

`WorldNode.serve_action` makes a `ServedAction`. The testbench's function `execute` gets each accepted goal as a
`ServedGoal` and may block in simulated time, so a fake of navigation is a function of a few lines.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2Error, RosServedGoal
from pytest_hricdv.extra.ros2.actions import ActionGoalHandle, ActionServer, GoalEvent, GoalState
from pytest_hricdv.extra.ros2.clocks import Clock, ClockType
from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.qos import ACTION_STATUS, Profile
from pytest_hricdv.extra.ros2.services import RequestId
from pytest_hricdv.extra.ros2.wait_set import WaitSet
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import US_PER_S
from pytest_hricdv.runtime.kernel import Node as KernelNode

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_KEEPS_S = 900.0
"""Time (s) for which a result is kept, as in `rcl_action_server_get_default_options`."""

_REJECTED = 1
"""Return code of a cancellation that is refused: `ERROR_REJECTED` of `action_msgs/srv/CancelGoal`."""

Execute = Callable[["ServedGoal"], object]
"""The testbench's function that serves a goal. It runs in a node of its own, and may block."""


class ServedGoal(RosServedGoal):
    """A goal that the world has accepted. `execute` gets it; other nodes of the world may end it, too."""

    def __init__(self, action: ServedAction, goal_id: Any, request: Any, handle: ActionGoalHandle) -> None:
        self.request = request
        """The goal's message, such as a `NavigateToPose.Goal`."""
        self.goal_id = goal_id
        self._action, self._handle = action, handle
        self.result: Any = None
        self._waiting: list[KernelNode] = []
        self.asked: list[RequestId] = []
        """The requests that wait for its result."""

    def empty_result(self) -> Any:
        """An empty result."""
        return self._action.kind.Result()

    @property
    def status(self) -> GoalState:
        """Its state, as `action_msgs/msg/GoalStatus` numbers them."""
        return GoalState(self._handle.get_status())

    @property
    def is_over(self) -> bool:
        return not self._handle.is_active()

    @property
    def is_canceling(self) -> bool:
        return self.status is GoalState.CANCELING

    def wait(self, timeout_s: float) -> bool:
        kernel = self._action.kernel
        end_us = kernel.now_us + round(timeout_s * US_PER_S)
        while not (self.is_over or self.is_canceling):
            if kernel.now_us >= end_us:
                return False
            self._waiting.append(kernel.current())
            try:
                kernel.block((end_us - kernel.now_us) / US_PER_S)
            finally:
                self._waiting.remove(kernel.current())
        return True

    def feedback(self, **fields: Any) -> None:
        self._action.publish_feedback(self, fields)

    def succeed(self, **fields: Any) -> None:
        self._end(GoalEvent.SUCCEED, fields)

    def abort(self, **fields: Any) -> None:
        self._end(GoalEvent.ABORT, fields)

    def cancel(self, **fields: Any) -> None:
        self._end(GoalEvent.CANCELED, fields)

    def _end(self, event: GoalEvent, fields: dict[str, Any]) -> None:
        result = _fill(self.empty_result(), fields)
        self.change(event)
        self.result = result
        self._action.is_done(self)

    def change(self, event: GoalEvent) -> None:
        """Go on to the next state. Raises RCLError for an event that its state does not have."""
        self._handle.update_goal_state(event)
        self._action.server.publish_status()
        for node in self._waiting:
            node.kernel.wake(node)


def _fill(message: Any, fields: dict[str, Any]) -> Any:
    """A message with these fields set. Raises AttributeError for a name that is none of them."""
    for name, value in fields.items():
        if name not in message.get_fields_and_field_types():
            raise AttributeError(f"{type(message).__name__} has no field {name!r}")
        setattr(message, name, value)
    return message


class ServedAction:
    """An action that a node of the world serves, from now on.

    Args:
        kind: class of the action.
        execute: called with each goal that was accepted, in a node of the kernel of its own. It ends the goal.
        accept: whether a goal is accepted, by its message.
        may_cancel: whether a goal is cancelled when a client asks for it.

    Raises:
        ValueError: a wrong name.
    """

    def __init__(
        self,
        node: GraphNode,
        name: str,
        kind: Any,
        execute: Execute,
        accept: Callable[[Any], bool],
        may_cancel: Callable[[ServedGoal], bool],
    ) -> None:
        self.kernel: Kernel = node.kernel
        self.kind = kind
        self._name, self._node_name = name, node.get_node_name()
        self._execute, self._accept, self._may_cancel = execute, accept, may_cancel
        self._impl = kind.Impl
        profiles = (Profile(), Profile(), Profile(), Profile(), ACTION_STATUS)
        clock = Clock(ClockType.STEADY_TIME, self.kernel)
        self.server = ActionServer(node, clock, kind, node.resolve(name), *profiles, _KEEPS_S)
        self._goals: dict[bytes, ServedGoal] = {}
        self.kernel.spawn(f"{self._node_name}: {name}", self._serve)

    def _serve(self) -> None:
        while True:
            waiting = WaitSet()
            self.server.add_to_waitset(waiting)
            waiting.wait(-1)
            is_goal, is_cancel, is_result, is_expired = self.server.is_ready(waiting)
            if is_goal:
                self._take_goal()
            if is_cancel:
                self._take_cancel()
            if is_result:
                self._take_result()
            if is_expired:
                for info in self.server.expire_goals(len(self._goals)):
                    del self._goals[bytes(info.goal_id.uuid)]

    def _take_goal(self) -> None:
        header, request = self.server.take_goal_request(self._impl.SendGoalService.Request)
        if header is None or request is None:
            return
        response = self._impl.SendGoalService.Response()
        key = bytes(request.goal_id.uuid)
        response.accepted = key not in self._goals and bool(self._accept(request.goal))
        goal = self._accept_goal(request) if response.accepted else None
        self.server.send_goal_response(header, response)
        if goal is not None:
            self._goals[key] = goal
            self.server.publish_status()
            self.kernel.spawn(f"{self._node_name}: a goal of {self._name}", lambda: self._run(goal))

    def _accept_goal(self, request: Any) -> ServedGoal:
        info = self._impl.CancelGoalService.Request().goal_info
        info.goal_id = request.goal_id
        info.stamp.sec, rest_us = divmod(self.kernel.now_us, US_PER_S)
        info.stamp.nanosec = rest_us * 1000
        return ServedGoal(self, request.goal_id, request.goal, ActionGoalHandle(self.server, info))

    def _run(self, goal: ServedGoal) -> None:
        if goal.status is GoalState.ACCEPTED:  # otherwise it was cancelled in between
            goal.change(GoalEvent.EXECUTE)
        self._execute(goal)
        if not goal.is_over:
            raise Ros2Error(
                f"{self._node_name}: what executes goals of {self._name} has returned, but the goal is not over: call "
                "goal.succeed(...), goal.abort(...), or, if goal.is_canceling, goal.cancel(...) before"
            )

    def _take_cancel(self) -> None:
        header, request = self.server.take_cancel_request(self._impl.CancelGoalService.Request)
        if header is None or request is None:
            return
        response = self.server.process_cancel_request(request, self._impl.CancelGoalService.Response)
        infos = response.goals_canceling
        goals = [(info, goal) for info in infos if self._may_cancel(goal := self._goals[bytes(info.goal_id.uuid)])]
        for _, goal in goals:
            goal.change(GoalEvent.CANCEL_GOAL)
        response.goals_canceling = [info for info, _ in goals]
        if infos and not goals:
            response.return_code = _REJECTED
        self.server.send_cancel_response(header, response)

    def _take_result(self) -> None:
        header, request = self.server.take_result_request(self._impl.GetResultService.Request)
        if header is None or request is None:
            return
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            self.server.send_result_response(header, self._impl.GetResultService.Response())  # status unknown
        elif goal.is_over:
            self._answer(goal, header)
        else:
            goal.asked.append(header)

    def _answer(self, goal: ServedGoal, header: RequestId) -> None:
        response = self._impl.GetResultService.Response()
        response.status, response.result = int(goal.status), goal.result
        self.server.send_result_response(header, response)

    def is_done(self, goal: ServedGoal) -> None:
        """Deliver the result to those who wait; called when a goal is over."""
        self.server.notify_goal_done()
        for header in goal.asked:
            self._answer(goal, header)
        goal.asked.clear()

    def publish_feedback(self, goal: ServedGoal, fields: dict[str, Any]) -> None:
        """Publish feedback of a goal that has these fields."""
        message = self._impl.FeedbackMessage()
        message.goal_id = goal.goal_id
        _fill(message.feedback, fields)
        self.server.publish_feedback(message)
