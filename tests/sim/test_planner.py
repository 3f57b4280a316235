"""Ways are timed below a speed and refused when something is in the way."""

from __future__ import annotations

import itertools
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.ports import JointPose, PlanningError
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP, TO_RESUPPLY
from sim import detours, planner
from sim.engine import STEP_S
from sim.engines import new_engine
from sim.planner import CollisionScene, find_path, is_cached
from sim.timing import MAX_ACCELERATION_RAD_S2, SPEED_SHARE, time_path

WAYS = {"home": (HOME,), "pickup": TO_PICKUP, "handover": TO_HANDOVER, "re-supply": TO_RESUPPLY}

angles = st.tuples(*[st.floats(-1.5, 1.5)] * 9)


HANDOVER: JointPose = TO_HANDOVER[-1]
DETOURS: list[tuple[JointPose, JointPose]] = [
    (TO_PICKUP[-1], (-0.27, 0.46, 0.18, 0.16, -0.69, 0.38, -0.02, 0.02, -0.23)),
    (HANDOVER, (-0.95, 0.04, 0.5, 0.0, 0.81, 0.44, 0.32, 0.05, -0.77)),
    (TO_PICKUP[-1], (1.06, 0.47, 0.12, 0.6, -1.3, 0.28, 0.01, -0.02, -0.62)),
]
"""From the first pose the second one cannot be reached straight: table, bin or torso are between."""


@pytest.fixture(params=["OMPL", "our own"])
def sampler(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of the two ways to sample detours, from nothing."""
    if request.param == "OMPL":
        pytest.importorskip("ompl")
    monkeypatch.setattr(planner, "_paths", {})
    monkeypatch.setattr("sim.detours.has_ompl", lambda: request.param == "OMPL")


@pytest.mark.usefixtures("sampler")
@pytest.mark.parametrize(("start", "goal"), DETOURS)
def test_a_path_leads_around_an_obstacle(start: JointPose, goal: JointPose) -> None:
    way = find_path(start, (goal,))
    assert len(way) > 1
    assert way[-1] == goal
    with new_engine() as engine:
        scene = CollisionScene(engine)
        assert scene.obstacle(start, goal)
        assert not any(scene.limit_violation(pose) for pose in way)
        assert not any(scene.obstacle(here, there) for here, there in itertools.pairwise((start, *way)))


@pytest.mark.usefixtures("sampler")
def test_a_detour_is_the_same_after_others_and_in_another_process(engine_name: str) -> None:
    start, goal = DETOURS[1]
    first = find_path(start, (goal,))
    planner._paths.clear()
    find_path(DETOURS[0][0], (DETOURS[0][1],))
    assert find_path(start, (goal,)) == first
    code = f"import sim.detours; sim.detours.has_ompl = lambda: {detours.has_ompl()}; "
    code += f"from sim.planner import find_path; print(find_path({start!r}, ({goal!r},), (), {engine_name!r}))"
    root = Path(__file__).parents[2]
    there = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert there.stdout.strip() == repr(first)
    assert there.stderr == ""


@pytest.mark.usefixtures("sampler")
def test_a_goal_without_a_path_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planner, "MAX_CHECKS", -1)
    start, goal = DETOURS[0]
    with pytest.raises(PlanningError, match=r"waypoint 1 .* of the way, and no way around it was found"):
        find_path(start, (goal,))


@pytest.mark.parametrize(("start", "end"), list(itertools.permutations(WAYS, 2)))
def test_every_taught_path_is_free_from_the_end_of_every_other(start: str, end: str) -> None:
    assert find_path(WAYS[start][-1], WAYS[end]) == WAYS[end]
    assert is_cached(WAYS[start][-1], WAYS[end])


def test_a_waypoint_in_the_table_is_refused() -> None:
    low: JointPose = (-0.1, 0.5, -0.4, -0.1, 1.3, -0.2, -0.2, -0.2, 0.1)
    with pytest.raises(PlanningError, match=r"waypoint 1 .* comes within -?\d.\d+ m of table or bin$"):
        find_path(TO_PICKUP[0], (low,))


def test_a_waypoint_in_the_torso_is_refused() -> None:
    inwards: JointPose = (0.0, 0.0, 0.0, -0.1, -1.3, -0.3, 0.0, -0.1, 0.0)
    with pytest.raises(PlanningError, match="of the torso"):
        find_path(HOME, (inwards,))


def test_a_waypoint_outside_the_limits_is_refused() -> None:
    with pytest.raises(PlanningError, match=r"waypoint 2 .*left_elbow_flex at 0\.9 rad is outside"):
        find_path(HOME, (HOME, (0.0, 0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0)))


@given(st.lists(angles, min_size=1, max_size=4), angles, st.floats(0.05, 1.0))
def test_the_fastest_joint_of_each_segment_moves_just_below_the_limit(
    ways: list[JointPose], start: JointPose, limit_rad_s: float
) -> None:
    path = time_path(start, ways, limit_rad_s)
    here = start
    for segment in path.segments:
        farthest = max(abs(g - h) for g, h in zip(segment.goal, here, strict=True))
        assert 0.0 <= 2 * segment.ramp_s <= segment.duration_s * (1 + 1e-9)
        if segment.duration_s > STEP_S:
            speed = farthest / (segment.duration_s - segment.ramp_s)
            assert speed <= SPEED_SHARE * limit_rad_s * (1 + 1e-9)
            assert speed / segment.ramp_s == pytest.approx(MAX_ACCELERATION_RAD_S2)
            if farthest > limit_rad_s**2 / MAX_ACCELERATION_RAD_S2:
                assert speed == pytest.approx(SPEED_SHARE * limit_rad_s)
        here = segment.goal
