"""Coming nearer to a requirement that was never triggered."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest
from msgspec.structs import replace

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.climbing import Climbing
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.observation import Observation
from pytest_hricdv.extra.closing.scripts import Scripts
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


def climbing(numbers: list[int], run: Callable[[AbstractTest], Observation] = whole) -> tuple[Scripts, Climbing]:
    """After runs of these scripts."""
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(scripts), Archive([ALL_GIVEN])
    for test in identify("closure", 0, [scripts.draft(number) for number in numbers]):
        archive.add(run(test))
    experience.learn(archive)
    return scripts, Climbing(scripts, experience, archive)


@pytest.mark.parametrize("run", [whole, ended])
def test_scripts_whose_interactions_end_well_are_tried_most(run: Callable[[AbstractTest], Observation]) -> None:
    scripts, found = climbing([*range(20), *range(30, 60)], run)
    rng, given = make_rng("climbing"), Counter[int]()
    for _ in range(40):
        chosen = found.script(rng)
        assert chosen is not None
        assert chosen[1] == ALL_GIVEN
        given[sum(slot.planned[1] == "11" for slot in scripts.slots(chosen[0]))] += 1
    assert given[3] + given[2] > 25


def test_a_script_that_was_run_in_vain_again_and_again_yields_to_others() -> None:
    """What is best may be another one, which failed by chance when it was run first."""

    def failing(test: AbstractTest) -> Observation:
        found = handover.run(test)
        return replace(found, distances=((ALL_GIVEN, 4.0 - sum(hit[-1] == "given" for hit in found.hits["handover"])),))

    runs = [*range(20), *range(30, 60)]

    def chosen(numbers: list[int]) -> Counter[int]:
        _, found = climbing(numbers, failing)
        rng = make_rng("again")
        return Counter(script[0] for _ in range(40) if (script := found.script(rng)) is not None)

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

    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    slots = [[slot.planned for slot in scripts.slots(number)] for number in range(len(scripts.runs))]
    once = next(number for number, each in enumerate(slots) if each.count(("3", "11")) == 1)
    _, found = climbing([*range(20), once, *[slots.index([("2", "11")] * 2)] * 3], unlucky)
    best, rng = slots.index([("3", "11")] * 3), make_rng("again")
    assert sum((found.script(rng) or (None,))[0] == best for _ in range(40)) > 10


def test_where_no_open_point_has_a_distance_there_is_nothing_to_climb() -> None:
    _, found = climbing([])
    assert found.script(make_rng("none")) is None
