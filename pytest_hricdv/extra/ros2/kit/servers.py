"""Fakes of servers around a node: Nav2's actions, a trajectory controller of ros2_control, and managed nodes.

Testbenches import `Navigation`, `JointTrajectoryFollower` and `ManagedNode` from `pytest_hricdv.ros2`.
"""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.kit.base import PlanarBase, PlanarPose, heading_rad, quaternion, stamp
from pytest_hricdv.extra.ros2.lifecycle import LifecycleStateMachine, Transition
from pytest_hricdv.extra.ros2.messages import import_type, set_stamp
from pytest_hricdv.extra.ros2.world import StartedSystem
from pytest_hricdv.extra.ros2.world_action_server import ServedGoal

_STEP_S = 0.1
"""Period of feedback (s). Nav2 sends it at each tick of its behaviour tree, every 10 ms; fewer keep records short."""

_WAYPOINT_FAILED = 3
"""`FAILED` of `nav2_msgs/msg/WaypointStatus`."""

Reaches = Callable[[PlanarPose], bool]
"""Whether a base can reach a pose."""


def set_those_there_are(message: Any, **values: Any) -> None:
    """Set the fields that this version of a message has: messages of Nav2 differ between distributions."""
    there_are = message.get_fields_and_field_types()
    for name, value in values.items():
        if name in there_are:
            setattr(message, name, value)


class Navigation:
    """Nav2's servers of a base, which goes straight, at one speed, through walls, and turns in no time.

    A new goal aborts the one that the base goes to, as in Nav2. A goal that the base cannot reach is aborted after half
    of the way.

    Args:
        system: the system of `run.ros2`.
        base: the base that is driven; None: only a pose is moved.
        speed_m_s: the speed of the base. 0.26 m/s is the default of Nav2's controllers for a TurtleBot 3.
        reaches: whether the base can reach a pose.
        node: the name of the server in the graph.
    """

    def __init__(
        self,
        system: StartedSystem,
        base: PlanarBase | None = None,
        *,
        speed_m_s: float = 0.26,
        reaches: Reaches = lambda pose: True,
        node: str = "bt_navigator",
    ) -> None:
        self._system, self._base, self._speed_m_s, self._reaches = system, base, speed_m_s, reaches
        self._pose = PlanarPose()
        self._world = system.node(node)
        self._going: ServedGoal | None = None

    @property
    def pose(self) -> PlanarPose:
        """The pose of the base."""
        return self._pose if self._base is None else self._base.pose

    def _go(self, pose: PlanarPose) -> None:
        self._pose = pose
        if self._base is not None:
            self._base.pose = pose

    def navigate_to_pose(self, name: str = "/navigate_to_pose") -> Navigation:
        """Serve `nav2_msgs/action/NavigateToPose`. Raises Ros2Error if `nav2_msgs` is missing."""
        self._world.serve_action(name, "nav2_msgs/action/NavigateToPose", self._navigate)
        return self

    def follow_waypoints(self, name: str = "/follow_waypoints") -> Navigation:
        """Serve `nav2_msgs/action/FollowWaypoints`. Raises Ros2Error if `nav2_msgs` is missing."""
        self._world.serve_action(name, "nav2_msgs/action/FollowWaypoints", self._follow)
        return self

    def _navigate(self, goal: ServedGoal) -> None:
        self._take_over(goal)
        if self._drive(goal, goal.request.pose.pose, self._tell_distance):
            goal.succeed()
        elif goal.is_canceling:
            goal.cancel()
        elif not goal.is_over:
            goal.abort()

    def _follow(self, goal: ServedGoal) -> None:
        self._take_over(goal)
        missed = []
        for index, stamped in enumerate(goal.request.poses):
            goal.feedback(current_waypoint=index)
            if not self._drive(goal, stamped.pose, lambda *_: None):
                if goal.is_over:
                    return
                if goal.is_canceling:
                    break
                missed.append((index, stamped))
        end = goal.cancel if goal.is_canceling else goal.succeed
        end(missed_waypoints=_misses(goal, missed))

    def _take_over(self, goal: ServedGoal) -> None:
        former, self._going = self._going, goal
        if former is not None and not former.is_over:
            former.abort()

    def _drive(self, goal: ServedGoal, wanted: Any, tell: Callable[[ServedGoal, float, float], None]) -> bool:
        """Drive to a pose; whether it is reached. Otherwise the goal is cancelled or over, or it cannot be reached."""
        target = PlanarPose(wanted.position.x, wanted.position.y, heading_rad(wanted.orientation))
        reaches, began_s = self._reaches(target), self._system.kernel.now_s
        way_m = math.dist((self.pose.x_m, self.pose.y_m), (target.x_m, target.y_m))
        stays_m = 0.0 if reaches else way_m / 2
        while (left_m := math.dist((self.pose.x_m, self.pose.y_m), (target.x_m, target.y_m))) > stays_m + 1e-9:
            tell(goal, left_m, self._system.kernel.now_s - began_s)
            step_s = min(_STEP_S, (left_m - stays_m) / self._speed_m_s)
            if goal.wait(step_s):
                return False
            bearing_rad = math.atan2(target.y_m - self.pose.y_m, target.x_m - self.pose.x_m)
            ahead = PlanarPose(self.pose.x_m, self.pose.y_m, bearing_rad)
            self._go(ahead.move(self._speed_m_s, 0.0, 0.0, step_s))
        if reaches:
            self._go(target)
        return reaches

    def _tell_distance(self, goal: ServedGoal, left_m: float, gone_s: float) -> None:
        pose = import_type("geometry_msgs/msg/PoseStamped", "msg")()
        stamp(pose.header, self._system, "map")
        pose.pose.position.x, pose.pose.position.y = self.pose.x_m, self.pose.y_m
        pose.pose.orientation = quaternion(self.pose.heading_rad)
        goal.feedback(
            current_pose=pose,
            distance_remaining=left_m,
            navigation_time=duration(gone_s),
            estimated_time_remaining=duration(left_m / self._speed_m_s),
        )


def _misses(goal: ServedGoal, missed: list[tuple[int, Any]]) -> Any:
    """The missed poses as this version of the message has them: indices in humble, messages since."""
    result = goal.empty_result()
    if isinstance(result.missed_waypoints, array.array):
        return [index for index, _ in missed]
    kind = result.get_fields_and_field_types()["missed_waypoints"].removeprefix("sequence<").removesuffix(">")
    package, _, name = kind.partition("/")
    entries = []
    for index, stamped in missed:
        entry = import_type(f"{package}/msg/{name}", "msg")()
        set_those_there_are(entry, index=index, goal=stamped, waypoint_index=index, waypoint_pose=stamped)
        set_those_there_are(entry, waypoint_status=_WAYPOINT_FAILED)
        entries.append(entry)
    return entries


def duration(seconds: float) -> Any:
    """A `builtin_interfaces/msg/Duration`."""
    made = import_type("builtin_interfaces/msg/Duration", "msg")()
    set_stamp(made, round(seconds * 1e9))
    return made


_INVALID_GOAL = -1
"""`INVALID_GOAL` of `control_msgs/action/FollowJointTrajectory`."""


class JointTrajectoryFollower:
    """A controller whose joints are where the trajectory says, exactly and at each instant.

    As ros2_control's, it rejects a trajectory of other joints, with points of other lengths, or whose times do not
    increase; holds where it is when a goal is cancelled; and aborts the present goal when another one comes.

    Args:
        system: the system of `run.ros2`.
        joints: names -> where they begin (rad or m).
        name: the name of the action.
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
        """The positions of the joints (rad or m)."""
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
        actual = import_type("trajectory_msgs/msg/JointTrajectoryPoint", "msg")()
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


class ManagedNode:
    """A managed node without content: its services, and the transitions that it goes through.

    Args:
        system: the system of `run.ros2`.
        name: the node's name, in the namespace "/".
        on_transition: called with "configure", "activate", "deactivate", "cleanup" or "shutdown"; whether it
            succeeds. It may block: the transition lasts as long.

    Raises:
        Ros2Error: `lifecycle_msgs` is missing.
    """

    def __init__(
        self, system: StartedSystem, name: str, on_transition: Callable[[str], bool] = lambda label: True
    ) -> None:
        self._system, self._on_transition = system, on_transition
        world = system.node(name)
        self._machine = LifecycleStateMachine(world.graph_node, False)
        self._events = world.publisher(f"/{name}/transition_event", "lifecycle_msgs/msg/TransitionEvent")
        graph = self._machine.transition_graph
        for service, kind, answer in (
            ("change_state", "ChangeState", self._change),
            ("get_state", "GetState", self._tell_state),
            ("get_available_states", "GetAvailableStates", self._tell_states),
            (
                "get_available_transitions",
                "GetAvailableTransitions",
                self._answer_with(lambda: self._machine.available_transitions),
            ),
            ("get_transition_graph", "GetAvailableTransitions", self._answer_with(lambda: graph)),
        ):
            world.serve(f"/{name}/{service}", f"lifecycle_msgs/srv/{kind}", answer)

    @property
    def state(self) -> str:
        """The label of its state, as "active"."""
        return self._machine.current_state[1]

    def _change(self, request: Any, response: Any) -> Any:
        wanted, machine = request.transition, self._machine
        possible = machine.available_transitions
        label = wanted.label or next((label for number, label, *_ in possible if number == wanted.id), "")
        try:
            self._go(label)
        except RCLError:
            response.success = False  # as `rcl_lifecycle` answers
            return response
        response.success = self._on_transition(label)
        self._go("transition_success" if response.success else "transition_failure")
        return response

    def _go(self, label: str) -> None:
        before = self._machine.current_state
        number = self._machine.get_transition_by_label(label)
        self._machine.trigger_transition_by_label(label, False)
        event = import_type("lifecycle_msgs/msg/TransitionEvent", "msg")(timestamp=system_ns(self._system.kernel))
        event.transition.id, event.transition.label = number, label
        event.start_state.id, event.start_state.label = before
        event.goal_state.id, event.goal_state.label = self._machine.current_state
        self._events.publish(event)

    def _tell_state(self, request: Any, response: Any) -> Any:
        response.current_state.id, response.current_state.label = self._machine.current_state
        return response

    def _tell_states(self, request: Any, response: Any) -> Any:
        kind = import_type("lifecycle_msgs/msg/State", "msg")
        response.available_states = [kind(id=number, label=label) for number, label in self._machine.available_states]
        return response

    def _answer_with(self, transitions: Callable[[], Iterable[Transition]]) -> Callable[[Any, Any], Any]:
        def tell(request: Any, response: Any) -> Any:
            response.available_transitions = [_description(transition) for transition in transitions()]
            return response

        return tell


def _description(transition: Transition) -> Any:
    described = import_type("lifecycle_msgs/msg/TransitionDescription", "msg")()
    described.transition.id, described.transition.label = transition[:2]
    described.start_state.id, described.start_state.label = transition[2:4]
    described.goal_state.id, described.goal_state.label = transition[4:]
    return described
