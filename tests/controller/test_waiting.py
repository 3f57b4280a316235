"""States that wait: what ends a wait, what does not, and how long each lasts by its own clock."""

from __future__ import annotations

import pytest

from controller.ports import HumanReady, Request
from controller.settings import Settings
from tests.controller.bench import Bench


def test_receive1_polls_sixty_times_50_ms_apart() -> None:
    bench = Bench()
    assert bench.enter("Receive1") == "timeout"
    assert bench.kernel.now_s == pytest.approx(60 * 0.05)


@pytest.mark.parametrize(
    ("state", "message", "poll_s"), [("Receive1", Request(), 0.05), ("Receive2", HumanReady(), 0.25)]
)
def test_a_message_is_noticed_at_the_next_poll(state: str, message: object, poll_s: float) -> None:
    bench = Bench()
    bench.say(1.01, message)
    bench.enter(state)
    assert 1.01 < bench.kernel.now_s <= 1.01 + poll_s


def test_a_robot_that_nobody_asks_waits_on_and_notes_it_once() -> None:
    bench = Bench(asks=0)
    assert bench.run(limit_s=61.0) == "limit"
    assert bench.states[:-1] == ["Reset", *["Receive1", "Timeout1"] * 20]
    assert [note for note in bench.robot.journal.notes if "nobody asks" in note] == ["3.00 s: nobody asks"]
    assert bench.outcomes == []


@pytest.mark.parametrize("pause_s", [2.96, 3.0, 30.0])
def test_a_request_that_comes_just_when_the_robot_times_out_is_not_lost(pause_s: float) -> None:
    bench = Bench(asks=1, pause_s=pause_s)
    bench.run(limit_s=60.0)
    assert bench.outcomes == ["released"]


def test_a_person_who_does_not_answer_costs_the_turn() -> None:
    bench = Bench(asks=1, answers=[])
    bench.run(limit_s=100.0)
    assert bench.states[4:8] == ["Receive2", "Timeout2", "Discard", "Receive1"]
    assert bench.entered_s("Timeout2")[0] - bench.entered_s("Receive2")[0] == pytest.approx(15.0)
    assert bench.outcomes == ["no-human-ready"]
    assert bench.reasons == ["no answer within 15 s"]


@pytest.mark.parametrize("timeout_s", [10.0, 42.5, 100.0])
def test_silent_sensors_cost_the_turn_after_the_sensing_timeout(timeout_s: float) -> None:
    bench = Bench(Settings(sensing_timeout_s=timeout_s), asks=1, readings=[None])
    bench.run(limit_s=200.0)
    assert bench.states[6:10] == ["Sensing", "Timeout3", "Discard", "Receive1"]
    assert bench.entered_s("Timeout3")[0] - bench.entered_s("Sensing")[0] == pytest.approx(timeout_s)
    assert bench.outcomes == ["sensing-timeout"]
    assert bench.reasons == [f"no reading within {timeout_s:.1f} s"]
