"""Which physics engine a testbench runs on, where nobody has chosen one."""

from __future__ import annotations

import dataclasses

import pytest

from pytest_hricdv.session.testbench_search import (
    engine_modules,
    engines_not_installed,
    import_engine,
    on_installed_engine,
)
from pytest_hricdv.testbench import Simulation, Testbench
from tests.actors.corridor.bench import ward


def bench(**engines: str) -> Testbench:
    return on_installed_engine(dataclasses.replace(ward(), simulation=Simulation(engines=engines)))


@pytest.mark.parametrize(
    ("engines", "used", "missing", "modules"),
    [
        ({}, "", (), ()),
        ({"json": "json.decoder"}, "json", (), ("json.decoder",)),
        ({"no_such_engine": "json", "json": "json.decoder"}, "json", ("no_such_engine",), ("json.decoder",)),
        # An own one needs no package: it is there, whatever it is called, and nothing is imported for it.
        ({"planar": "", "no_such_engine": "json"}, "planar", (), ()),
        ({"no_such_engine": "json", "planar": ""}, "planar", ("no_such_engine",), ()),
        ({"no_such_engine": "no_such_engine"}, "no_such_engine", (), ("no_such_engine",)),
    ],
)
def test_the_first_that_is_there_is_used(
    engines: dict[str, str], used: str, missing: tuple[str, ...], modules: tuple[str, ...]
) -> None:
    chosen = bench(**engines)
    assert (chosen.simulation.engine, engines_not_installed(chosen), engine_modules(chosen)) == (used, missing, modules)


def test_what_is_missing_is_said_with_what_else_there_is() -> None:
    import_engine(bench(planar=""))
    chosen = bench(planar="", no_such_engine="no_such_engine").choose(engine="no_such_engine")
    with pytest.raises(pytest.UsageError, match=r"no_such_engine.*choose another one with --hri-engine: planar"):
        import_engine(chosen)
