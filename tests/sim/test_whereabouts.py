"""Where arm, hand and leg are, as the world records it."""

from __future__ import annotations

import math
from itertools import groupby

from hypothesis import given
from hypothesis import strategies as st

from controller import waypoints
from sim.gripper import GRASP_HEIGHT_M
from sim.layout import BIN_M, HANDOVER_M, PICKUP_M
from sim.whereabouts import HAND_PLACES, NEAR_M, hand_place
from tests.sim.stage import Stage

GRASPS = {
    "pickup": (PICKUP_M[0], PICKUP_M[1], PICKUP_M[2] + GRASP_HEIGHT_M),
    "handover": (HANDOVER_M[0], HANDOVER_M[1], HANDOVER_M[2] + GRASP_HEIGHT_M),
}
DIRECTIONS = st.tuples(st.floats(0.0, math.pi), st.floats(0.0, 2 * math.pi))


@given(st.sampled_from(sorted(GRASPS)), DIRECTIONS, st.floats(0.0, 2.0))
def test_a_hand_is_at_a_place_within_five_centimetres(name: str, direction: tuple[float, float], share: float) -> None:
    polar, around = direction
    away = (math.sin(polar) * math.cos(around), math.sin(polar) * math.sin(around), math.cos(polar))
    x, y, z = (at + share * NEAR_M * part for at, part in zip(GRASPS[name], away, strict=True))
    if abs(share - 1.0) > 1e-9:
        assert (hand_place((x, y, z)) == name) == (share < 1.0)


@given(st.floats(0.4, 1.5))
def test_a_hand_over_the_bin_is_at_the_resupply_place_at_any_height(height_m: float) -> None:
    assert hand_place((BIN_M[0], BIN_M[1], height_m)) == "resupply"


def test_a_leg_that_is_fetched_offered_and_discarded_is_followed() -> None:
    with Stage() as stage:

        def fetch_and_discard() -> None:
            for way in (waypoints.TO_PICKUP, waypoints.TO_HANDOVER, waypoints.TO_RESUPPLY, (waypoints.HOME,)):
                arm = stage.robot.arm
                assert arm.follow(arm.plan(way, 0.25))
                if way is waypoints.TO_PICKUP:
                    assert stage.robot.hand.close()
                elif way is waypoints.TO_RESUPPLY:
                    assert stage.robot.hand.open()
                    stage.kernel.sleep(1.0)

        stage.run(fetch_and_discard)
        signals = stage.recorder.finish().signals
        texts = stage.recorder.finish().texts
    assert [name for name, _ in groupby(texts["hand_place"][1]) if name != "elsewhere"] == [
        "pickup",
        "handover",
        "resupply",
    ]
    assert set(texts["hand_place"][1]) == set(HAND_PLACES)
    assert [bool(value) for value in signals["arm_home"][1]] == [True, False, True]
    assert [bool(value) for value in signals["leg_in_bin"][1]][:2] == [False, True]
    heights = signals["leg_height"][1]
    assert heights[0] == PICKUP_M[2]
    assert abs(max(heights) - HANDOVER_M[2]) < 0.02
    assert min(heights) < BIN_M[2] + 0.2
