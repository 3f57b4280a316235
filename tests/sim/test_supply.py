"""Four legs, one after the other: received ones on the person's side, discarded ones in the bin."""

from __future__ import annotations

import math

import pytest

from sim.layout import PICKUP_M, STORE_M, TABLE_TOP_M, in_bin
from sim.leg import Held
from sim.leg_supply import RESUPPLY_S

from .stage import Stage, one_leg


def test_four_legs_are_fetched_and_discarded_into_the_bin() -> None:
    with Stage() as stage:

        def four() -> None:
            for _ in range(4):
                assert stage.fetch()
                assert stage.discard()
            stage.kernel.sleep(4.0)
            legs = stage.world.legs.legs
            assert len(legs) == 5
            for leg in legs[:4]:
                assert leg.held is Held.DONE
                assert in_bin(leg.pose()[0])

        assert stage.run(four) == "over"


def test_four_legs_are_handed_over_and_set_down_on_the_persons_side() -> None:
    with Stage() as stage:
        human = stage.human(one_leg() * 4)
        stage.sensors()
        assert stage.run(lambda: stage.serve(4)) == "over"
        assert human.done
        assert stage.world.legs.received == 4
        places = [leg.pose()[0] for leg in stage.world.legs.legs[:4]]
        for place in places:
            assert place[0] > 0.9
            assert place[2] == pytest.approx(TABLE_TOP_M + 0.126)
        assert min(math.dist(a, b) for a in places for b in places if a is not b) > 0.09


def test_a_leg_that_fell_where_legs_are_held_out_is_cleared_away_before_the_next_one_comes() -> None:
    """The next leg in the hand hit it, and the blow moved the arm faster than R4 allows."""
    with Stage() as stage:

        def let_two_fall() -> None:
            assert stage.fetch()
            assert stage.robot.hand.open()
            stage.kernel.sleep(RESUPPLY_S + 0.1)
            first = stage.world.legs.legs[0]
            assert math.dist(first.pose()[0], STORE_M) < 1e-3
            assert stage.fetch()
            assert stage.world.legs.in_hand is stage.world.legs.legs[1]

        assert stage.run(let_two_fall) == "over"


def test_a_leg_that_is_withheld_comes_later_to_its_place_or_beside_it() -> None:
    with Stage() as stage:
        legs = stage.world.legs

        def body() -> None:
            first = legs.current
            legs.withhold(4.0)
            legs.displace(0.05, -0.03)
            assert legs.waiting is None
            assert legs.place() == PICKUP_M  # people look for it there
            stage.world.unfreeze()
            stage.kernel.sleep(3.9)
            assert legs.waiting is None
            stage.kernel.sleep(0.2)
            assert legs.waiting is first
            x, y, z = PICKUP_M
            assert math.dist(first.pose()[0], (x + 0.05, y - 0.03, z)) < 1e-6

        assert stage.run(body) == "over"


def test_a_leg_that_the_person_takes_is_set_down_and_the_next_one_comes_in_its_time() -> None:
    with Stage() as stage:
        legs, hand = stage.world.legs, stage.world.person.hand

        def body() -> None:
            taken = legs.current
            stage.kernel.sleep(hand.move(PICKUP_M))
            stage.world.unfreeze()
            legs.take(hand.body, 10.0)
            assert legs.carried is taken
            stage.kernel.sleep(hand.move((0.8, 0.2, 0.6)))
            assert math.dist(taken.pose()[0], hand.pose()[0]) < 0.05
            legs.set_down(taken)
            legs.set_down(taken)
            assert [legs.carried, legs.received] == [None, 1]
            stage.kernel.sleep(5.0)
            assert legs.waiting is None
            stage.kernel.sleep(5.0)
            assert legs.waiting is legs.legs[1]

        assert stage.run(body) == "over"
