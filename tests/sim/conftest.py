"""What a world is like is tested on each physics engine."""

from __future__ import annotations

import pytest


@pytest.fixture(params=["pybullet", "mujoco"], autouse=True)
def engine_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The engine of worlds for which none is chosen: each in turn, or that of the mark `engine`."""
    only = request.node.get_closest_marker("engine")
    if only is not None and request.param not in only.args:
        pytest.skip(f"is about {', '.join(only.args)}")
    monkeypatch.setattr("sim.engines._first_installed", lambda: request.param)
    return str(request.param)
