"""How the base moves and touches by geometry alone: no masses but for the force of an impact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from house.base import BODIES, FREE, PUSHES_N, Base, Contact, impact_n
from house.flat import SOLIDS, clearance_m
from house.shapes import Gap, Point, gap_to_box, turned
from house.walkers import Dog, Person

TOUCHES_M = 1e-6
"""Gaps below are contacts: far above rounding, far below what matters."""

CREEPS_M = 1e-9
"""A gap that does not shrink by more is one along which the base drives."""

PART_M = 0.05
"""The base is moved in parts of at most this way, less than anything is thick, so that it cannot jump over a thing."""

NEAR_M = 0.5
"""Most things are farther away than this from the middle of the base, which cannot touch them in one part."""

HALVINGS = 16
"""Of a part, to find where it ends at a contact: to 1 um."""


class Pose(NamedTuple):
    """Where the base is: m, rad."""

    at: Point
    heading_rad: float


class Near(NamedTuple):
    """Something and the gap to it: what it is, its velocity (m/s), and the gap."""

    name: str
    velocity: Point
    gap: Gap


class Planar:
    """A base that moves exactly as told, at once, and stands where it touches something, while its wheels slip.

    The force is that of an impact in the first step of a contact, and then what the wheels push with.
    """

    def __init__(self) -> None:
        self._touched = "nothing"

    def moved(self, base: Base) -> None:
        """The base was set somewhere else."""
        self._touched = "nothing"

    def step(self, base: Base, person: Person, dog: Dog, duration_s: float) -> Contact:
        """Let the base move for a while as it is told."""
        left_s, start, hit = duration_s, base.at, FREE
        while left_s > 1e-12 and base.forward_m_s != 0.0:
            part_s = min(left_s, PART_M / abs(base.forward_m_s))
            left_s -= part_s
            contact = self._part(base, person, dog, part_s)
            if contact is not FREE:
                hit = contact
                break
        base.heading_rad = turned(base.heading_rad + base.turn_rad_s * left_s)
        base.speed_m_s = math.dist(start, base.at) / duration_s
        base.turning_rad_s = abs(base.turn_rad_s)
        self._touched = hit.with_what
        return hit

    def _part(self, base: Base, person: Person, dog: Dog, duration_s: float) -> Contact:
        start = Pose(base.at, base.heading_rad)
        goal = driven(start, base.forward_m_s, base.turn_rad_s, duration_s)
        if _is_far(base, person, dog, abs(base.forward_m_s) * duration_s):
            base.at, base.heading_rad = goal
            return FREE
        # Where it is now counts, too: who stands closer than allowed may go away.
        before = {near.name: near.gap.width_m for near in _all_near(start.at, base.radius_m, person, dog)}
        in_way = [
            near
            for near in _all_near(goal.at, base.radius_m, person, dog)
            if near.gap.width_m < min(-TOUCHES_M, before.get(near.name, math.inf) - CREEPS_M)
        ]
        base.at, base.heading_rad = goal
        if not in_way:
            return FREE
        base.at = self._free_part(base, start, person, dog, duration_s)
        return self._contact(base, min(in_way, key=lambda near: near.gap.width_m), start)

    def _free_part(self, base: Base, start: Pose, person: Person, dog: Dog, duration_s: float) -> Point:
        """How far it comes before it touches."""
        free, blocked = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (free + blocked) / 2.0
            at = driven(start, base.forward_m_s, base.turn_rad_s, middle * duration_s).at
            if all(near.gap.width_m >= 0.0 for near in _all_near(at, base.radius_m, person, dog)):
                free = middle
            else:
                blocked = middle
        return driven(start, base.forward_m_s, base.turn_rad_s, free * duration_s).at if free else start.at

    def _contact(self, base: Base, near: Near, start: Pose) -> Contact:
        body = near.name.partition(":")[0]
        away = near.gap.away
        ahead = (math.cos(start.heading_rad), math.sin(start.heading_rad))
        towards = -math.copysign(1.0, base.forward_m_s) * (ahead[0] * away[0] + ahead[1] * away[1])
        pushes_n = PUSHES_N * max(0.0, towards)
        if self._touched == body:
            return Contact(body, pushes_n)
        theirs = near.velocity[0] * away[0] + near.velocity[1] * away[1]
        closing_m_s = abs(base.forward_m_s) * towards + theirs
        return Contact(body, max(pushes_n, impact_n(max(0.0, closing_m_s), BODIES[body])))


def driven(start: Pose, forward_m_s: float, turn_rad_s: float, duration_s: float) -> Pose:
    """Where a base is that drives an arc of a circle."""
    (x, y), heading_rad = start
    turn_rad = turn_rad_s * duration_s
    half_rad = turn_rad / 2.0
    # The chord of the arc: its length is the arc's times sin(h)/h, its direction that of the middle of the arc.
    way_m = forward_m_s * duration_s * (math.sin(half_rad) / half_rad if half_rad else 1.0)
    middle_rad = heading_rad + half_rad
    at = (x + way_m * math.cos(middle_rad), y + way_m * math.sin(middle_rad))
    return Pose(at, turned(heading_rad + turn_rad))


def _is_far(base: Base, person: Person, dog: Dog, way_m: float) -> bool:
    """Whether nothing is within a way of the base: most often, and quickly seen."""
    room_m = base.radius_m + way_m
    return (
        math.dist(base.at, person.at) > room_m + person.radius_m
        and math.dist(base.at, dog.at) > room_m + dog.radius_m
        and clearance_m(base.at) > room_m
    )


def _all_near(at: Point, radius_m: float, person: Person, dog: Dog) -> Iterator[Near]:
    """Everything that the base could touch, and the gap to it; names say which, before a colon what it is."""
    for solid in SOLIDS:
        box = solid.box
        if box.x1 - NEAR_M < at[0] < box.x2 + NEAR_M and box.y1 - NEAR_M < at[1] < box.y2 + NEAR_M:
            yield Near(f"{solid.kind}: {solid.name}", (0.0, 0.0), gap_to_box(at, radius_m, box))
    yield Near("person", person.velocity, person.gap_to(at, radius_m))
    yield Near("dog", dog.velocity, dog.gap_to(at, radius_m))
