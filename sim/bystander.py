"""Somebody who leans into the arm's way: the planner refuses ways through a person, and the arm stops before one.

Real robots have a scanner or a skin for this (ISO 10218-1, protective stop); here the world knows distances.
"""

from __future__ import annotations

from collections.abc import Callable

from sim.engine import Engine
from sim.fingers import Fingers
from sim.geometry import Vector
from sim.layout import PERSON
from sim.shapes import Sphere
from sim.torso import ARM_LINKS, Torso

RADIUS_M = 0.10
"""A head, or a shoulder."""

STOP_M = 0.015
"""An arm that comes this near to a person is stopped: less than what planned ways keep."""

ROOM_M = 0.03
"""Nobody leans in where the arm is nearer than this."""

SHIRT = (0.35, 0.45, 0.60, 1.0)

Signal = Callable[[str, float | bool], None]


def add_body(engine: Engine, place: Vector) -> int:
    """Adds the body of a person who leans in at a place (m); nothing collides with it. Returns its id."""
    body = engine.add(0.0, place, SHIRT, Sphere(RADIUS_M))
    engine.set_collision_group(body, PERSON, 0)
    return body


class Bystander:
    """Somebody who leans in now and then; at first nobody does."""

    def __init__(self, engine: Engine, torso: Torso, fingers: Fingers) -> None:
        self._engine = engine
        self._torso = torso
        self._fingers = fingers
        self._links = [torso.joints[name] for name in ARM_LINKS]
        self._body: int | None = None
        self._distance_m = 0.0
        self.place: Vector | None = None

    @property
    def places(self) -> tuple[Vector, ...]:
        """Where somebody leans in (m): one place or none."""
        return () if self.place is None else (self.place,)

    def lean_in(self, place: Vector) -> bool:
        """Lean in at a place (m), if the arm leaves room there; whether it does."""
        self.lean_out()
        self._body, self.place = add_body(self._engine, place), place
        self._distance_m = self._distance()
        if self._distance_m < ROOM_M:
            self.lean_out()
        return self._body is not None

    def lean_out(self) -> None:
        """Go away; without effect when nobody is there."""
        if self._body is not None:
            self._engine.remove(self._body)
        self._body = self.place = None

    def tick(self) -> None:
        """At every control tick: stop the arm that comes too near."""
        if self._body is None:
            return
        before_m, self._distance_m = self._distance_m, self._distance()
        if self._distance_m < STOP_M and self._distance_m < before_m:
            self._torso.stop_arm()

    def _distance(self) -> float:
        assert self._body is not None
        self._fingers.follow(self._torso.palm_pose())
        arm = [self._engine.distance(self._body, self._torso.body, link) for link in self._links]
        return min(self._engine.distance_to_all(self._body, self._fingers.body), *arm)
