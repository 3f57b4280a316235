"""A leg that is pulled at with more than the grasp holds comes out of the closed hand, and everybody notices."""

from __future__ import annotations

import math

import pytest

from sim.leg import Held
from tests.hri import bench

from .stage import Stage


def pulled(pull_n: float, *, at_leg: bool) -> Stage:
    """The stage after a pull at a leg that is held out, from 2 s before its end; the person's hand goes away then."""
    with Stage() as stage:
        world = stage.world

        def body() -> None:
            assert stage.fetch()
            x, y, z = world.legs.current.pose()[0]
            if at_leg:
                stage.kernel.sleep(world.person.hand.move((x + 0.03, y, z - 0.03)))
            world.unfreeze()
            world.person.pull(pull_n)
            stage.kernel.sleep(1.0)
            assert stage.robot.hand.holds() == (pull_n < 15.0)
            world.person.pull(0.0)
            if at_leg:
                stage.kernel.sleep(world.person.hand.move((0.75, 0.0, 0.70)))
                hand = world.person.hand.pose()[0]
                if pull_n > 15.0:
                    assert math.dist(world.legs.legs[0].pose()[0], hand) < 0.15  # it went with the hand
            stage.kernel.sleep(1.0)

        assert stage.run(body) == "over"
        return stage


@pytest.mark.parametrize("pull_n", [12.0, 14.0])
def test_a_leg_that_is_pulled_at_with_less_than_the_grasp_holds_stays(pull_n: float) -> None:
    signals = pulled(pull_n, at_leg=True).recorder.finish().signals
    assert list(signals["leg_held"][1]) == [False, True]
    assert list(signals["leg_torn"][1]) == [False]


@pytest.mark.parametrize("pull_n", [16.0, 20.0, 30.0])
def test_a_leg_that_is_pulled_at_with_more_leaves_with_the_persons_hand(pull_n: float) -> None:
    stage = pulled(pull_n, at_leg=True)
    signals = stage.recorder.finish().signals
    assert list(signals["leg_held"][1]) == [False, True, False]
    assert list(signals["leg_torn"][1]) == [False, True]
    assert signals["leg_torn"][0][1] == signals["leg_held"][0][2]
    assert stage.world.legs.legs[0].held is Held.PERSON


@pytest.mark.parametrize("fidelity", ["dynamic", "kinematic"])
def test_the_robot_discards_what_was_torn_away_and_that_is_no_release(
    fidelity: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conftest.FIDELITY", fidelity)
    result = bench.run(bench.concrete(bench.leg(), pull_n=25.0))
    assert list(result.record.signals["leg_torn"][1]) == [False, True]
    assert bench.times(result, "reading", pressure=False)
    assert result.outcome.outcomes == ("discarded",)
    assert (result.verdict("R1").verdict, result.verdict("R2").verdict) == ("NC", "Passed")
