"""The person's head and hand never come near table or robot, in tests of every suite."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

import pytest

from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.runtime import Recorder
from sim.geometry import UPRIGHT
from sim.layout import TABLE_M
from sim.world import World
from tests.hri import bench

TABLE = 1
"""Body of the table: the second that is added, after the floor."""

CLEAR_M = 0.01
SUITES = ("by-hand", "bdi-random", "pseudorandom")
FEW = 3
"""Tests of each suite that are run."""

PALM = "left_wrist_flex"
"""The person's hand may touch palm and fingers; tests/sim/test_hand_contact.py tests the forces."""


def too_near(world: World) -> set[str]:
    """The parts of table and robot that the person's head or hand is nearer to than CLEAR_M."""
    names = {link: name for name, link in world.torso.joints.items()} | {-1: "base"}
    found = set()
    for part in (world.person.hand.body, world.person.head.body):
        if world.engine.near(part, TABLE, CLEAR_M):
            found.add("table")
        found |= {names[link] for link, _ in world.engine.near(world.torso.body, part, CLEAR_M)}
    return found - {PALM}


@pytest.mark.slow
@pytest.mark.parametrize("suite", SUITES)
def test_the_person_keeps_clear_of_table_and_robot(suite: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert_clear(islice(bench.suite(suite), FEW), monkeypatch)


def assert_clear(tests: Iterable[ConcreteTest], monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the tests and look at every control tick of each."""
    ticks, tick = 0, World._tick

    def observed_tick(world: World) -> None:
        nonlocal ticks
        tick(world)
        ticks += 1
        assert world.engine.pose(TABLE)[0] == pytest.approx(TABLE_M)
        assert not too_near(world)

    monkeypatch.setattr(World, "_tick", observed_tick)
    for test in tests:
        bench.run(test)
    assert ticks > 100


def test_a_person_in_table_or_robot_is_noticed() -> None:
    with World(Recorder()) as world:
        hand, elbow = world.person.hand.body, world.torso.joints["left_elbow_flex"]
        assert world.engine.pose(TABLE)[0] == pytest.approx(TABLE_M)
        assert not too_near(world)
        world.engine.place(hand, (TABLE_M, UPRIGHT))
        assert "table" in too_near(world)
        arm = world.engine.link_mass_frame(world.torso.body, elbow)[0]
        world.engine.place(hand, (arm, UPRIGHT))
        assert "left_elbow_flex" in too_near(world)
