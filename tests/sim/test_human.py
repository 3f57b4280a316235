"""The person enacts the script, at human speed, and reacts to the robot."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from controller.ports import LegReady, TurnDone
from pytest_hricdv.runtime import NodeError
from sim.engine import SimulationError
from sim.human import Human
from sim.layout import AWAY_HAND_M, REST_HAND_M, SEAT_HEAD_M
from sim.script import PARAMETERS, check_script

from .stage import AT_LEG, LOOKING, Stage, Step

TELL: Step = ("tell leg", {"voice_s": 2.0, "rest_x_m": 0.6, "rest_y_m": -0.2, "rest_z_m": 0.5})


def times_of(stage: Stage, topic: str) -> list[float]:
    return [m.time_s for m in stage.recorder.messages if m.topic == topic]


def test_the_request_is_heard_at_the_end_of_the_voice_and_then_the_hand_rests_over_the_table() -> None:
    with Stage() as stage:
        stage.human([TELL, ("receivesignal", {})])
        stage.run(lambda: stage.kernel.sleep(5.0))
        assert times_of(stage, "request") == [2.0]
        assert stage.world.person.hand.pose()[0] == pytest.approx((0.6, -0.2, 0.5))


def test_waits_for_the_signal_no_longer_than_its_patience() -> None:
    for patience_s, expected_s in ((60.0, 60.0), (7.0, 7.0)):
        with Stage() as stage:
            stage.human([("receivesignal", {}), ("tell humanReady", {"voice_s": 1.0})], patience_s)
            stage.run(lambda: stage.kernel.sleep(70.0))
            assert times_of(stage, "human_ready") == [pytest.approx(expected_s + 1.0)]


def test_goes_on_as_soon_as_the_signal_comes() -> None:
    with Stage() as stage:
        stage.human([TELL, ("receivesignal", {}), ("tell humanReady", {"voice_s": 1.0})])

        def announce() -> None:
            stage.kernel.sleep(20.0)
            stage.bus.port("robot").publish(LegReady(1))
            stage.kernel.sleep(5.0)

        stage.run(announce)
        assert times_of(stage, "human_ready") == [pytest.approx(21.0)]


@pytest.mark.parametrize(("answered", "expected_s"), [(True, 32.0), (False, None)])
def test_asks_for_the_next_leg_when_the_turn_of_an_announced_leg_is_done(
    answered: bool, expected_s: float | None
) -> None:
    with Stage() as stage:
        stage.human([TELL, ("receivesignal", {}), TELL])

        def turn() -> None:
            port = stage.bus.port("robot")
            stage.kernel.sleep(10.0)
            port.publish(LegReady(1))
            stage.kernel.sleep(20.0)
            if answered:
                port.publish(TurnDone(1, "discarded"))
            stage.kernel.sleep(160.0)

        stage.run(turn)
        second_s = times_of(stage, "request")[1]
        if expected_s is None:
            assert 2.0 < second_s - 10.0 - 150.0 < 4.0  # out of patience, and sits back before asking
        else:
            assert expected_s <= second_s < expected_s + 2.0  # back to rest, then the voice


def test_stops_pulling_when_the_turn_is_done() -> None:
    with Stage() as stage:
        stage.human([TELL, ("receivesignal", {}), ("set_param pressure = 1", {"pull_n": 8.0, "grip_s": 0.0})])

        def turn() -> None:
            port = stage.bus.port("robot")
            assert stage.fetch()
            port.publish(LegReady(1))
            stage.kernel.sleep(3.0)
            assert stage.world.pressure.change_n() == pytest.approx(8.0, rel=0.02)
            port.publish(TurnDone(1, "discarded"))
            stage.kernel.sleep(3.0)
            assert stage.world.pressure.change_n() == pytest.approx(0.0, abs=0.05)
            assert stage.world.person.hand.pose()[0] == pytest.approx(REST_HAND_M)

        assert stage.run(turn) == "over"


def test_a_bored_person_walks_off_and_answers_nothing_until_the_next_leg() -> None:
    script: list[Step] = [
        TELL,
        ("bored", {}),
        ("set_param location = 1", AT_LEG),
        ("tell humanReady", {"voice_s": 1.0}),
    ]
    with Stage() as stage:
        human = stage.human([*script])
        stage.run(lambda: stage.kernel.sleep(20.0))
        assert human.done
        assert times_of(stage, "human_ready") == []
        assert stage.world.person.hand.pose()[0] == pytest.approx(AWAY_HAND_M)
        assert math.dist(stage.world.person.head.pose()[0], SEAT_HEAD_M) > 1.0
    with Stage() as stage:
        stage.human([*script, TELL, ("tell humanReady", {"voice_s": 1.0})])
        stage.run(lambda: stage.kernel.sleep(30.0))
        assert len(times_of(stage, "request")) == 2
        assert len(times_of(stage, "human_ready")) == 1
        assert stage.world.person.head.pose()[0] == pytest.approx(SEAT_HEAD_M)


def test_gaze_and_location_are_where_the_script_says_relative_to_the_leg() -> None:
    with Stage() as stage:
        stage.human(
            [("set_param gaze = 1", LOOKING), ("set_param location = 0", {"dx_m": 0.6, "dy_m": 0.5, "dz_m": 0.7})]
        )
        stage.run(lambda: stage.kernel.sleep(10.0))
        leg = stage.world.legs.current
        x, y, z = leg.pose()[0]
        assert stage.world.person.hand.pose()[0] == pytest.approx((x + 0.6, y + 0.5, z + 0.7), abs=1e-4)
        assert math.dist(stage.world.person.head.pose()[0], (x, y, z)) == pytest.approx(0.55, abs=1e-4)


@pytest.mark.parametrize("command", [c for c, names in PARAMETERS.items() if names])
def test_a_missing_or_bad_parameter_is_named(command: str) -> None:
    full = dict.fromkeys(PARAMETERS[command], 0.5)
    check_script([(command, full)])
    for name in PARAMETERS[command]:
        with pytest.raises(SimulationError, match=name):
            check_script([(command, {n: v for n, v in full.items() if n != name})])
        with pytest.raises(SimulationError, match="finite"):
            check_script([(command, {**full, name: math.nan})])


def test_an_unknown_command_is_named_with_the_known_ones() -> None:
    with Stage() as stage, pytest.raises(SimulationError, match=r"step 2: unknown command 'dance'.*bored"):
        Human(stage.world, stage.bus.port("human"), stage.kernel, [("bored", {}), ("dance", {})])


def test_of_a_script_that_is_produced_each_step_is_taken_and_checked_when_it_begins() -> None:
    with Stage() as stage:
        taken_s = []

        def script() -> Iterator[Step]:
            for step in (TELL, ("bored", {}), ("dance", {})):
                taken_s.append(stage.kernel.now_s)
                yield step

        stage.human(script())
        with pytest.raises(NodeError, match="step 3: unknown command 'dance'"):
            stage.run(lambda: stage.kernel.sleep(60.0))
        assert taken_s[0] == 0.0
        assert 2.0 < taken_s[1] < taken_s[2]
