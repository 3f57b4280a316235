"""Causes of differences between the original's runs and ours."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.script import PARAMETERS
from studies.agreement import pair
from studies.agreement.pair import OurRun, Pair, reading_error_explains, readings_by_turn
from studies.agreement.tables import gains
from studies.original.requests import LegRequest, first_request_s, leg_requests
from studies.original.runs import OriginalRun, load_runs
from tests.hri.bench import leg

PASSED = {"R1": "Passed", "R2": "Passed", "R3": "Passed"}
POSES = ["".join(bits) for bits in product("01", repeat=3)]
BORED = ["tell leg", "receivesignal", "bored"]


def then(lines: list[str], legs: list[str] | None, **verdicts: str) -> OriginalRun:
    """A run of the original; verdicts are passes unless given."""
    return OriginalRun("s", 1, tuple(lines), 80.0, PASSED | verdicts, None if legs is None else tuple(legs))


def now(legs: list[str], readings: list[str], **verdicts: str) -> OurRun:
    """A run of ours."""
    return OurRun("s-1", 80.0, PASSED | verdicts, tuple(legs), tuple(readings))


def test_every_given_run_is_read_and_only_two_lack_their_commands() -> None:
    runs = load_runs()
    assert len(runs) == 232
    assert {run.suite for run in runs} >= {"by-hand", "rl", "pseudorandom"}
    assert all(line in PARAMETERS for run in runs for line in run.lines)
    assert all(0 <= run.coverage <= 100 for run in runs)


def test_a_test_asks_for_what_its_commands_say() -> None:
    lines = [*leg("101"), *BORED, "tell leg", "set_param gaze = 0"]
    assert leg_requests(lines) == (
        LegRequest("101", ready=True, bored=False),
        LegRequest("???", ready=False, bored=True),
        LegRequest("0??", ready=False, bored=False),
    )
    assert leg_requests(["bored", "tell humanReady"]) == ()


@given(st.lists(st.sampled_from(sorted(PARAMETERS)), max_size=20))
def test_there_is_one_entry_a_request_and_commands_before_the_first_do_not_matter(lines: list[str]) -> None:
    found = leg_requests(lines)
    assert len(found) == lines.count("tell leg")
    assert leg_requests(["set_param gaze = 1", "bored", "tell humanReady", *lines]) == found
    assert (first_request_s(lines) is None) == (not found)


def test_a_request_after_waiting_for_a_signal_comes_a_minute_later() -> None:
    assert first_request_s(["tell leg"]) == 3.0
    assert first_request_s(["tell humanReady", "receivesignal", "bored", "tell leg", "tell leg"]) == 65.0


@pytest.mark.parametrize("pose", POSES)
def test_readings_err_in_the_directions_that_sensors_err_in(pose: str) -> None:
    possible = {reading for reading in POSES if reading_error_explains(pose, reading)}
    expected = {
        f"{gaze}{pressure}{location}"
        for gaze in {"0", pose[0]}
        for pressure in {"1", pose[1]}
        for location in {"0", pose[2]}
    }
    assert possible == expected - {pose}


@pytest.mark.parametrize(
    ("pose", "original_leg", "our_leg", "reading", "cause"),
    [
        ("111", "released", "released", "111", pair.SAME),
        ("111", "released", "discarded", "011", pair.OUR_SENSORS),
        ("111", "released", "discarded", "111", pair.UNEXPLAINED),
        ("101", "discarded", "released", "111", pair.OUR_SENSORS),
        ("110", "discarded", "released", "111", pair.UNEXPLAINED),
        ("111", "discarded", "released", "111", pair.THEIR_SENSORS),
        ("101", "released", "discarded", "101", pair.THEIR_SENSORS),
        ("110", "released", "discarded", "110", pair.IMPOSSIBLE),
        ("111", "no-human-ready", "released", "111", pair.MISSED_SIGNAL),
        ("111", "released", "sensing-timeout", "none", pair.SILENT),
    ],
)
def test_why_a_turn_ended_differently(pose: str, original_leg: str, our_leg: str, reading: str, cause: str) -> None:
    assert Pair(then(leg(pose), [original_leg]), now([our_leg], [reading])).turn_causes() == [cause]


def test_a_record_with_other_turns_than_the_test_asks_for_explains_all_that_differs_in_it() -> None:
    found = Pair(then(leg("110"), ["discarded", "released"]), now(["discarded"], ["110"]))
    assert found.turn_causes() == [pair.SAME, pair.NOT_ASKED]
    bored = Pair(
        then([*BORED, *leg()], ["discarded", "released"]), now(["no-human-ready", "released"], ["none", "111"])
    )
    assert bored.turn_causes() == [pair.NOT_ASKED, pair.SAME]
    short = Pair(then([*leg(), *leg()], ["released"]), now(["released", "released"], ["111", "111"]))
    assert short.turn_causes() == [pair.SAME, pair.LOST]


def test_a_late_request_that_was_not_heard() -> None:
    checked = now(["no-human-ready"], ["none"], R1="NC", R2="NC")
    found = Pair(then(["receivesignal", "tell leg"], [], R1="NC", R2="NC", R3="NC"), checked)
    assert found.turn_causes() == [pair.NOT_HEARD]
    assert found.verdict_cause("R3") == pair.NOT_HEARD
    assert found.verdict_cause("R1") == pair.SAME


def test_ready_before_the_leg_is_held_out() -> None:
    lines = ["tell leg", "tell humanReady"]
    found = Pair(then(lines, ["discarded"], R1="NC"), now(["no-human-ready"], ["none"], R1="NC", R2="NC"))
    assert found.turn_causes() == [pair.EARLY]
    assert found.verdict_cause("R2") == pair.EARLY
    unsaid = Pair(then(lines[:1], ["discarded"], R1="NC"), now(["no-human-ready"], ["none"], R1="NC", R2="NC"))
    assert unsaid.turn_causes() == [pair.UNSAID]


@pytest.mark.parametrize(
    ("requirement", "pose", "legs", "ours", "cause"),
    [
        ("R1", "111", ["released"], now(["released"], ["111"]), pair.CONTRADICTION),
        ("R1", "111", ["discarded"], now(["released"], ["111"]), pair.THEIR_SENSORS),
        ("R1", "111", None, now(["released"], ["111"]), pair.UNRECORDED),
        ("R1", "101", None, now(["released"], ["111"]), pair.OUR_SENSORS),
        ("R1", "110", None, now(["released"], ["111"]), pair.UNEXPLAINED),
        ("R2", "110", ["discarded"], now(["discarded"], ["110"]), pair.CONTRADICTION),
        ("R2", "110", None, now(["discarded"], ["110"]), pair.UNRECORDED),
    ],
)
def test_why_a_requirement_was_not_checked_in_the_original(
    requirement: str, pose: str, legs: list[str] | None, ours: OurRun, cause: str
) -> None:
    assert Pair(then(leg(pose), legs, **{requirement: "NC"}), ours).verdict_cause(requirement) == cause


@pytest.mark.parametrize(
    ("ours", "cause"),
    [
        (now(["discarded"], ["011"], R1="NC"), pair.OUR_SENSORS),
        (now(["sensing-timeout"], ["none"], R1="NC"), pair.SILENT),
        (now(["discarded"], ["111"], R1="NC"), pair.UNEXPLAINED),
    ],
)
def test_why_a_requirement_is_not_checked_here(ours: OurRun, cause: str) -> None:
    assert Pair(then(leg("111"), ["released"]), ours).verdict_cause("R1") == cause


def test_where_the_hand_is_decides_the_third_requirement() -> None:
    found = Pair(then(leg("110"), ["discarded"], R3="Failed"), now(["discarded"], ["110"]))
    assert found.verdict_cause("R3") == pair.HAND


POSES_OF_TURNS = st.lists(st.tuples(st.sampled_from(POSES), st.booleans()), max_size=4)


@given(POSES_OF_TURNS, st.randoms(use_true_random=False))
def test_readings_without_an_error_are_assigned_to_their_turns_in_any_order(turns: list, random) -> None:  # type: ignore[no-untyped-def,type-arg]
    poses = [pose for pose, _ in turns]
    legs = ["no-human-ready" if bored else "released" if pose == "111" else "discarded" for pose, bored in turns]
    readings = ["none" if leg == "no-human-ready" else pose for pose, leg in zip(poses, legs, strict=True)]
    decisions = list(zip(readings, legs, strict=True))
    random.shuffle(decisions)
    requests = [LegRequest(pose, ready=True, bored=False) for pose in poses]
    assert readings_by_turn(legs, decisions, requests) == tuple(readings)


def test_a_reading_that_no_other_turn_explains_is_left_to_the_turn_that_erred() -> None:
    requests = [LegRequest(pose, ready=True, bored=False) for pose in ("111", "011")]
    decisions = [("011", "discarded"), ("011", "discarded")]
    assert readings_by_turn(["discarded", "discarded"], decisions, requests) == ("011", "011")
    decisions = [("000", "discarded"), ("110", "discarded")]
    assert readings_by_turn(["discarded", "discarded"], decisions, [requests[1], requests[0]]) == ("000", "110")
    with pytest.raises(ValueError, match="have the decisions"):
        readings_by_turn(["released"], decisions, requests)


def test_the_coverage_gain_of_a_release_and_of_a_timeout_are_separate() -> None:
    def one(legs: list[str], poses: list[str], covered_then: float, covered_now: float) -> Pair:
        lines = [line for pose in poses for line in (BORED if pose == "none" else leg(pose))]
        theirs = replace(then(lines, legs), suite="rl", coverage=covered_then)
        return Pair(theirs, replace(now(legs, poses), coverage=covered_now))

    plain = one(["discarded"], ["110"], 70.0, 80.0)
    released = one(["discarded", "released"], ["110", "111"], 78.0, 84.0)
    bored = one(["discarded", "no-human-ready"], ["110", "none"], 69.0, 83.0)
    assert gains([plain, released, bored]) == {
        "original": {"release": 8.0, "timeout": -1.0},
        "ours": {"release": 4.0, "timeout": 3.0},
    }
    assert gains([released])["ours"] == {"release": None, "timeout": None}
