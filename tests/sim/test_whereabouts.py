"""Where arm, hand and leg are, as the world records it."""

from __future__ import annotations

from itertools import groupby

from controller import waypoints
from sim.layout import BIN_M, HANDOVER_M, PICKUP_M
from sim.whereabouts import HAND_PLACES
from tests.sim.stage import Stage


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
