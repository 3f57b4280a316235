"""Coming nearer to a requirement that was never triggered."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.guidance import Guidance, regression
from pytest_hricdv.extra.closing.observation import Observation
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.generate.abstract import AbstractTest, identify
from pytest_hricdv.generate.rng import make_rng
from tests.extra.closing import handover

ALL_GIVEN: Point = ("verdict", "R5", "Passed")


def whole(test: AbstractTest) -> Observation:
    """A run."""
    return handover.run(test)


def ended(test: AbstractTest) -> Observation:
    """A run that is far away where it has less than three interactions; otherwise what was given counts a little."""
    found = handover.run(test)
    is_short = len(found.hits["handover"]) < 3
    near = tuple((point, 9.0 if is_short else 0.1 * distance) for point, distance in found.distances)
    return replace(found, distances=near)


def guided(numbers: list[int], run: Callable[[AbstractTest], Observation] = whole) -> tuple[Pool, Guidance]:
    """After runs of these tests of the pool."""
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(pool), Archive([ALL_GIVEN])
    for test in identify("closure", 0, [pool.draft(number) for number in numbers]):
        archive.add(run(test))
    experience.learn(archive)
    return pool, Guidance(pool, experience, archive)


@pytest.mark.parametrize("run", [whole, ended])
def test_tests_whose_interactions_end_well_are_tried_most(run: Callable[[AbstractTest], Observation]) -> None:
    pool, found = guided([*range(20), *range(30, 60)], run)
    rng, parts = make_rng("climbing"), Counter[int]()
    for _ in range(40):
        chosen = found.test(rng)
        assert chosen is not None
        assert chosen[1] == ALL_GIVEN
        parts[sum(interaction.planned[1] == "11" for interaction in pool.interactions(chosen[0]))] += 1
    assert parts[3] + parts[2] > 25


def test_where_no_open_point_has_a_distance_there_is_no_guidance() -> None:
    _, found = guided([])
    assert found.test(make_rng("none")) is None


slopes = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=4)


@given(slopes, st.floats(-10.0, 10.0))
def test_the_slopes_of_a_linear_function_are_found(wanted: list[float], offset: float) -> None:
    rows = [[1000.0 * (place == number) for place in range(len(wanted))] for number in range(len(wanted))]
    rows.append([0.0] * len(wanted))
    values = [offset + sum(slope * each for slope, each in zip(wanted, row, strict=True)) for row in rows]
    found = regression(rows, values)
    assert all(abs(one - other) < 1e-3 for one, other in zip(found, wanted, strict=True))
