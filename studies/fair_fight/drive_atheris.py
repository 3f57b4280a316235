"""Drives Atheris in the folder of a code base: `drive_atheris CODE_BASE MODULE,... SEED`, until the meter ends it.

The code under test is instrumented as it is imported; bytes become inputs by `fuzz_one_input` of Hypothesis, which both
document. A failure is noted in the journal, and does not end the search.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import Any

import atheris  # type: ignore[import-untyped, import-not-found, unused-ignore]
from hypothesis import HealthCheck, given, settings

from studies.fair_fight import drawing
from studies.fair_fight.world import World


def main() -> None:
    """Fuzz until killed."""
    name, modules, number = sys.argv[1:4]
    with atheris.instrument_imports(include=modules.split(",")):
        world = World.here(name)
        for module in modules.split(","):
            __import__(module)
    quiet = settings(deadline=None, database=None, suppress_health_check=[*HealthCheck])
    property_test: Any = quiet(given(drawing.lists(world))(world.check))
    fuzz = property_test.hypothesis.fuzz_one_input

    def once(data: bytes) -> None:
        with suppress(AssertionError):
            fuzz(data)

    atheris.Setup([sys.argv[0], f"-seed={int(number) + 1}", "-max_len=4096", "-len_control=0"], once)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
