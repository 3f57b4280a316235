"""The outcome of a turn: fetched or not, released or discarded; and the report on the table."""

from __future__ import annotations

from itertools import product

import pytest

from controller.ports import JointPose, Reading, TableDone
from controller.settings import Settings
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


def test_a_pickup_place_that_has_no_plan_costs_the_turn() -> None:
    bench = Bench(asks=1)
    bench.arm.no_plan.add(PICKUP)
    bench.run(ONE_TURN_S)
    assert bench.states[2:5] == ["Move_hand", "Discard", "Receive1"]
    assert (bench.outcomes, bench.reasons) == (["discarded"], ["pickup place not reached"])
    assert any("no plan: a shelf is in the way" in note for note in bench.robot.journal.notes)


def test_an_arm_that_did_not_arrive_at_the_pickup_place_costs_the_turn() -> None:
    bench = Bench(asks=1)
    bench.arm.held_up.add(PICKUP)
    bench.run(ONE_TURN_S)
    assert bench.outcomes == ["discarded"]
    assert any("arm did not arrive within 5.0 s" in note for note in bench.robot.journal.notes)


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


def test_a_leg_that_is_lost_while_the_way_is_not_free_is_not_waited_for() -> None:
    bench = Bench(asks=1)
    bench.arm.no_plan.add(HANDOVER)
    bench.later(20.0, lambda: setattr(bench.hand, "held", False))
    bench.run(ONE_TURN_S)
    assert (bench.outcomes, bench.reasons) == (["discarded"], ["leg lost on the way"])


def test_a_hand_that_caught_nothing_closes_a_second_time() -> None:
    bench = Bench(asks=1)
    bench.hand.catches = [False]
    bench.run(ONE_TURN_S)
    assert bench.outcomes == ["released"]
    assert any("closing 1 caught nothing" in note for note in bench.robot.journal.notes)


def test_a_hand_that_caught_nothing_twice_gives_up() -> None:
    bench = Bench(asks=1)
    bench.hand.catches = [False, False]
    bench.run(ONE_TURN_S)
    assert (bench.outcomes, bench.reasons) == (["discarded"], ["no leg in the hand"])
    assert any("nothing to discard" in note for note in bench.robot.journal.notes)


def test_a_leg_lost_on_the_way_is_not_offered() -> None:
    bench = Bench(asks=1)

    def lose(goal: JointPose) -> None:
        bench.hand.held = bench.hand.held and goal != HANDOVER

    bench.arm.arrives = lose
    bench.run(ONE_TURN_S)
    assert "Send1" not in bench.states
    assert (bench.outcomes, bench.reasons) == (["discarded"], ["leg lost on the way"])


def test_a_leg_pulled_out_before_the_decision_is_not_released() -> None:
    bench = Bench()
    bench.robot.reading = Reading(gaze=True, pressure=True, location=True)
    assert bench.enter("Decide") == "not ready"
    assert bench.robot.reason == "leg pulled out of the hand"


def test_fingers_that_do_not_open_are_tried_again() -> None:
    bench = Bench(asks=1)
    bench.hand.opens = [False, False]
    bench.run(ONE_TURN_S)
    assert (bench.outcomes, bench.reasons) == (["released"], ["released at attempt 3"])
    first, second, third = bench.hand.opened_at_s
    assert second - first == third - second == pytest.approx(OPEN_S + 3.0)


def test_a_release_is_not_given_up_and_the_hand_not_closed_again() -> None:
    bench = Bench(asks=1)
    bench.hand.opens = [False] * 12
    bench.run(ONE_TURN_S + 12 * (OPEN_S + 3.0))
    assert bench.states[8:10] == ["Release", "Receive1"]
    assert (bench.outcomes, bench.reasons) == (["released"], ["released at attempt 13"])
    assert bench.hand.closed_at_s[1:] == []


def test_the_turn_does_not_end_before_the_leg_is_out_of_the_hand() -> None:
    bench = Bench(asks=1, readings=[NOTHING_SEEN])
    bench.hand.opens = [False] * 10
    held_at: list[JointPose] = []
    bench.arm.arrives = lambda place: held_at.append(place) if bench.hand.held else None
    bench.run(ONE_TURN_S + 10 * (OPEN_S + 3.0))
    assert held_at[-1] == RESUPPLY
    assert not bench.hand.held
    assert bench.outcomes == ["discarded"]


def test_an_arm_that_cannot_go_home_stays_and_the_turn_counts() -> None:
    bench = Bench(asks=1)
    bench.arm.arrives = lambda goal: bench.arm.no_plan.add(HOME)
    bench.run(ONE_TURN_S)
    assert bench.outcomes == ["released"]
    assert bench.arm.at == HANDOVER
    assert any("arm stays where it is" in note for note in bench.robot.journal.notes)


def test_something_in_the_hand_at_the_start_is_let_go() -> None:
    bench = Bench(asks=0)
    bench.hand.held = True
    bench.run(limit_s=10.0)
    assert bench.hand.opened_at_s == [0.0]
    assert bench.robot.journal.notes[0] == "0.00 s: something is in the hand at the start"


def test_what_is_in_the_hand_at_the_start_is_let_go_before_the_arm_moves() -> None:
    bench = Bench(asks=0)
    bench.hand.held = True
    bench.hand.opens = [False, False]
    bench.run(limit_s=20.0)
    assert len(bench.hand.opened_at_s) == 3
    assert not bench.hand.held


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


def test_of_the_four_released_legs_the_pauses_decide_whether_the_table_is_late() -> None:
    quick, slow = Bench(pause_s=30.0), Bench(pause_s=60.0)
    quick.run()
    slow.run()
    assert quick.report is not None
    assert slow.report is not None
    assert (quick.report.on_time, slow.report.on_time) == (True, False)


def test_exactly_300_s_are_on_time() -> None:
    bench = Bench()
    bench.run()
    assert bench.robot.journal.report(300.0, 4, 300.0).on_time
    assert not bench.robot.journal.report(300.001, 4, 300.0).on_time


def test_every_way_is_planned_at_the_set_speed() -> None:
    bench = Bench(Settings(max_speed_rad_s=0.2), asks=2, readings=[NOTHING_SEEN])
    bench.run(limit_s=100.0)
    assert set(bench.arm.speeds) == {0.2}
