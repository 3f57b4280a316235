"""Tests of several actors whose turns are chosen: which lines can meet, who is first, and what is aimed at."""

from __future__ import annotations

from itertools import permutations
from random import Random

import pytest

from pytest_hricdv.extra.closing.interleaving_strategy import (
    Encounter,
    InterleavingStrategy,
    PartialOrder,
    encounters_of,
)
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.strategy import Archive
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.actors import TURN, TURN_WAIT_S, After, TurnWait, interleave
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.sampler import Constant

LINES = ("a: one", "b: two", "a: three", "c: four", "b: five")
ORDERS: tuple[After, ...] = ({}, {5: (1,)}, {4: (3,), 5: (4,)}, {2: (1,), 3: (2,), 5: (3,)}, {4: (1, 2), 5: (4,)})
SPACE = BeliefSpace(start=("left", "right"), groups={})
POOL = Exploration((), ("left", "right"), (ExploredRun(LINES, 0, 1), ExploredRun(("a: one", "b: two"), 0, 2)))


def extensions(after: After) -> list[tuple[int, ...]]:
    """Every order in which these lines may begin."""
    lanes = [(1, 3), (2, 5)]
    before = [*lanes, *((cause, number) for number, causes in after.items() for cause in causes)]
    return [
        order
        for order in permutations(range(1, len(LINES) + 1))
        if all(order.index(first) < order.index(then) for first, then in before)
    ]


def met(order: tuple[int, ...]) -> set[Encounter]:
    return set(encounters_of(LINES[number - 1] for number in order))


@pytest.mark.parametrize("after", ORDERS)
@pytest.mark.parametrize("seed", range(4))
def test_turns_make_them_meet(after: After, seed: int) -> None:
    order = PartialOrder(LINES, after)
    for encounter, places in order.encounters.items():
        for place in places:
            chosen = order.with_encounter(place, Random(seed))
            assert chosen in extensions(after)
            assert encounter in met(chosen)
            turns = [chosen.index(number) / 4 for number in range(1, 6)]
            assert interleave(LINES, turns, after) == chosen


def test_who_is_to_wait_does_until_the_next_action_of_the_other_one_has_begun() -> None:
    order = PartialOrder(LINES, {})
    (place,) = order.waits[Encounter("b: two", "a: one")]
    assert (LINES[place.first - 1], LINES[place.then - 1]) == ("b: five", "a: one")
    assert Encounter("a: one", "c: four") in order.waits
    assert not any(encounter.first == "b: five" for encounter in order.waits), "there is no next one"


UP_TO_TEN = TurnWait(0.0, 10.0, "s")


def strategy(turn_wait: TurnWait | Constant = UP_TO_TEN) -> InterleavingStrategy:
    return InterleavingStrategy(Pool(POOL, SPACE, {}), turn_wait)


def wished(proposed: InterleavingStrategy, archive: Archive, count: int) -> list[tuple[Encounter, ...]]:
    """What the proposals make meet."""
    found = []
    for proposal in proposed.propose(archive, count, Random(1)):
        values = proposal.draft.values
        lines = proposal.draft.lines
        turns = [values[number][TURN] for number in range(1, len(lines) + 1)]
        assert values.get(RUN) in ([{TURN_WAIT_S: 5.0}, {TURN_WAIT_S: 10.0}] if proposal.targets else [None])
        found.append(
            tuple(encounters_of(lines[number - 1] for number in interleave(lines, turns, proposal.draft.after)))
        )
    return found


@pytest.mark.parametrize(
    ("bin_", "encounter"),
    [
        (("one", "two", "b"), Encounter("b: two", "a: one")),
        (("one", "two", "a"), Encounter("a: one", "b: two")),
        (("c: four", "b: five"), Encounter("c: four", "b: five")),
    ],
)
def test_an_open_bin_that_names_what_actors_do_is_aimed_at(bin_: tuple[str, ...], encounter: Encounter) -> None:
    point = ("bin", "orders", *bin_)
    archive = Archive([point])
    proposed = strategy()
    aimed = [
        (proposal, made)
        for proposal, made in zip(
            proposed.propose(archive, 20, Random(1)), wished(strategy(), archive, 20), strict=True
        )
        if proposal.targets
    ]
    assert len(aimed) > 3
    assert {proposal.targets for proposal, _ in aimed} == {(point,)}
    if len(bin_) == 3:
        assert all(encounter in made for _, made in aimed)
    else:  # who is first is not said
        both = {encounter, Encounter(encounter.then, encounter.first)}
        assert all(any(either in made for _, made in aimed) for either in both)


def test_runs_count_by_what_began_and_not_by_what_was_wished() -> None:
    archive = Archive([("statement", "cart.py", "1")])
    test = AbstractTest("t", "closure", "t", (), ("a: one", "b: two"), seed=1)
    rare = Encounter("b: two", "a: one")
    for _ in range(30):  # both meet, always in this order
        archive.add(RunObservation(test.to_data(), begun=(0, 1)))
    everything = set(PartialOrder(LINES, {}).encounters)
    for met_often in everything - {rare, Encounter("a: one", "b: two")}:
        lines = (met_often.first, met_often.then)
        for _ in range(30):
            archive.add(RunObservation(AbstractTest("t", "closure", "t", (), lines, seed=1).to_data(), begun=(0, 1)))
    assert all(rare in made for made in wished(strategy(), archive, 8))
