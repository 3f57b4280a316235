"""The person's head and hand go through neither table nor robot, whatever a suite makes the person do."""

from __future__ import annotations

from itertools import islice

import pytest

from sim.world import World
from tests.hri import bench

TABLE = 1
"""Body of the table: the second that is set up, after the floor."""

OWN_HAND = {"left_wrist_flex"}
"""The robot's palm, where the person's hand belongs; and the fingers, which feel it (tests/sim/test_touch.py)."""


@pytest.mark.parametrize("suite", ["by-hand", "bdi-random", "pseudorandom"])
def test_the_person_keeps_clear_of_table_and_robot(suite: str, monkeypatch: pytest.MonkeyPatch) -> None:
    nearest: dict[str, float] = {}
    tick = World._tick

    def observed_tick(world: World) -> None:
        tick(world)
        assert world.engine.pose(TABLE)[0][2] < 0.43
        for part in (world.person.hand.body, world.person.head.body):
            found = {"table": world.engine.distance(part, TABLE, -1)}
            for name, link in world.torso.joints.items():
                if name not in OWN_HAND and name != "left_shoulder_flex":  # a joint without a shape of its own
                    found[name] = world.engine.distance(part, world.torso.body, link)
            for name, distance_m in found.items():
                nearest[name] = min(distance_m, nearest.get(name, distance_m))

    monkeypatch.setattr(World, "_tick", observed_tick)
    for test in islice(bench.suite(suite), 4):
        bench.run(test)
    assert len(nearest) > 5
    assert min(nearest.values()) > 0.01, nearest
