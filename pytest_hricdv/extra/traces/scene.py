"""The shapes of a world over a run, for viewers that draw them themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.runtime.body import Body
from pytest_hricdv.runtime.world import World


@dataclass(frozen=True)
class SceneChange:
    """What changed in the scene: the bodies that are new, or elsewhere, and the names of those that are gone."""

    time_us: int
    moved: tuple[Body, ...]
    gone: tuple[str, ...]


class ObservedWorld:
    """A world whose shapes are noted while it advances. It advances as it would alone: it stops nowhere for this.

    Args:
        world: of the run.
        bodies: gives the shapes of the world now.
        period_us: they are looked at, at most, once in this time (us).
    """

    def __init__(self, world: World, bodies: Callable[[Any], Sequence[Body]], period_us: int) -> None:
        self.changes: list[SceneChange] = []
        self._world = world
        self._bodies = bodies
        self._period_us = period_us
        self._next_us = 0
        self._last: dict[str, Body] = {}
        self.look(0)

    def advance(self, target_us: int) -> int:
        """See `runtime.World`."""
        reached_us = self._world.advance(target_us)
        if reached_us >= self._next_us:
            self.look(reached_us)
        return reached_us

    def observe(self) -> None:
        """See `runtime.World`."""
        self._world.observe()

    def look(self, time_us: int) -> None:
        """Note what changed since the last look."""
        now = {body.name: body for body in self._bodies(self._world)}
        moved = tuple(body for name, body in now.items() if self._last.get(name) != body)
        gone = tuple(name for name in self._last if name not in now)
        if moved or gone:
            self.changes.append(SceneChange(time_us, moved, gone))
        self._last, self._next_us = now, time_us + self._period_us
