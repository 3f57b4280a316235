"""Paths of the arm: straight in joint space where that is free, else around the obstacle.

Paths are planned in a separate scene, so that planning never changes the running world. The result depends on start (to
a milliradian), waypoints and the people in the way only, and is cached in the process. No path leads around people: an
arm waits until they have gone.

Around obstacles a path is sampled by RRT-Connect (Kuffner and LaValle 2000; see `sim.detours`). Its random numbers are
seeded from the query, and it is bounded by a number of collision checks, not by time: the same query has the same
result on every machine, alone or after others.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence

from controller.ports import JointPose, PlanningError
from sim.bystander import add_body
from sim.detours import Search, sampled
from sim.engine import Engine, SimulationError
from sim.engines import known, new_engine
from sim.fingers import Fingers
from sim.geometry import Vector
from sim.layout import furnish
from sim.torso import ARM_LINKS, Torso

MAX_CHECKS = 8000
"""Collision checks before the search for a detour is given up: some seconds."""

SAMPLE_RAD = 0.04
"""Largest joint angle between two collision checks: at most 3 cm at the fingertips. From 0.02 to 0.08 the records are
the same (see `sim.world.REST_TICKS`)."""

CLEARANCE_M = 0.02
"""Smallest allowed distance of the left arm to table, bin and torso. Chosen: from 0.01 to 0.03 the records are the same
(see `sim.world.REST_TICKS`)."""

TORSO_LINKS = ("hip_flexor",)
"""Links that the left arm must not touch: neck, head and right arm are fixed parts of the hip flexor's link."""

Query = tuple[JointPose, tuple[JointPose, ...], tuple[Vector, ...], str]
"""Start, waypoints, people in the way, and the physics engine that knows distances."""

_paths: dict[Query, tuple[JointPose, ...] | str] = {}
"""The free path, or the reason why there is none."""


class CollisionScene:
    """Robot and furniture in a separate engine, for collision checks of arm poses; without legs, and without the seated
    person, whose hands the arm has to reach.

    Args:
        engine: holds the scene.
        people: where others lean into the workspace (m; see `sim.bystander`).
    """

    def __init__(self, engine: Engine, people: Sequence[Vector] = ()) -> None:
        self._engine = engine
        furniture = furnish(engine)[1:]  # the arm does not reach the floor
        self._obstacles = dict.fromkeys(furniture, "table or bin")
        self._obstacles |= {add_body(engine, place): "a person" for place in people}
        self.torso = Torso(engine)
        self._fingers = Fingers(engine, self.torso.palm_pose())
        self._moving = {
            self.torso.body: {self.torso.joints[name]: name for name in ARM_LINKS},
            self._fingers.body: {index: name for name, index in self._fingers.joints.items()},
        }
        self._standing = (-1, *(self.torso.joints[name] for name in TORSO_LINKS))

    def collision(self, pose: JointPose) -> str:
        """What the arm is too near to in `pose`, or an empty text."""
        self.torso.set_arm(pose)
        self._fingers.follow(self.torso.palm_pose())
        for body, names in self._moving.items():
            for other, obstacle in self._obstacles.items():
                for link, distance_m in self._near(body, other):
                    if link in names:
                        return f"{names[link]} comes within {distance_m:.3f} m of {obstacle}"
            for link, name in names.items():
                for other in self._standing:
                    for _, distance_m in self._near(body, self.torso.body, link, other):
                        return f"{name} comes within {distance_m:.3f} m of the torso"
        return ""

    def _near(self, body: int, other: int, *links: int) -> list[tuple[int, float]]:
        """Link of the robot and distance (m) of every pair nearer than CLEARANCE_M."""
        return self._engine.near(body, other, CLEARANCE_M, *links)

    def limit_violation(self, pose: JointPose) -> str:
        """The joint limit that `pose` violates, or an empty text."""
        try:
            self.torso.check_goal(pose)
        except SimulationError as error:
            return str(error)
        return ""

    def obstacle(self, start: JointPose, goal: JointPose) -> str:
        """The obstacle on the straight path from `start` to `goal`, or an empty text. `start` itself is not checked."""
        checks = 1 + math.ceil(max(abs(g - s) for g, s in zip(goal, start, strict=True)) / SAMPLE_RAD)
        for check in range(1, checks + 1):
            touched = self.collision(tuple(s + check / checks * (g - s) for g, s in zip(goal, start, strict=True)))
            if touched:
                return f"{touched} at {check / checks:.0%} of the way"
        return ""


def is_cached(
    start: JointPose, waypoints: Sequence[JointPose], people: Sequence[Vector] = (), engine: str = ""
) -> bool:
    """True when `find_path` needs no search."""
    return _query(start, waypoints, people, engine) in _paths


def find_path(
    start: JointPose, waypoints: Sequence[JointPose], people: Sequence[Vector] = (), engine: str = ""
) -> tuple[JointPose, ...]:
    """Poses (rad) joined by straight, free paths: `waypoints`, and others between them where needed.

    Args:
        start: where the arm is (rad).
        waypoints: poses to pass in order (rad).
        people: where people lean into the workspace (m).
        engine: of physics, which knows distances (see `sim.engines`).

    Raises:
        PlanningError: start or a waypoint is outside the limits, a waypoint is in collision, or no path was found.
    """
    query = _query(start, waypoints, people, engine)
    if query not in _paths:
        with new_engine(query[-1]) as scene:
            _paths[query] = _search(CollisionScene(scene, people), *query[:3])
    way = _paths[query]
    if isinstance(way, str):
        raise PlanningError(way)
    return way


def _query(start: JointPose, waypoints: Sequence[JointPose], people: Sequence[Vector], engine: str) -> Query:
    # Adding 0.0 turns minus zero into zero: the seed of a detour comes from the text of a pose.
    rounded = tuple(round(angle, 3) + 0.0 for angle in start)
    return rounded, tuple(tuple(waypoint) for waypoint in waypoints), tuple(people), known(engine)


def _search(
    scene: CollisionScene, start: JointPose, waypoints: tuple[JointPose, ...], people: tuple[Vector, ...]
) -> tuple[JointPose, ...] | str:
    way: list[JointPose] = []
    here = start
    if beyond := scene.limit_violation(start):  # something has pushed the arm
        return f"start: {beyond}"
    for number, goal in enumerate(waypoints, 1):
        wrong = scene.limit_violation(goal) or scene.collision(goal)
        if wrong:
            return f"waypoint {number} {goal}: {wrong}"
        blocked = scene.obstacle(here, goal)
        if blocked and people:
            return f"waypoint {number} {goal}: {blocked}, and no way leads around people"
        around = _detour(scene, here, goal) if blocked else ()
        if around is None:
            return f"waypoint {number} {goal}: {blocked}, and no way around it was found"
        way += [*around, goal]
        here = goal
    return tuple(way)


def _detour(scene: CollisionScene, start: JointPose, goal: JointPose) -> tuple[JointPose, ...] | None:
    """Poses between `start` and `goal` joined by free straight paths; None if none were found."""
    limits = tuple(scene.torso.limits_rad.values())
    seed = int.from_bytes(hashlib.sha256(repr((start, goal)).encode()).digest()[:3], "big")
    # From 1 on: OMPL takes a seed of 0 for none.
    search = Search(start, goal, limits, lambda pose: not scene.collision(pose), SAMPLE_RAD, MAX_CHECKS, 1 + seed)
    poses = sampled(search)
    if poses is None:
        return None
    legs = zip((start, *poses), (*poses, goal), strict=True)
    return None if any(scene.obstacle(here, there) for here, there in legs) else poses
