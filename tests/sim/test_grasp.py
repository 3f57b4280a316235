"""Grasping, holding, feeling a pull, letting go: by what leg and fingers do."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from controller import waypoints
from sim.fingers import CLOSED
from sim.gripper import RELEASE_RAD
from sim.world import World

from .stage import Stage


def in_palm(world: World) -> tuple[float, ...]:
    """The leg's place in the palm's frame (m)."""
    return world.torso.to_palm(world.legs.current.pose())[0]


def play(body: Callable[[Stage], None], *, freeze: bool = True) -> Stage:
    with Stage(freeze=freeze) as stage:
        assert stage.run(lambda: body(stage)) == "over"
        return stage


def hand_to_leg(stage: Stage) -> None:
    leg = stage.world.legs.current
    x, y, z = leg.pose()[0]
    stage.kernel.sleep(stage.world.person.hand.move((x + 0.03, y, z - 0.03)))


@pytest.mark.parametrize("pull_n", [0.0, 10.0])
def test_a_held_leg_stays_in_the_hand_within_2_mm(pull_n: float) -> None:
    def body(stage: Stage) -> None:
        arm = stage.robot.arm
        assert arm.follow(arm.plan(waypoints.TO_PICKUP, 0.25))
        assert stage.robot.hand.close()
        grasped = in_palm(stage.world)
        stage.world.person.pull(pull_n)
        for way in (waypoints.TO_HANDOVER, waypoints.TO_RESUPPLY, waypoints.TO_HANDOVER):
            assert arm.follow(arm.plan(way, 0.25))
            assert math.dist(in_palm(stage.world), grasped) < 0.002
        stage.kernel.sleep(60.0)
        assert math.dist(in_palm(stage.world), grasped) < 0.002

    play(body, freeze=False)


@pytest.mark.parametrize("pull_n", [6.0, 8.0, 10.0])
def test_the_palm_feels_the_pull(pull_n: float) -> None:
    def body(stage: Stage) -> None:
        assert stage.fetch()
        assert stage.world.pressure.change_n() == pytest.approx(0.0, abs=0.05)
        stage.world.person.pull(pull_n)
        stage.kernel.sleep(0.2)
        assert 0.2 * pull_n < stage.world.pressure.change_n() < 0.9 * pull_n  # it rises smoothly
        stage.kernel.sleep(2.0)
        assert stage.world.pressure.change_n() == pytest.approx(pull_n, rel=0.02)
        stage.world.person.pull(0.0)
        stage.kernel.sleep(1.0)
        assert stage.world.pressure.change_n() == pytest.approx(0.0, abs=0.05)

    play(body)


def test_closing_takes_its_time_and_is_signalled_while_fingers_move() -> None:
    stage = play(lambda stage: None if stage.fetch() else pytest.fail("no leg"))
    signals = stage.recorder.finish().signals
    (_, began_s, ended_s), values = signals["hand_closing"]
    assert list(values) == [False, True, False]
    assert 1.0 < ended_s - began_s < 1.5
    (_, held_s), _ = signals["leg_held"]
    assert held_s == ended_s


def test_the_persons_hand_is_measured_at_each_step_of_closing() -> None:
    def body(stage: Stage) -> None:
        arm = stage.robot.arm
        assert arm.follow(arm.plan(waypoints.TO_PICKUP, 0.25))
        stage.kernel.sleep(stage.world.person.hand.move((0.47, -0.30, 0.62)))
        assert stage.robot.hand.close()

    signals = play(body).recorder.finish().signals
    times, distances = signals["hand_distance"]
    began_s, ended_s = signals["hand_closing"][0][1:]
    assert times[1] == began_s  # known from the instant at which the closing begins
    assert 0.0 < min(distances[1:]) < 0.05
    assert len(times) > 80
    assert began_s <= min(times[1:]) <= max(times) <= ended_s


def test_a_released_leg_goes_with_the_hand_that_is_at_it() -> None:
    def body(stage: Stage) -> None:
        assert stage.fetch()
        hand_to_leg(stage)
        assert stage.robot.hand.open()
        assert not stage.robot.hand.holds()
        leg = stage.world.legs.carried
        assert leg is not None
        stage.kernel.sleep(stage.world.person.hand.move((0.9, 0.3, 0.7)))
        stage.kernel.sleep(0.5)
        assert math.dist(leg.pose()[0], (0.87, 0.3, 0.73)) < 0.01

    play(body)


def test_the_leg_is_let_go_when_the_fingers_have_opened() -> None:
    angles: list[float] = []

    def body(stage: Stage) -> None:
        assert stage.fetch()
        release = stage.world.legs.release

        def look_and_release(hand: int | None) -> None:
            angles.extend(stage.world.fingers.angles()[2::2])
            release(hand)

        stage.world.legs.release = look_and_release  # type: ignore[method-assign]
        began_s = stage.kernel.now_s
        assert stage.robot.hand.open()
        assert 0.3 < stage.kernel.now_s - began_s <= 1.0

    signals = play(body).recorder.finish().signals
    assert RELEASE_RAD < min(angles) < RELEASE_RAD + 0.05
    assert list(signals["leg_held"][1]) == [False, True, False]
    assert signals["leg_offset"][1][-1] > 0.1  # it fell
    released_s = signals["leg_held"][0][2]
    at_release = [v for t, v in zip(*signals["leg_offset"], strict=True) if t <= released_s]
    assert at_release[-1] < 0.002


@pytest.mark.parametrize("grip_s", [4.0, 12.0])
def test_a_grip_keeps_the_fingers_from_opening_while_it_lasts(grip_s: float) -> None:
    def body(stage: Stage) -> None:
        assert stage.fetch()
        hand_to_leg(stage)
        stage.world.person.grip(grip_s)
        began_s = stage.kernel.now_s
        while not stage.robot.hand.open():
            assert stage.kernel.now_s - began_s < grip_s + 2.0
            if stage.kernel.now_s - began_s < grip_s:
                assert stage.robot.hand.holds()
                for angle, closed in list(zip(stage.world.fingers.angles(), CLOSED, strict=True))[2:]:
                    assert abs(angle - closed) < 0.3
        assert grip_s < stage.kernel.now_s - began_s < grip_s + 2.0
        assert stage.world.legs.carried is not None

    play(body)
