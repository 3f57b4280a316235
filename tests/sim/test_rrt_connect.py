"""The sampler of detours in a plane with a wall that has a gap: what it finds is free, and the same each time."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.rrt_connect import Angles, RrtConnect

LIMITS = ((-2.0, 2.0), (-2.0, 2.0))
SAMPLE_RAD = 0.05
ENOUGH = 20_000


def beside_the_wall(pose: Angles) -> bool:
    """A wall along y, 0.2 wide, with a gap at the far end."""
    x, y = pose
    return abs(x) > 0.1 or y > 1.5


@pytest.mark.engine("pybullet")
@given(st.integers(0, 2**31), st.tuples(st.floats(-1.9, -0.2), st.floats(-1.9, 1.0)), st.floats(0.2, 1.9))
def test_a_way_leads_through_the_gap(seed: int, start: Angles, x: float) -> None:
    goal = (x, -1.0)
    ways = [RrtConnect(LIMITS, beside_the_wall, SAMPLE_RAD, ENOUGH, seed).way(start, goal) for _ in range(2)]
    assert ways[0] is not None
    assert ways[0] == ways[1]
    assert max(y for _, y in ways[0]) > 1.4
    assert len(ways[0]) < 12  # what is not needed was left out
    wide = SAMPLE_RAD  # between two checks a corner may be cut
    for here, there in itertools.pairwise((start, *ways[0], goal)):
        assert all(low <= angle <= high for angle, (low, high) in zip(there, LIMITS, strict=True))
        assert math.dist(here, there) > 0.0
        middle = tuple((a + b) / 2 for a, b in zip(here, there, strict=True))
        assert abs(middle[0]) > 0.1 - wide or middle[1] > 1.5 - wide


def test_where_there_is_no_way_the_search_ends() -> None:
    asked = 0

    def closed(pose: Angles) -> bool:
        nonlocal asked
        asked += 1
        return abs(pose[0]) > 0.1

    assert RrtConnect(LIMITS, closed, SAMPLE_RAD, 500, seed=1).way((-1.0, 0.0), (1.0, 0.0)) is None
    assert asked == 500


def test_a_way_that_was_found_with_the_last_check_is_kept() -> None:
    budgets = range(20, 2000, 5)
    start, goal = (-1.0, 0.0), (1.0, 0.0)
    ways = [RrtConnect(LIMITS, beside_the_wall, SAMPLE_RAD, checks, seed=3).way(start, goal) for checks in budgets]
    lengths = [len(way) for way in ways if way is not None]
    assert None in ways
    assert lengths[0] > lengths[-1]
