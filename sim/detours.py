"""Ways around obstacles, sampled by RRT-Connect: that of OMPL where there is one, else our own.

OMPL has no wheels for Windows, for Linux on ARM, and for Python 3.14; no other library that is kept has RRT-Connect for
any space without a robot model of its own. The two find different ways, each always the same one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from controller.ports import JointPose
from sim.rrt_connect import RrtConnect
from sim.silence import silenced


@dataclass(frozen=True)
class Search:
    """A search for a way.

    Args:
        start: where it begins (rad).
        goal: where it ends (rad).
        limits: the least and the largest angle of each joint (rad).
        is_free: whether a pose is free of collisions.
        sample_rad: largest joint angle between two collision checks.
        max_checks: after so many the search is given up.
        seed: of its random numbers.
    """

    start: JointPose
    goal: JointPose
    limits: Sequence[tuple[float, float]]
    is_free: Callable[[JointPose], bool]
    sample_rad: float
    max_checks: int
    seed: int


def has_ompl() -> bool:
    """Whether OMPL is installed."""
    return find_spec("ompl") is not None


def sampled(search: Search) -> tuple[JointPose, ...] | None:
    """Poses between start and goal that straight ways may join; None where none were found."""
    if not has_ompl():
        planner = RrtConnect(search.limits, search.is_free, search.sample_rad, search.max_checks, search.seed)
        return planner.way(search.start, search.goal)
    with silenced():  # OMPL warns when the seed is set again, which makes results independent of each other
        return _by_ompl(search)


def _by_ompl(search: Search) -> tuple[JointPose, ...] | None:
    from ompl import base, geometric, util  # imported only if a path is blocked: most runs need no detour

    checks, size = 0, len(search.start)

    def free(state: Sequence[float]) -> bool:
        nonlocal checks
        checks += 1
        return search.is_free(tuple(state[index] for index in range(size)))

    util.RNG.setSeed(search.seed)
    space = base.RealVectorStateSpace(size)
    bounds = base.RealVectorBounds(size)
    for index, (low, high) in enumerate(search.limits):
        bounds.setLow(index, low)
        bounds.setHigh(index, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(free)
    information.setStateValidityCheckingResolution(search.sample_rad / space.getMaximumExtent())
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(_state(space, search.start), _state(space, search.goal))
    planner = geometric.RRTConnect(information)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.PlannerTerminationCondition(lambda: checks > search.max_checks))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    geometric.PathSimplifier(information).reduceVertices(path)
    states = [path.getState(number) for number in range(1, path.getStateCount() - 1)]
    return tuple(tuple(state[index] for index in range(size)) for state in states)


def _state(space: Any, pose: JointPose) -> Any:
    state = space.allocState()
    for index, angle in enumerate(pose):
        state[index] = angle
    return state
