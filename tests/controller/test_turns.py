"""The outcome of a turn: fetched or not, released or discarded; and the report on the table."""

from __future__ import annotations

from itertools import product

import pytest

from controller.ports import JointPose, Reading, TableDone
from controller.waypoints import HOME, TO_HANDOVER, TO_PICKUP, TO_RESUPPLY
from tests.controller.bench import MOVE_S, OPEN_S, Bench

PICKUP, HANDOVER, RESUPPLY = TO_PICKUP[-1], TO_HANDOVER[-1], TO_RESUPPLY[-1]
ONE_TURN_S = 60.0
NOTHING_SEEN = Reading(gaze=False, pressure=False, location=False)


def test_a_leg_is_released_only_when_all_three_sensors_are_ready() -> None:
    for gaze, pressure, location in product((False, True), repeat=3):
        bench = Bench(asks=1, readings=[Reading(gaze, pressure, location)])
        bench.run(ONE_TURN_S)
        assert bench.outcomes == ["released" if gaze and pressure and location else "discarded"]
        for ready, name in ((gaze, "gaze"), (pressure, "pressure"), (location, "location")):
            assert (name in bench.reasons[0]) == (not ready)


def test_a_released_leg_leaves_the_hand_before_the_arm_goes_home() -> None:
    bench = Bench(asks=1)
    opened_at: list[JointPose] = []
    bench.arm.arrives = lambda goal: opened_at.append(goal) if not bench.hand.held else None
    bench.run(ONE_TURN_S)
    assert opened_at == [HOME, PICKUP, HOME]
    assert bench.hand.opened_at_s == bench.entered_s("Release")


def test_a_discarded_leg_is_opened_at_the_resupply_place() -> None:
    bench = Bench(asks=1, readings=[NOTHING_SEEN])
    bench.run(ONE_TURN_S)
    assert bench.hand.opened_at_s == [bench.entered_s("Discard")[0] + MOVE_S]
    assert not bench.hand.held
    assert bench.arm.at == HOME


@pytest.mark.parametrize("hindrance", ["no_plan", "held_up"])
@pytest.mark.parametrize(("goal", "outcome"), [(HANDOVER, "released"), (RESUPPLY, "discarded")])
def test_with_a_leg_in_the_hand_the_robot_waits_until_the_way_is_free(
    goal: JointPose, outcome: str, hindrance: str
) -> None:
    bench = Bench(asks=1, readings=[NOTHING_SEEN] if outcome == "discarded" else [])
    getattr(bench.arm, hindrance).add(goal)
    bench.later(100.0, getattr(bench.arm, hindrance).clear)
    with_leg: list[JointPose] = []
    bench.arm.arrives = lambda place: with_leg.append(place) if bench.hand.held else None
    bench.run(200.0)
    assert bench.hand.opened_at_s[0] > 100.0
    assert with_leg[-1] == goal
    assert not bench.hand.held
    assert bench.outcomes == [outcome]


def test_a_hand_that_caught_nothing_closes_a_second_time() -> None:
    bench = Bench(asks=1)
    bench.hand.catches = [False]
    bench.run(ONE_TURN_S)
    assert bench.outcomes == ["released"]
    assert any("closing 1 caught nothing" in note for note in bench.robot.journal.notes)


def test_the_turn_does_not_end_before_the_leg_is_out_of_the_hand() -> None:
    bench = Bench(asks=1, readings=[NOTHING_SEEN])
    bench.hand.opens = [False] * 10
    held_at: list[JointPose] = []
    bench.arm.arrives = lambda place: held_at.append(place) if bench.hand.held else None
    bench.run(ONE_TURN_S + 10 * (OPEN_S + 3.0))
    assert held_at[-1] == RESUPPLY
    assert not bench.hand.held
    assert bench.outcomes == ["discarded"]


def test_an_arm_that_cannot_go_home_at_the_start_ends_the_run() -> None:
    bench = Bench()
    bench.arm.no_plan.add(HOME)
    assert bench.run() == "table done"
    assert bench.states == ["Reset"]
    assert bench.report is None


def test_four_turns_end_the_table_however_they_end() -> None:
    bench = Bench(asks=6, answers=[1, 3, 4], readings=[NOTHING_SEEN, None])
    assert bench.run() == "table done"
    assert bench.outcomes == ["discarded", "no-human-ready", "sensing-timeout", "released"]
    assert bench.report == TableDone(1, bench.kernel.now_s, on_time=False)
    lost = "1 discarded, 2 no-human-ready, 3 sensing-timeout"
    assert bench.robot.journal.notes[-1].endswith(f"table incomplete: {lost}")


def test_each_turn_is_journalled_with_its_times() -> None:
    bench = Bench()
    bench.run()
    turns = bench.robot.journal.turns
    assert [turn.number for turn in turns] == [1, 2, 3, 4]
    assert [turn.began_s for turn in turns] == bench.entered_s("Move_hand")
    assert all(turn.began_s < turn.ended_s for turn in turns)


@pytest.mark.parametrize("pause_s", [1.0, 30.0, 60.0])
def test_a_table_of_four_released_legs_is_on_time_within_300_s(pause_s: float) -> None:
    bench = Bench(pause_s=pause_s)
    assert bench.run() == "table done"
    assert bench.outcomes == ["released"] * 4
    assert bench.report == TableDone(4, bench.kernel.now_s, on_time=bench.kernel.now_s <= 300.0)
