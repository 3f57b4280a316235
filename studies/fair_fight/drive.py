"""Drives a property-based tool in the folder of a code base, until the meter ends it: `drive TOOL CODE_BASE SEED`."""

from __future__ import annotations

import sys
from typing import Any

from hypothesis import HealthCheck, given, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from studies.fair_fight import drawing
from studies.fair_fight.world import World

_UNLIMITED: dict[str, Any] = {
    "max_examples": 1_000_000,
    "deadline": None,
    "database": None,
    "suppress_health_check": [*HealthCheck],
    "print_blob": False,
    "stateful_step_count": 30,
}


def lists(world: World, number: int) -> None:
    """`@given` a list of commands: one search up to its failures, all shrunk."""
    seed(number)(settings(**_UNLIMITED)(given(drawing.lists(world))(world.check)))()


def rules(world: World, number: int) -> None:
    """A rule-based machine: the same."""
    run_state_machine_as_test(seed(number)(drawing.machine(world)), settings=settings(**_UNLIMITED))


def crosshair(world: World, number: int) -> None:
    """`lists` with the symbolic execution of CrossHair as its backend."""
    seed(number)(settings(**_UNLIMITED, backend="crosshair")(given(drawing.lists(world))(world.check)))()


TOOLS = {"lists": lists, "rules": rules, "crosshair": crosshair}


def main() -> None:
    """Search again and again: what has been found is known from then on."""
    tool, name, number = sys.argv[1], sys.argv[2], int(sys.argv[3])
    world = World.here(name)
    try:
        TOOLS[tool](world, number)
    except (AssertionError, BaseExceptionGroup) as error:
        print(repr(error))


if __name__ == "__main__":
    main()
