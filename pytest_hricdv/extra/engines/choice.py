"""The physics engine that runs the tests: the one that was asked for, or the first one that is installed."""

from __future__ import annotations

import dataclasses
from importlib.util import find_spec

from pytest_hricdv.testbench import Testbench, TestbenchError

BOTH = "both"
"""Of `--hri-engine`: each test runs on the testbench's first two engines, which check each other."""


def on_engine(testbench: Testbench, asked: str) -> Testbench:
    """The testbench with a physics engine: the one that was asked for, or its first one that is installed.

    Where none is installed it is the first one: what to install is said when it is imported.

    Args:
        testbench: any, also one without engines.
        asked: name of an engine, `BOTH` (then it is the first one), or nothing.

    Raises:
        TestbenchError: it has no such engine.
    """
    names = tuple(testbench.engines)
    if not names:
        if asked:
            expected = 'none: give it engines={"name": "module"}'
            raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {expected}")
        return testbench
    choices = (*names, BOTH) if len(names) > 1 else names
    if asked and asked not in choices:
        raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {', '.join(choices)}")
    chosen = asked if asked in names else names[0]
    if not asked:
        chosen = next((name for name in names if _is_installed(name)), names[0])
    return dataclasses.replace(testbench, engine=chosen)


def on_second_engine(testbench: Testbench, asked: str) -> Testbench | None:
    """The testbench with the engine that checks the first one; None where none was asked for."""
    return dataclasses.replace(testbench, engine=tuple(testbench.engines)[1]) if asked == BOTH else None


def passed_over(testbench: Testbench) -> tuple[str, ...]:
    """The engines before the one in use, in the testbench's order, that are not installed."""
    before = tuple(testbench.engines)[: list(testbench.engines).index(testbench.engine)] if testbench.engine else ()
    return tuple(name for name in before if not _is_installed(name))


def _is_installed(name: str) -> bool:
    return find_spec(name) is not None
