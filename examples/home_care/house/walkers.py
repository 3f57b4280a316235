"""The person and the dog: where they are, and how they go.

They do what they are told, at constant speed, along `house.routes`; both stop before the robot rather than walk into
it. What they do and when is decided elsewhere: by the nodes of the world that enact a test. Neither is an obstacle for
the other one: a dog makes way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from house.flat import DOG, SEAT, STANDS
from house.routes import Around, route
from house.shapes import Gap, Point, gap_to_disc, gap_to_turned_box, moved

PERSON_RADIUS_M = 0.23
"""Of a standing person: half a shoulder's breadth of 0.46 m (chosen, about the median of adults)."""

DOG_SIZE_M: Point = (0.30, 0.15)
"""As published; it is 0.30 m high."""

DOG_RADIUS_M = math.hypot(*DOG_SIZE_M) / 2.0
"""It keeps so far from walls, however it stands."""

KEEPS_M = 0.05
"""How near to the robot somebody walks (chosen): a person does not walk into what it sees."""

AROUND_AFTER_S = 1.0
"""So long a person waits before it walks around a robot that stands in its way (chosen)."""

AROUND_M = 0.15
"""How far from the robot it then walks (chosen)."""

FOLLOWS_AGAIN_M = 0.3
"""A dog that follows somebody looks for a new way when that one has gone so far (chosen)."""


class Robot(Protocol):
    """What walkers see of the robot."""

    at: Point
    radius_m: float


class Walker:
    """Somebody who goes along a way.

    Args:
        at: where it is (m).
        radius_m: it keeps so far from walls and furniture.
    """

    def __init__(self, at: Point, radius_m: float) -> None:
        self.at, self.radius_m, self.heading_rad = at, radius_m, 0.0
        self.velocity: Point = (0.0, 0.0)
        """In the last step (m/s)."""
        self.blocked_s = 0.0
        """For so long the robot has been in its way."""
        self._way: tuple[Point, ...] = ()
        self._speed_m_s = 0.0

    @property
    def walking(self) -> bool:
        """Whether it is on its way, be it that it waits for the robot."""
        return bool(self._way)

    @property
    def restless(self) -> bool:
        """Whether time may not jump."""
        return bool(self._way) or self.velocity != (0.0, 0.0)

    def go(self, to: Point, speed_m_s: float) -> bool:
        """Go somewhere; False where no way leads there: then it stays."""
        self._set_out(route(self.at, to, self.radius_m), speed_m_s)
        return self.walking

    def stay(self) -> None:
        """Stop where it is."""
        self._way, self.blocked_s = (), 0.0

    def gap_to(self, middle: Point, radius_m: float) -> Gap:
        """Between a disc, such as the robot, and it."""
        return gap_to_disc(middle, radius_m, self.at, self.radius_m)

    def step(self, duration_s: float, robot: Robot) -> None:
        """Go on for a while, unless the robot is in the way."""
        start, left_m = self.at, self._speed_m_s * duration_s
        while self._way and left_m > 1e-9:
            far_m = math.dist(self.at, self._way[0])
            part_m = min(left_m, far_m)
            if part_m > 0.0 and not self._advance(self._way[0], part_m / far_m, robot):
                break
            left_m -= part_m
            if part_m == far_m:
                self._way = self._way[1:]
        self.velocity = ((self.at[0] - start[0]) / duration_s, (self.at[1] - start[1]) / duration_s)
        self.blocked_s = self.blocked_s + duration_s if self._way and self.at == start else 0.0

    def _set_out(self, way: tuple[Point, ...], speed_m_s: float) -> None:
        self._way, self._speed_m_s, self.blocked_s = way, speed_m_s, 0.0

    def _advance(self, to: Point, part: float, robot: Robot) -> bool:
        """Go a part of the way to a point; False, without effect, where it would come too near to the robot."""
        before, width_m = (self.at, self.heading_rad), self.gap_to(robot.at, robot.radius_m).width_m
        self.heading_rad = math.atan2(to[1] - self.at[1], to[0] - self.at[0])
        x, y = self.at
        self.at = to if part == 1.0 else (x + part * (to[0] - x), y + part * (to[1] - y))
        after_m = self.gap_to(robot.at, robot.radius_m).width_m
        if after_m < min(KEEPS_M, width_m):
            self.at, self.heading_rad = before
            return False
        return True


class Person(Walker):
    """A person, who sits at the table in the beginning."""

    def __init__(self) -> None:
        super().__init__(SEAT, PERSON_RADIUS_M)

    @property
    def seated(self) -> bool:
        """Whether it sits."""
        return self.at == SEAT

    def go(self, to: Point, speed_m_s: float) -> bool:
        """Get up, if seated, and go somewhere; False where no way leads there: then it stays."""
        stands = STANDS if self.seated else self.at
        way = route(stands, to, self.radius_m)
        self._set_out((stands, *way) if way else (), speed_m_s)
        return self.walking

    def sit(self, speed_m_s: float) -> bool:
        """Go to the seat, and sit down."""
        way = () if self.seated else (*route(self.at, STANDS, self.radius_m), SEAT)
        self._set_out(way, speed_m_s)
        return self.walking

    def step(self, duration_s: float, robot: Robot) -> None:
        """Go on for a while; around a robot that has been in the way for a while."""
        super().step(duration_s, robot)
        if self.blocked_s >= AROUND_AFTER_S:
            self.blocked_s = 0.0
            end = self._way[-1]
            seated_after = end == SEAT
            around = Around(robot.at, robot.radius_m + self.radius_m + AROUND_M)
            way = route(self.at, STANDS if seated_after else end, self.radius_m, around)
            self._way = (*way, *((SEAT,) if seated_after else ())) if way else self._way


class Dog(Walker):
    """A dog: a box on the floor that walks, follows somebody, or lies.

    It cannot jump, unless `House.dog_jumps` makes it do what the dog of the published case did.
    """

    def __init__(self) -> None:
        super().__init__(DOG.at, DOG_RADIUS_M)
        self.heading_rad = DOG.heading_rad
        self._whom: Callable[[], Point] | None = None
        self._near_m = 0.0
        self._seen: Point = (0.0, 0.0)  # where that one was when the way was looked for

    @property
    def restless(self) -> bool:
        """Whether time may not jump."""
        return super().restless or (self._whom is not None and self._wants_to_follow(self._whom()))

    def go(self, to: Point, speed_m_s: float) -> bool:
        """Go somewhere; False where no way leads there: then it stays."""
        self._whom = None
        return super().go(to, speed_m_s)

    def stay(self) -> None:
        """Stop where it is, and follow nobody."""
        self._whom = None
        super().stay()

    def follow(self, whom: Callable[[], Point], near_m: float, speed_m_s: float) -> None:
        """Follow somebody from now on, up to `near_m` from middle to middle."""
        self.stay()
        self._whom, self._near_m, self._speed_m_s = whom, near_m, speed_m_s

    def gap_to(self, middle: Point, radius_m: float) -> Gap:
        """Between a disc, such as the robot, and its box."""
        return gap_to_turned_box(middle, radius_m, self.at, self.heading_rad, DOG_SIZE_M)

    def step(self, duration_s: float, robot: Robot) -> None:
        """Go on for a while, unless the robot is in the way."""
        if self._whom is not None:
            self._look_for(self._whom())
        super().step(duration_s, robot)

    def push(self, direction: Point, way_m: float) -> None:
        """It is moved, whatever it does."""
        self.at = moved(self.at, direction, way_m)

    def _wants_to_follow(self, whom: Point) -> bool:
        return math.dist(self.at, whom) > self._near_m

    def _look_for(self, whom: Point) -> None:
        if not self._wants_to_follow(whom):
            self._way = ()
        elif not self._way or math.dist(whom, self._seen) > FOLLOWS_AGAIN_M:
            self._way, self._seen = route(self.at, whom, self.radius_m), whom
