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


def test_a_test_that_was_run_in_vain_again_and_again_yields_to_others() -> None:
    """What is best may be another one, which failed by chance when it was run first."""

    def failing(test: AbstractTest) -> Observation:
        found = handover.run(test)
        return replace(found, distances=((ALL_GIVEN, 4.0 - sum(hit[-1] == "given" for hit in found.hits["handover"])),))

    runs = [*range(20), *range(30, 60)]

    def chosen(numbers: list[int]) -> Counter[int]:
        _, found = guided(numbers, failing)
        rng = make_rng("again")
        return Counter(script[0] for _ in range(40) if (script := found.test(rng)) is not None)

    [(favourite, often)] = chosen(runs).most_common(1)
    assert chosen([*runs, *[favourite] * 12])[favourite] < often / 2


def test_what_failed_once_by_chance_is_tried_again() -> None:
    """Three interactions that are well prepared give three parts, but the first time one of them failed."""

    def unlucky(test: AbstractTest) -> Observation:
        found = handover.run(test)
        hits = tuple((*hit[:2], "kept" if hit[:2] == ("3", "11") else hit[2]) for hit in found.hits["handover"])
        return replace(
            found,
            hits={**found.hits, "handover": hits},
            distances=((ALL_GIVEN, 3.0 - sum(hit[-1] == "given" for hit in hits)),),
        )

    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    interactions = [
        [interaction.planned for interaction in pool.interactions(number)] for number in range(len(pool.tests))
    ]
    once = next(number for number, each in enumerate(interactions) if each.count(("3", "11")) == 1)
    _, found = guided([*range(20), once, *[interactions.index([("2", "11")] * 2)] * 3], unlucky)
    best, rng = interactions.index([("3", "11")] * 3), make_rng("again")
    assert sum((found.test(rng) or (None,))[0] == best for _ in range(40)) > 10


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


def test_what_never_varied_and_what_nothing_depends_on_has_no_slope() -> None:
    assert regression([[1.0, 0.0], [1.0, 1.0]] * 10, [2.0, 2.0] * 10) == [0.0, 0.0]
    assert regression([], []) == []
    assert regression([[], []], [1.0, 2.0]) == []
