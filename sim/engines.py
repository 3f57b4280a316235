"""The physics engines that there are."""

from __future__ import annotations

from sim.engine import STEP_S, Engine
from sim.shapes import Renderer


def new_engine() -> Engine:
    """A new scene of the engine."""
    from sim.bullet.engine import BulletEngine

    return BulletEngine(STEP_S)


def new_renderer() -> Renderer:
    """A new renderer of the engine."""
    from sim.bullet.renderer import BulletRenderer

    return BulletRenderer()
