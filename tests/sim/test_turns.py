"""What a person aims at with each leg, read off a script."""

from __future__ import annotations

from sim.turns import planned_turns

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
