"""Ways of the arm: straight in joint space where that is free, else around what is in the way.

Ways are looked for in a scene of its own, which is closed again, so that planning never touches the running world. The
answer depends on start (to a milliradian) and waypoints only, and is kept for the process.

Around obstacles the way is sampled by OMPL's RRT-Connect (Kuffner and LaValle 2000). Its random numbers are seeded from
the question itself, and it is bounded by a number of looks, not by time: the same question has the same answer on every
machine, alone or after others.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

from controller.ports import JointPose, PlanningError
from sim.engine import Engine, quiet
from sim.physics_time import STEP_S
from sim.scene import SAMPLE_RAD, Scene

MAX_LOOKS = 8000
"""So many poses are looked at before a way around something is given up: some seconds."""

Question = tuple[JointPose, tuple[JointPose, ...]]

_ways: dict[Question, tuple[JointPose, ...] | str] = {}
"""The free way, or why there is none."""


def known(start: JointPose, waypoints: Sequence[JointPose]) -> bool:
    """True when `find_way` has its answer without looking."""
    return _question(start, waypoints) in _ways


def find_way(start: JointPose, waypoints: Sequence[JointPose]) -> tuple[JointPose, ...]:
    """Poses (rad) to pass straight from one to the next: `waypoints`, and others between them where needed.

    Raises:
        PlanningError: a waypoint is outside the limits or too near to something, or no way to it was found.
    """
    question = _question(start, waypoints)
    if question not in _ways:
        with Engine(STEP_S) as engine:
            _ways[question] = _search(Scene(engine), *question)
    way = _ways[question]
    if isinstance(way, str):
        raise PlanningError(way)
    return way


def _question(start: JointPose, waypoints: Sequence[JointPose]) -> Question:
    return tuple(round(angle, 3) + 0.0 for angle in start), tuple(tuple(waypoint) for waypoint in waypoints)


def _search(scene: Scene, start: JointPose, waypoints: tuple[JointPose, ...]) -> tuple[JointPose, ...] | str:
    way: list[JointPose] = []
    here = start
    for number, goal in enumerate(waypoints, 1):
        wrong = scene.beyond(goal) or scene.touched(goal)
        if wrong:
            return f"waypoint {number} {goal}: {wrong}"
        blocked = scene.blocked(here, goal)
        around = _around(scene, here, goal) if blocked else ()
        if around is None:
            return f"waypoint {number} {goal}: {blocked}, and no way around it was found"
        way += [*around, goal]
        here = goal
    return tuple(way)


def _around(scene: Scene, start: JointPose, goal: JointPose) -> tuple[JointPose, ...] | None:
    """Poses between `start` and `goal` whose straight connections are free; None when none were found."""
    with quiet():  # it complains of the seed being set again, which is what makes each answer independent
        poses = _sample(scene, start, goal)
    if poses is None:
        return None
    legs = zip((start, *poses), (*poses, goal), strict=True)
    return None if any(scene.blocked(here, there) for here, there in legs) else poses


def _sample(scene: Scene, start: JointPose, goal: JointPose) -> tuple[JointPose, ...] | None:
    from ompl import base, geometric, util  # only where a way is blocked: most runs need none of it

    looks = 0

    def free(state: Sequence[float]) -> bool:
        nonlocal looks
        looks += 1
        return not scene.touched(tuple(state[index] for index in range(len(start))))

    util.RNG.setSeed(1 + int.from_bytes(hashlib.sha256(repr((start, goal)).encode()).digest()[:3], "big"))
    limits = list(scene.torso.limits_rad.values())
    space = base.RealVectorStateSpace(len(start))
    bounds = base.RealVectorBounds(len(start))
    for index, (low, high) in enumerate(limits):
        bounds.setLow(index, low)
        bounds.setHigh(index, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(free)
    information.setStateValidityCheckingResolution(SAMPLE_RAD / space.getMaximumExtent())
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(_state(space, start), _state(space, goal))
    planner = geometric.RRTConnect(information)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.PlannerTerminationCondition(lambda: looks > MAX_LOOKS))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    geometric.PathSimplifier(information).reduceVertices(path)
    states = [path.getState(number) for number in range(1, path.getStateCount() - 1)]
    return tuple(tuple(state[index] for index in range(len(start))) for state in states)


def _state(space: Any, pose: JointPose) -> Any:
    state = space.allocState()
    for index, angle in enumerate(pose):
        state[index] = angle
    return state
