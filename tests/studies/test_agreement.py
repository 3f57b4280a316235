"""Causes of differences between the original's runs and ours."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.script import PARAMETERS
from studies.agreement import pair
from studies.agreement.pair import OurRun, Pair, readings_by_turn
from studies.original.requests import LegRequest
from studies.original.runs import OriginalRun, load_runs
from tests.hri.bench import leg

PASSED = {"R1": "Passed", "R2": "Passed", "R3": "Passed"}
POSES = ["".join(bits) for bits in product("01", repeat=3)]


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
