"""Stands in for an arm's controller: `follow_joint_trajectory` of ros2_control, with positions between the points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from pytest_hricdv.extra.ros2.kit.navigation import set_those_there_are
from pytest_hricdv.extra.ros2.vocabulary import loaded
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.extra.ros2.world_action_server import ServedGoal

_INVALID_GOAL = -1
"""`INVALID_GOAL` of `control_msgs/action/FollowJointTrajectory`."""


class JointTrajectoryFollower:
    """A controller whose joints are where the trajectory says, exactly and at each instant.

    As ros2_control's, it rejects a trajectory of other joints, with points of other lengths, or whose times do not
    increase; holds where it is when a goal is cancelled; and aborts the present goal when another one comes.

    Args:
        system: of `run.ros2`.
        joints: names -> where they begin (rad or m).
        name: of the action.
        period_s: between two feedbacks. 20 Hz, the default of ros2_control's `action_monitor_rate`.
        node: its name in the graph.

    Raises:
        Ros2Error: `control_msgs` is missing.
    """

    def __init__(
        self,
        system: StartedSystem,
        joints: Mapping[str, float],
        *,
        name: str = "/arm_controller/follow_joint_trajectory",
        period_s: float = 0.05,
        node: str = "arm_controller",
    ) -> None:
        self._system, self._period_s = system, period_s
        self.positions = dict(joints)
        """Where the joints are (rad or m)."""
        self._moving: ServedGoal | None = None
        action = "control_msgs/action/FollowJointTrajectory"
        system.node(node).serve_action(name, action, self._follow, accept=self._accepts)

    def _accepts(self, goal: Any) -> bool:
        names, points = goal.trajectory.joint_names, goal.trajectory.points
        times_s = [_seconds(point) for point in points]
        fits = all(len(point.positions) == len(names) for point in points)
        return sorted(names) == sorted(self.positions) and fits and bool(points) and _increase(times_s)

    def _follow(self, goal: ServedGoal) -> None:
        former, self._moving = self._moving, goal
        if former is not None and not former.is_over:
            former.abort(error_code=_INVALID_GOAL, error_string="another goal has come")
        trajectory, kernel = goal.request.trajectory, self._system.kernel
        names, began_s = [*trajectory.joint_names], kernel.now_s
        points = [(0.0, [self.positions[name] for name in names])]
        points += [(_seconds(point), [*point.positions]) for point in trajectory.points]
        while (now_s := kernel.now_s - began_s) < points[-1][0]:
            self._tell(goal, names)
            if goal.wait(min(self._period_s, points[-1][0] - now_s)):
                self._move(names, _between(points, kernel.now_s - began_s))
                if goal.is_canceling:
                    goal.cancel()
                return
            self._move(names, _between(points, kernel.now_s - began_s))
        self._move(names, points[-1][1])
        goal.succeed()

    def _move(self, names: Sequence[str], positions: Sequence[float]) -> None:
        self.positions.update(zip(names, positions, strict=True))

    def _tell(self, goal: ServedGoal, names: Sequence[str]) -> None:
        actual = loaded("trajectory_msgs/msg/JointTrajectoryPoint", "msg")()
        set_those_there_are(actual, positions=[self.positions[name] for name in names])
        goal.feedback(joint_names=[*names], actual=actual, desired=actual)


def _seconds(point: Any) -> float:
    return float(point.time_from_start.sec + point.time_from_start.nanosec * 1e-9)


def _increase(times_s: Sequence[float]) -> bool:
    return all(before < after for before, after in pairwise(times_s)) and min(times_s) >= 0.0


def _between(points: Sequence[tuple[float, Sequence[float]]], now_s: float) -> list[float]:
    """The positions at a time, on straight lines between the points."""
    for (start_s, start), (end_s, end) in pairwise(points):
        if now_s < end_s:
            share = (now_s - start_s) / (end_s - start_s)
            return [one + share * (other - one) for one, other in zip(start, end, strict=True)]
    return [*points[-1][1]]
