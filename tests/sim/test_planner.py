"""Ways are timed below a speed and refused when something is in the way."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.ports import JointPose, PlanningError
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP, TO_RESUPPLY
from sim.planner import SPEED_SHARE, check_free, known, time_path

WAYS = {"home": (HOME,), "pickup": TO_PICKUP, "handover": TO_HANDOVER, "re-supply": TO_RESUPPLY}

angles = st.tuples(*[st.floats(-1.5, 1.5)] * 9)


@pytest.mark.parametrize(("start", "end"), list(itertools.permutations(WAYS, 2)))
def test_every_way_is_free_from_the_end_of_every_other(start: str, end: str) -> None:
    check_free(WAYS[start][-1], WAYS[end])
    assert known(WAYS[start][-1], WAYS[end])


def test_a_way_through_the_table_is_refused() -> None:
    low: JointPose = (-0.6, 0.5, -0.2, 0.0, 1.3, 0.0, 0.0, -0.2, 0.0)
    with pytest.raises(
        PlanningError, match=r"comes within -?\d.\d+ m of table or bin at \d+% of the way to waypoint 1"
    ):
        check_free(TO_PICKUP[0], (low,))


def test_a_way_into_the_torso_is_refused() -> None:
    inwards: JointPose = (0.0, 0.0, 0.0, -0.1, -1.3, -0.3, 0.0, -0.1, 0.0)
    with pytest.raises(PlanningError, match="of the torso"):
        check_free(HOME, (inwards,))


def test_a_waypoint_outside_the_limits_is_refused() -> None:
    with pytest.raises(PlanningError, match=r"waypoint 2: left_elbow_flex at 0\.9 rad is outside"):
        check_free(HOME, (HOME, (0.0, 0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0)))


@pytest.mark.parametrize(
    ("ways", "speed_rad_s", "complaint"),
    [
        ((), 0.25, "without waypoints"),
        (((0.0,) * 8,), 0.25, "not 9 finite angles"),
        (((math.nan,) * 9,), 0.25, "not 9 finite angles"),
        ((HOME,), 0.0, "expected more than 0"),
        ((HOME,), math.nan, "expected more than 0"),
    ],
)
def test_nonsense_is_refused(ways: tuple[JointPose, ...], speed_rad_s: float, complaint: str) -> None:
    with pytest.raises(PlanningError, match=complaint):
        time_path(HOME, ways, speed_rad_s)


@settings(deadline=None)
@given(st.lists(angles, min_size=1, max_size=4), angles, st.floats(0.05, 1.0))
def test_the_fastest_joint_of_each_segment_moves_just_below_the_limit(
    ways: list[JointPose], start: JointPose, limit_rad_s: float
) -> None:
    path = time_path(start, ways, limit_rad_s)
    here = start
    for segment in path.segments:
        farthest = max(abs(g - h) for g, h in zip(segment.goal, here, strict=True))
        speed = farthest / segment.duration_s
        assert speed <= SPEED_SHARE * limit_rad_s * (1 + 1e-9)
        if farthest > 0.02:
            assert speed == pytest.approx(SPEED_SHARE * limit_rad_s)
        here = segment.goal
