"""A head that is placed for a gaze has that gaze."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.engine import SimulationError
from sim.gaze import Gaze, gaze_of, head_pose, orientation_to
from sim.layout import HANDOVER_M

distances = st.floats(0.3, 1.0)
legs = st.tuples(st.floats(-0.5, 1.0), st.floats(-0.5, 0.5), st.floats(0.4, 1.0))


@given(distances, st.floats(0.0, 1.0), st.floats(0.0, 180.0), st.sampled_from([-1.0, 1.0]), legs)
def test_round_trip(
    distance_m: float, share: float, angle_deg: float, side: float, leg: tuple[float, float, float]
) -> None:
    wanted = Gaze(share * distance_m, distance_m, angle_deg)
    seen = gaze_of(head_pose(wanted, side, leg), leg)
    assert seen.offset_m == pytest.approx(wanted.offset_m, abs=1e-9)
    assert seen.distance_m == pytest.approx(wanted.distance_m)
    assert seen.angle_deg == pytest.approx(wanted.angle_deg, abs=2e-6)


@given(distances, st.floats(0.1, 1.0), st.sampled_from([-1.0, 1.0]))
def test_the_head_is_on_the_persons_side_above_the_leg(distance_m: float, share: float, side: float) -> None:
    place, _ = head_pose(Gaze(share * distance_m, distance_m, 20.0), side, HANDOVER_M)
    assert place[0] >= HANDOVER_M[0]
    assert place[2] >= HANDOVER_M[2]
    assert math.copysign(1.0, place[1] - HANDOVER_M[1]) == side


def test_looking_at_something_is_an_angle_of_0() -> None:
    place = (1.2, 0.5, 1.3)
    assert gaze_of((place, orientation_to(place, HANDOVER_M)), HANDOVER_M).angle_deg == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(
    "gaze",
    [
        Gaze(0.7, 0.6, 20.0),
        Gaze(-0.1, 0.6, 20.0),
        Gaze(0.1, 0.6, 200.0),
        Gaze(0.0, 0.0, 0.0),
        Gaze(math.nan, 0.6, 20.0),
    ],
)
def test_an_impossible_gaze_is_refused(gaze: Gaze) -> None:
    with pytest.raises(SimulationError):
        head_pose(gaze, 1.0, HANDOVER_M)
