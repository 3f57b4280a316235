"""The physics engine that runs the tests: the testbench's first one that is installed, unless a part chooses one."""

from __future__ import annotations

import dataclasses
import importlib
from importlib.util import find_spec

from pytest_hricdv.session.usage import usage_error
from pytest_hricdv.testbench import Testbench


def on_installed_engine(testbench: Testbench) -> Testbench:
    """The testbench with its first physics engine that is installed.

    Where none is installed it is the first one: what to install is said when it is imported.

    Args:
        testbench: any, also one without engines.
    """
    names = tuple(testbench.engines)
    if not names:
        return testbench
    installed = (name for name in names if _is_installed(testbench, name))
    return dataclasses.replace(testbench, engine=next(installed, names[0]))


def passed_over(testbench: Testbench) -> tuple[str, ...]:
    """The engines before the one in use, in the testbench's order, that are not installed."""
    before = tuple(testbench.engines)[: list(testbench.engines).index(testbench.engine)] if testbench.engine else ()
    return tuple(name for name in before if not _is_installed(testbench, name))


def engine_modules(testbench: Testbench) -> tuple[str, ...]:
    """What has to be imported for the engine in use: one module, or none."""
    module = testbench.engines[testbench.engine] if testbench.engine else ""
    return (module,) if module else ()


def import_engine(testbench: Testbench) -> None:
    """Import the engine in use, if there is one. Raises pytest.UsageError, with what else there is."""
    name = testbench.engine
    try:
        for module in engine_modules(testbench):
            importlib.import_module(module)
    except ImportError as error:
        others = ", ".join(engine for engine in testbench.engines if engine != name)
        instead = f"; or choose another one with --hri-engine: {others}" if others else ""
        raise usage_error(f"engine {name!r}: {error}{instead}") from None


def _is_installed(testbench: Testbench, name: str) -> bool:
    return not testbench.engines[name] or find_spec(name) is not None
