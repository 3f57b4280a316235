"""The table of states: complete, as the case study has it, and every outcome is one that a state really returns."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from controller.machine import DONE, STATES, TRANSITIONS
from controller.ports import HumanReady, Reading, Request
from controller.waypoints import HOME, TO_PICKUP
from tests.controller.bench import READY, Bench


def nothing(bench: Bench) -> None:
    """A robot that everything goes well for."""


def arm_is_locked(bench: Bench) -> None:
    bench.arm.no_plan.add(HOME)


def person_asks(bench: Bench) -> None:
    bench.say(1.0, Request())


def pickup_place_is_blocked(bench: Bench) -> None:
    bench.arm.no_plan.add(TO_PICKUP[-1])


def person_answers(bench: Bench) -> None:
    bench.say(1.0, HumanReady())


def sensors_speak(bench: Bench) -> None:
    bench.say(1.0, READY)


def all_is_ready(bench: Bench) -> None:
    bench.robot.reading = READY
    bench.hand.held = True


def gaze_elsewhere(bench: Bench) -> None:
    bench.robot.reading = Reading(gaze=False, pressure=True, location=True)
    bench.hand.held = True


def fourth_turn(bench: Bench) -> None:
    for _ in range(3):
        bench.robot.end_turn()


DRIVEN: list[tuple[str, Callable[[Bench], None], str, str]] = [
    ("Reset", nothing, "at home", "Receive1"),
    ("Reset", arm_is_locked, "stuck", DONE),
    ("Receive1", person_asks, "request", "Move_hand"),
    ("Receive1", nothing, "timeout", "Timeout1"),
    ("Timeout1", nothing, "wait on", "Receive1"),
    ("Move_hand", nothing, "offered", "Send1"),
    ("Move_hand", pickup_place_is_blocked, "no leg", "Discard"),
    ("Send1", nothing, "told", "Receive2"),
    ("Receive2", person_answers, "ready", "Wait0"),
    ("Receive2", nothing, "timeout", "Timeout2"),
    ("Timeout2", nothing, "give up", "Discard"),
    ("Wait0", nothing, "settled", "Sensing"),
    ("Sensing", sensors_speak, "sensed", "Decide"),
    ("Sensing", nothing, "timeout", "Timeout3"),
    ("Timeout3", nothing, "give up", "Discard"),
    ("Decide", all_is_ready, "ready", "Release"),
    ("Decide", gaze_elsewhere, "not ready", "Discard"),
    ("Release", nothing, "next leg", "Receive1"),
    ("Release", fourth_turn, "table done", DONE),
    ("Discard", nothing, "next leg", "Receive1"),
    ("Discard", fourth_turn, "table done", DONE),
]


def test_there_are_the_thirteen_states_of_the_case_study() -> None:
    assert list(STATES) == [
        "Reset",
        "Receive1",
        "Timeout1",
        "Move_hand",
        "Send1",
        "Receive2",
        "Timeout2",
        "Wait0",
        "Sensing",
        "Timeout3",
        "Decide",
        "Release",
        "Discard",
    ]


@pytest.mark.parametrize(("state", "given", "outcome", "follows"), DRIVEN)
def test_a_state_driven_to_an_outcome_is_followed_by(
    state: str, given: Callable[[Bench], None], outcome: str, follows: str
) -> None:
    bench = Bench()
    given(bench)
    assert bench.enter(state) == outcome
    assert TRANSITIONS[state, outcome] == follows


def test_the_table_holds_the_driven_outcomes_and_no_other() -> None:
    assert list(TRANSITIONS) == [(state, outcome) for state, _, outcome, _ in DRIVEN]
    assert {state for state, _ in TRANSITIONS} == set(STATES)
    assert set(TRANSITIONS.values()) == set(STATES) - {"Reset"} | {DONE}


def test_a_good_turn_passes_the_states_in_the_order_of_the_case_study() -> None:
    bench = Bench(asks=1)
    bench.run(limit_s=28.0)
    good_turn = ["Reset", "Receive1", "Move_hand", "Send1", "Receive2", "Wait0", "Sensing", "Decide", "Release"]
    assert bench.states[: len(good_turn) + 1] == [*good_turn, "Receive1"]
