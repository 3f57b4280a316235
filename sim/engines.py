"""The physics engines that there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import find_spec

from sim.engine import STEP_S, Engine, SimulationError


def new_engine(name: str = "") -> Engine:
    """A new scene of an engine, or of the first one that is installed.

    Raises:
        SimulationError: there is no such engine.
    """
    return _ENGINES[known(name)]()


def known(name: str) -> str:
    """The engine of this name; without a name, the first one that is installed. Raises SimulationError for another."""
    if name and name not in _ENGINES:
        raise SimulationError(f"engine {name!r}: expected one of {', '.join(_ENGINES)}")
    return name or _first_installed()


@cache
def _first_installed() -> str:
    return next((name for name in _ENGINES if find_spec(name) is not None), "mujoco")


def _bullet() -> Engine:
    from sim.bullet.engine import BulletEngine

    return BulletEngine(STEP_S)


def _mujoco() -> Engine:
    from sim.mujoco.engine import MujocoEngine

    return MujocoEngine(STEP_S)


_ENGINES: Mapping[str, Callable[[], Engine]] = {"pybullet": _bullet, "mujoco": _mujoco}
"""By the name of the package; the first that is installed is taken where none is chosen."""
