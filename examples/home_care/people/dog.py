"""The dog: a bystander that roams about the living room, follows the robot, or lies where it is."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

from house.flat import DOG_AREA, STANDS
from house.house import House

from people.published_dog import PublishedDog
from pytest_hricdv.testbench import Bystander, Run, Uniform

REST_OF_RUN_S = 10_000.0
"""Longer than any run."""

_TROTS = {"speed_m_s": Uniform(0.3, 1.0, "m/s")}  # chosen: a dog indoors, slower and faster than the robot

DOG = Bystander(
    "dog",
    {
        "lie_down": {},
        "roam": {
            # Its area as published, without the robot's way through the opening of the wall: there it comes by itself.
            "x_m": Uniform(DOG_AREA.x1, DOG_AREA.x2, "m"),
            "y_m": Uniform(DOG_AREA.y1, -1.2, "m"),
            **_TROTS,
        },
        # From middle to middle: the robot's hull and the dog's length leave about 0.1 m of 0.6 m.
        "follow": {"near_m": Uniform(0.6, 1.2, "m"), "for_s": Uniform(10.0, 120.0, "s"), **_TROTS},
    },
    most=4,
    pause_s=Uniform(0.0, 60.0, "s"),
)


BESIDE_PERSON = STANDS
"""Where it lies down when it is called: before the sofa."""


@dataclass(frozen=True)
class DogCalled:
    """The person calls the dog."""


COMES_M_S = 0.8
"""When it is called (chosen)."""


AS_PUBLISHED = "published"
"""Of `DOG_VARIABLE`: the dog of the published case, which can jump into the robot."""

DOG_VARIABLE = "HOME_CARE_DOG"
"""Environment variable: which dog it is; empty for the one that walks. A study compares both."""


def bystanders() -> tuple[Bystander, ...]:
    """The dog, where it is one that has acts of its own: the published one has none."""
    return () if os.environ.get(DOG_VARIABLE) == AS_PUBLISHED else (DOG,)


def spawn_dog(run: Run, house: House) -> None:
    """Start the dog's nodes: one for its own acts, one by which it comes when it is called."""
    if DOG.name not in run.bystanders:
        run.kernel.spawn(DOG.name, PublishedDog(run, house).live)
        return
    called = run.bus.port("dog").subscribe(DogCalled)
    calls = 0

    def live() -> None:
        for action in run.actions(DOG.name):
            if action.command == "lie_down":
                house.dog.stay()
            elif action.command == "roam":
                house.dog.go((action.parameters["x_m"], action.parameters["y_m"]), action.parameters["speed_m_s"])
            else:
                follow(action.parameters)

    def follow(how: Mapping[str, float]) -> None:
        before = calls
        house.dog.follow(lambda: house.base.at, how["near_m"], how["speed_m_s"])
        run.kernel.sleep(how["for_s"])
        if calls == before:
            house.dog.stay()

    def hear() -> None:
        nonlocal calls
        while called.wait(REST_OF_RUN_S) is not None:
            calls += 1
            house.dog.go(BESIDE_PERSON if house.person.seated else house.person.at, COMES_M_S)

    run.kernel.spawn("dog", live)
    run.kernel.spawn("dog hears", hear)
