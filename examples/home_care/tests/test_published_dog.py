"""The published dog: what it does where the robot, or the end of its area, is near."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from people.published_dog import STEP_M, PublishedDog

PLACE = tuple[float, float]


def allowed(dog: PLACE, robot: PLACE, step: PLACE, seed: int) -> PLACE:
    """The step that it makes in place of this one."""
    run: Any = SimpleNamespace(test=SimpleNamespace(seed=seed))
    house: Any = SimpleNamespace(dog=SimpleNamespace(at=dog), base=SimpleNamespace(at=robot))
    return PublishedDog(run, house)._allowed(step)


def test_within_its_area_it_walks_on_into_the_robot() -> None:
    assert {allowed((-1.0, -3.0), (-0.7, -3.0), (0.1, 0.0), seed) for seed in range(20)} == {(0.1, 0.0)}


def test_at_the_end_of_its_area_it_goes_another_way_by_small_steps() -> None:
    for seed in range(20):
        x, y = allowed((0.45, -3.0), (-2.4, -3.95), (0.1, 0.0), seed)
        assert abs(x) <= STEP_M
        assert abs(y) <= STEP_M
        assert 0.45 + x <= 0.5


def test_there_and_near_the_robot_it_jumps() -> None:
    steps = [allowed((-2.45, -3.5), (-2.4, -3.95), (-0.1, 0.0), seed) for seed in range(50)]
    assert sum(max(abs(x), abs(y)) > STEP_M for x, y in steps) > 40
