"""What a world is like is tested on each physics engine."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

collect_ignore = [] if find_spec("pybullet") else ["test_bullet_merging.py"]

INSTALLED = [name for name in ("pybullet", "mujoco") if find_spec(name) is not None]


@pytest.fixture(params=INSTALLED, autouse=True)
def engine_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The engine of worlds for which none is chosen: each in turn, or that of the mark `engine`."""
    only = request.node.get_closest_marker("engine")
    if only is not None and request.param not in only.args:
        pytest.skip(f"is about {', '.join(only.args)}")
    monkeypatch.setattr("sim.engines._first_installed", lambda: request.param)
    return str(request.param)
