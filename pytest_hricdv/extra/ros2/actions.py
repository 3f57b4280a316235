"""Actions: what a goal goes through, and the names of the services and topics that an action is made of.

As the ROS 2 design article "Actions" says.
"""

from __future__ import annotations

from enum import IntEnum


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
