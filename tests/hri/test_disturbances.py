"""What goes wrong at the table reaches the controller's error paths, and its turns end as they should."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import pytest

from pytest_hricdv.coverage.measurement import Measurement
from pytest_hricdv.execution.case import UNMEASURED, CaseResult
from tests.hri import bench
from tests.hri.disturbed import Line, concrete, executed, judged, measurement, unknown_violations
from tests.sampling import mostly_slow

LEG = bench.leg("111")
NOT_READY = bench.leg("011")
ASKED, *THEN = LEG


def in_the_way(place: int, after_s: float, for_s: float = 60.0) -> Line:
    return ("somebody_in_the_way", {"place": place, "after_s": after_s, "for_s": for_s})


NO_LEG: list[Line] = [("leg_late", {"for_s": 100.0}), *LEG]
LEG_BESIDE: list[Line] = [("leg_displaced", {"dx_m": 0.08, "dy_m": 0.0}), *LEG]
LEG_SLIPS: list[Line] = [("leg_slips", {"after_s": 1.0, "grasp_n": 2.0}), *LEG]
NEXT_LEG_SLIPS: list[Line] = [*LEG[:2], ("leg_slips", {"after_s": 1.0, "grasp_n": 2.0}), *LEG[2:], *LEG]
LEG_TAKEN: list[Line] = [ASKED, ("leg_taken", {"after_s": 1.0, "next_s": 60.0}), *THEN]
HELD_LOOSELY: list[Line] = [("leg_loose", {"after_s": 1.0, "grasp_n": 5.5}), *LEG]
PULLED_OUT: list[Line] = [("leg_pulled_out", {"after_s": 1.0, "pull_n": 20.0}), *LEG]
PULLED_OUT_OF_THE_OPENING_HAND: list[Line] = [("leg_pulled_out", {"after_s": 7.9, "pull_n": 22.0}), *LEG]
PULLED_OUT_LATE: list[Line] = [("leg_pulled_out", {"after_s": 5.0, "pull_n": 20.0}), *LEG]
IN_HAND: list[Line] = [("leg_in_hand", {}), *LEG]
NO_WAY_TO_THE_LEG: list[Line] = [in_the_way(0, 1.0), *LEG]
STOPPED_BEFORE_THE_LEG: list[Line] = [in_the_way(0, 8.0), *LEG]
NO_WAY_TO_THE_PERSON: list[Line] = [in_the_way(1, 1.0), *LEG]
STOPPED_BEFORE_THE_PERSON: list[Line] = [in_the_way(1, 17.0), *LEG]
STEPS_IN_BEFORE_THE_LEG: list[Line] = [("somebody_steps_in", {"place": 0, "near_m": 0.4, "for_s": 20.0}), *LEG]
STEPS_IN_BEFORE_THE_BIN: list[Line] = [("somebody_steps_in", {"place": 2, "near_m": 0.4, "for_s": 20.0}), *NOT_READY]
NO_WAY_TO_THE_BIN: list[Line] = [in_the_way(2, 1.0), *NOT_READY]
NO_WAY_HOME: list[Line] = [*NOT_READY[:2], in_the_way(3, 0.0), *NOT_READY[2:]]
HELD_SHUT: list[Line] = [("hand_held_shut", {"grip_s": 20.0}), *LEG]
HELD_SHUT_OVER_THE_BIN: list[Line] = [("hand_held_shut", {"grip_s": 40.0}), *NOT_READY]
HELD_SHUT_AT_THE_START: list[Line] = [("leg_in_hand", {}), ("hand_held_shut", {"grip_s": 40.0}), *bench.leg("110")]
HELD_OPEN: list[Line] = [ASKED, ("hand_held_open", {"after_s": 5.0, "for_s": 30.0}), *THEN]
SILENT: list[Line] = [("sensors_silent", {"for_s": 150.0}), *LEG]
LATE: list[Line] = [("sensors_late", {"late_s": 8.0}), *LEG]
TOO_LATE: list[Line] = [("sensors_late", {"late_s": 60.0}), *LEG]
STUCK: list[Line] = [*LEG, ("sensors_stuck", {"for_s": 100.0}), *bench.leg("000")]
FLIPPED: list[Line] = [("gaze_flips", {}), *NOT_READY]
FLIPPED_AWAY: list[Line] = [("location_flips", {}), *LEG]
TOO_EARLY: list[Line] = [("says_ready", {"after_s": 6.0}), "tell leg", "receivesignal"]
UNASKED: list[Line] = ["tell leg", "receivesignal", ("says_ready", {"after_s": 6.0})]
ASKS_AGAIN: list[Line] = [("asks_again", {"after_s": 12.0}), *LEG]
FALLS_SILENT: list[Line] = [("falls_silent", {}), *LEG]


GONE_UNNOTICED: list[Line] = [("pressure_flips", {}), *PULLED_OUT_LATE]

REACHED = {
    'robot.note("something is in the hand at the start")': IN_HAND,
    'self.note(f"no plan: {error}")': NO_WAY_TO_THE_LEG,
    'return "pickup place not reached"': STOPPED_BEFORE_THE_LEG,
    'self.note(f"arm did not arrive within {path.duration_s:.1f} s")': STEPS_IN_BEFORE_THE_LEG,
    "robot.clock.sleep(robot.settings.retry_s)": NO_WAY_TO_THE_PERSON,
    'return "leg lost on the way"': LEG_SLIPS,
    'robot.note("no way to discard the leg yet")': NO_WAY_TO_THE_BIN,
    'robot.note("arm stays where it is")': NO_WAY_HOME,
    'robot.reason = "leg pulled out of the hand"': GONE_UNNOTICED,
}
"""The first statement of each block that only a disturbance reaches."""


def run(lines: Sequence[Line], measurement: Measurement = UNMEASURED) -> CaseResult:
    return judged(concrete(lines, sensing_timeout_s=30.0), measurement)


@cache
def undisturbed() -> list[str]:
    return executed(run([*LEG, *NOT_READY], measurement()))


@pytest.mark.parametrize("statement", mostly_slow(REACHED.keys(), 3))
def test_error_paths_are_reached(statement: str) -> None:
    found = executed(run(REACHED[statement], measurement()))
    if not found:
        pytest.skip("nothing is measured here, such as under a debugger")
    assert found.count(statement) == 1
    assert statement not in undisturbed()


ENDS: list[tuple[list[Line], str]] = [
    (NO_LEG, "discarded"),
    (LEG_BESIDE, "discarded"),
    (LEG_TAKEN, "discarded"),
    (LEG_SLIPS, "discarded"),
    (HELD_LOOSELY, "discarded"),
    (NEXT_LEG_SLIPS, "released discarded"),
    (PULLED_OUT, "discarded"),
    (PULLED_OUT_OF_THE_OPENING_HAND, "released"),
    (GONE_UNNOTICED, "discarded"),
    (IN_HAND, "released"),
    (NO_WAY_TO_THE_LEG, "discarded"),
    (STOPPED_BEFORE_THE_LEG, "discarded"),
    (NO_WAY_TO_THE_PERSON, "discarded"),
    (STOPPED_BEFORE_THE_PERSON, "no-human-ready"),
    (STEPS_IN_BEFORE_THE_LEG, "discarded"),
    (STEPS_IN_BEFORE_THE_BIN, "discarded"),
    (NO_WAY_TO_THE_BIN, "discarded"),
    (NO_WAY_HOME, "discarded"),
    (HELD_SHUT, "released"),
    (HELD_SHUT_OVER_THE_BIN, "discarded"),
    (HELD_SHUT_AT_THE_START, "discarded"),
    (HELD_OPEN, "discarded"),
    (SILENT, "sensing-timeout"),
    (LATE, "released"),
    (TOO_LATE, "sensing-timeout"),
    (STUCK, "released released"),
    (FLIPPED, "released"),
    (FLIPPED_AWAY, "discarded"),
    (TOO_EARLY, "no-human-ready"),
    (UNASKED, "discarded"),
    (ASKS_AGAIN, "released"),
    (FALLS_SILENT, "no-human-ready"),
]
"""How the turns of a run end, without a violation. Faults that some of these showed: `mended_faults`."""


@pytest.mark.parametrize(
    ("lines", "outcomes"), mostly_slow({f"{n} {str(end[0][0])[:40]}": end for n, end in enumerate(ENDS)}, 8)
)
def test_turns_end_as_the_disturbance_has_it(lines: list[Line], outcomes: str) -> None:
    result = run(lines)
    assert " ".join(result.outcome.outcomes) == outcomes
    assert not result.errors
    assert not unknown_violations(result)


def test_a_turn_that_the_robot_never_took_up_leaves_the_others_their_outcomes() -> None:
    result = run([("request_lost", {}), *LEG, *NOT_READY])
    assert result.outcome.outcomes == ("discarded",)
    assert list(result.outcome.cross["handover"]) == [("2", "not_bored", "011", "discarded")]


@pytest.mark.parametrize("after_s", [7.0, 9.0])
def test_nobody_tugs_at_a_leg_that_is_not_held_out_any_more(after_s: float) -> None:
    """On its way to the bin and over it; over it, one that was tugged at fell beside it."""
    *begin, ready = NOT_READY
    tugged = run([*begin, ("leg_pulled_out", {"after_s": after_s, "pull_n": 28.0}), ready])
    calm = run([*begin, ("leg_pulled_out", {"after_s": 10.0, "pull_n": 16.0}), ready])
    assert tugged.outcome.outcomes == calm.outcome.outcomes == ("discarded",)
    for signal in ("leg_held", "leg_height", "leg_offset", "leg_in_bin"):
        assert tugged.record.signals[signal] == calm.record.signals[signal]


@pytest.mark.parametrize("after_s", [4.05, 6.0, 7.8, 8.4])
def test_a_hand_between_closing_fingers_keeps_still_and_is_pressed_by_their_motors_only(after_s: float) -> None:
    """Drawn out or reached in while they closed, it was moved through them, and 140 N were blamed on the robot."""
    reached = run([ASKED, ("hand_held_open", {"after_s": after_s, "for_s": 5.0}), *THEN])
    assert reached.failed == ("R3",)
    assert 5.0 < max(reached.record.signals["hand_contact_force"][1]) < 30.0
