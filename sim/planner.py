"""Ways of the arm: straight in joint space from pose to pose, timed below a joint speed, checked for obstacles.

Whether a way is free is looked at in a scene of its own, which is closed again, so that planning never touches the
running world. The answer depends on start (to a milliradian) and waypoints only, and is kept for the process.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from controller.ports import ARM_JOINTS, JointPose, PlanningError
from sim.engine import Engine, SimulationError, bullet
from sim.fingers import Fingers
from sim.furniture import furnish
from sim.physics_time import STEP_S
from sim.torso import Torso

SPEED_SHARE = 0.96
"""The fastest joint moves at this share of the allowed speed."""

SAMPLE_RAD = 0.04
"""Between two looks at the arm no joint turns further than this: at most 3 cm at the fingertips."""

CLEARANCE_M = 0.02
"""Nearest that the left arm may come to table, bin or torso."""

SETTLE_S = 0.15
"""What a joint motor takes, beyond the planned time, to stand (its gain makes the last bit exponential)."""

ARM_LINKS = ("left_elbow_flex", "left_wrist_pronation", "left_wrist_abduction", "left_wrist_flex")
TORSO_LINKS = ("hip_flexor",)
"""Links that the left arm must not meet: the braced neck, head and right arm are part of the hip flexor's link."""


@dataclass(frozen=True)
class Segment:
    """A straight piece of a way: all joints start and arrive together."""

    goal: JointPose
    duration_s: float


@dataclass(frozen=True)
class ArmPath:
    """A planned way; a `controller.ports.Path`."""

    start: JointPose
    segments: tuple[Segment, ...]

    @property
    def duration_s(self) -> float:
        """How long following it takes, with the stop at the end of each segment."""
        return sum(segment.duration_s + SETTLE_S for segment in self.segments)


def time_path(start: JointPose, waypoints: Sequence[JointPose], max_speed_rad_s: float) -> ArmPath:
    """The path from `start` through `waypoints` (rad) with its fastest joint at SPEED_SHARE of `max_speed_rad_s`.

    Raises:
        PlanningError: no waypoints, a waypoint that is not nine finite angles, or a speed that is not above 0.
    """
    if not (math.isfinite(max_speed_rad_s) and max_speed_rad_s > 0.0):
        raise PlanningError(f"cannot plan for a joint speed of {max_speed_rad_s!r} rad/s: expected more than 0")
    if not waypoints:
        raise PlanningError("cannot plan a way without waypoints")
    segments = []
    here = start
    for waypoint in waypoints:
        goal = tuple(waypoint)
        if len(goal) != len(ARM_JOINTS) or not all(math.isfinite(angle) for angle in goal):
            raise PlanningError(f"waypoint {goal} is not {len(ARM_JOINTS)} finite angles")
        farthest = max(abs(g - h) for g, h in zip(goal, here, strict=True))
        segments.append(Segment(goal, max(farthest / (SPEED_SHARE * max_speed_rad_s), STEP_S)))
        here = goal
    return ArmPath(start, tuple(segments))


_obstacle: dict[tuple[JointPose, tuple[JointPose, ...]], str] = {}


def known(start: JointPose, waypoints: Sequence[JointPose]) -> bool:
    """True when `check_free` has its answer without looking."""
    return _key(start, waypoints) in _obstacle


def check_free(start: JointPose, waypoints: Sequence[JointPose]) -> None:
    """Raise PlanningError when the way from `start` through `waypoints` meets limits, table, bin or torso."""
    key = _key(start, waypoints)
    if key not in _obstacle:
        _obstacle[key] = _look(*key)
    if _obstacle[key]:
        raise PlanningError(_obstacle[key])


def _key(start: JointPose, waypoints: Sequence[JointPose]) -> tuple[JointPose, tuple[JointPose, ...]]:
    return tuple(round(angle, 3) + 0.0 for angle in start), tuple(tuple(waypoint) for waypoint in waypoints)


def _look(start: JointPose, waypoints: tuple[JointPose, ...]) -> str:
    with Engine(STEP_S) as engine:
        scene = _Scene(engine)
        here = start
        for number, goal in enumerate(waypoints, 1):
            try:
                scene.torso.check_goal(goal)
            except SimulationError as error:
                return f"waypoint {number}: {error}"
            looks = 1 + math.ceil(max(abs(g - h) for g, h in zip(goal, here, strict=True)) / SAMPLE_RAD)
            for look in range(1, looks + 1):
                pose = tuple(h + look / looks * (g - h) for g, h in zip(goal, here, strict=True))
                touched = scene.touched(pose)
                if touched:
                    return f"{touched} at {look / looks:.0%} of the way to waypoint {number} {goal}"
            here = goal
    return ""


class _Scene:
    """Robot and furniture without legs and people, for looking at poses."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._furniture = furnish(engine)[1:]  # nothing of the arm reaches the floor
        self.torso = Torso(engine)
        self._fingers = Fingers(engine, self.torso.palm_pose())
        self._moving = {
            self.torso.body: {self.torso.joints[name]: name for name in ARM_LINKS},
            self._fingers.body: {index: name for name, index in self._fingers.joints.items()},
        }
        self._standing = (-1, *(self.torso.joints[name] for name in TORSO_LINKS))

    def touched(self, pose: JointPose) -> str:
        """What the arm comes too near to in `pose`, or an empty text."""
        self.torso.set_arm(pose)
        self._fingers.follow(self.torso.palm_pose())
        for body, names in self._moving.items():
            for other in self._furniture:
                for link, distance_m in self._near(body, other):
                    if link in names:
                        return f"{names[link]} comes within {distance_m:.3f} m of table or bin"
            for link, name in names.items():
                for other in self._standing:
                    for _, distance_m in self._near(body, self.torso.body, link, other):
                        return f"{name} comes within {distance_m:.3f} m of the torso"
        return ""

    def _near(self, body: int, other: int, *links: int) -> list[tuple[int, float]]:
        """Link of the robot and distance (m) of every pair nearer than CLEARANCE_M."""
        points = bullet.getClosestPoints(body, other, CLEARANCE_M, *links, physicsClientId=self._engine.client)
        return [(point[3], point[8]) for point in points]
