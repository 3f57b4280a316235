"""What a person aims at with each leg, read off a script."""

from __future__ import annotations

from controller.ports import State, TurnDone
from pytest_hricdv.runtime import RecordedMessage, topic_of
from sim.turns import ended_turns, planned_turns

LEG = ["tell leg", "receivesignal", "set_param location = 1", "set_param pressure = 0", "set_param gaze = 1"]
READY = "tell humanReady"


def test_a_leg_has_its_pose_in_the_order_of_the_readings() -> None:
    assert planned_turns([*LEG, READY]) == (("1", "not_bored", "101"),)


def test_disturbances_are_nothing_that_the_person_plans() -> None:
    disturbed = ["disturb outage", *LEG[:2], "disturb leg_slips", *LEG[2:], READY]
    assert planned_turns(disturbed) == planned_turns([*LEG, READY])


def test_a_leg_given_up_for_boredom_counts_once() -> None:
    bored = ["tell leg", "receivesignal", "bored"]
    assert planned_turns([*bored, *LEG, READY, *LEG, READY]) == (
        ("2", "bored", "none"),
        ("2", "not_bored", "101"),
        ("2", "not_bored", "101"),
    )


def test_who_does_not_say_ready_has_no_pose_and_a_table_has_four_legs() -> None:
    assert planned_turns(LEG) == (("1", "not_bored", "none"),)
    assert [legs for legs, _, _ in planned_turns(LEG * 6)] == ["4"] * 6
    assert planned_turns([]) == ()
    assert planned_turns(["bored", "set_param gaze = 1"]) == ()


def begins(time_s: float) -> RecordedMessage:
    return RecordedMessage(time_s, "robot", topic_of(State), {"name": "Move_hand"})


def ends(time_s: float, outcome: str) -> RecordedMessage:
    return RecordedMessage(time_s, "robot", topic_of(TurnDone), {"turn": 1, "outcome": outcome})


THREE = ["tell leg", "tell humanReady", "tell leg", "bored", "disturb outage", "tell leg"]
FIRST, SECOND, THIRD = planned_turns(THREE)
ACTION_TIMES_S = (0.0, 20.0, 30.0, 60.0, 61.0, 90.0)


def test_each_planned_turn_has_the_outcome_of_the_turn_that_its_request_began() -> None:
    messages = [begins(4.0), ends(29.0, "released"), begins(34.0), ends(70.0, "discarded")]
    assert ended_turns(THREE, ACTION_TIMES_S, messages) == ((FIRST, "released"), (SECOND, "discarded"))


def test_a_request_that_opened_no_turn_has_no_outcome_and_leaves_the_others_theirs() -> None:
    messages = [begins(34.0), ends(100.0, "discarded"), begins(101.0), ends(130.0, "released")]
    assert ended_turns(THREE, ACTION_TIMES_S, messages) == ((SECOND, "discarded"), (THIRD, "released"))


def test_a_further_turn_while_the_person_is_at_one_request_is_nobodys() -> None:
    messages = [begins(-1.0), ends(-0.5, "discarded"), begins(4.0), ends(20.0, "released"), begins(21.0)]
    assert ended_turns(THREE, ACTION_TIMES_S, [*messages, ends(29.0, "discarded")]) == ((FIRST, "released"),)


def test_requests_that_the_person_never_came_to_have_no_outcome() -> None:
    assert ended_turns(THREE, ACTION_TIMES_S[:1], [begins(4.0), ends(29.0, "released")]) == ((FIRST, "released"),)
