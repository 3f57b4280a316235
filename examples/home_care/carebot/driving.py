"""Driving from place to place: turn on the spot, drive straight, slow down near others, and find a way around them."""

from __future__ import annotations

import asyncio
from math import atan2, copysign, hypot, pi

from carebot.config import Config
from carebot.flatmap import HULL_M, SEAT, FlatMap
from carebot.messages import Pose, Velocity
from carebot.ports import Base
from carebot.watching import Seen, is_in_the_way, unknown
from carebot.wayfinding import Point, Wayfinder, length_m, published_way

STAND = Velocity(0.0, 0.0)
ARRIVED_M = 0.05
"""At a goal (chosen: a third of the published 0.15 m at the charger)."""

CORNER_M = 0.06
"""At a corner of the way (chosen: a way around somebody may begin with a corner 0.1 m away, which is to be reached)."""

TURNED_RAD = 0.1
"""It turns on the spot until it faces the next corner by this much (published)."""

OFF_COURSE_RAD = 0.5
"""Further off, it stops to turn (chosen)."""

EITHER_X_M, EITHER_Y_M = 0.1, 0.02
"""The published test for the end of a straight piece of a drive, of which one was enough."""

PUSHED_M = 0.15
"""Further away than this from where it was a period before, it did not drive there (chosen: three times its way)."""

LOOK_AGAIN_S = 2.0
"""So long until a way is looked for once more, where there was none (chosen)."""

SLOW_AFTER_S = 1.0
"""So long it stays slow after it has seen somebody near (chosen: a person walks out of `near_m` meanwhile)."""

SEAT_M = 1.25
"""So near to the seat it is slow: somebody may sit there (chosen: 0.6 m of room, hull, person, one period's way)."""

TOO_NEAR_M = 0.2
"""Who is nearer to the hull than this while it drives makes it stop (chosen: it drives so far in a second)."""

STOPS_S = 1.0
"""So long it stands then (chosen: who walks by is out of the way meanwhile)."""

LEAVES_S = 1.6
"""So long after that it may drive on beside them, then it stops once more (chosen: 0.2 m at `near_speed_m_s`)."""


REMEMBERS_S = 60.0
"""So long it keeps away from where it met somebody who is out of sight (chosen: so long the longest way takes)."""


class BlockedError(Exception):
    """No way to the goal within the time that the robot may take."""


class Driver:
    """Drives the base on the map."""

    def __init__(self, base: Base, flat: FlatMap, config: Config) -> None:
        self._base = base
        self._flat = flat
        self._config = config
        self._wayfinder = Wayfinder(flat)
        self._turning = False
        self._slow_until_s = 0.0
        self._leaves_until_s = 0.0
        self._met: list[tuple[float, float, float]] = []
        """Time (s) and place (m, m) of those in its way."""
        self._before = base.pose()

    async def drive_to(self, goal: Point) -> None:
        """Drive there; the base stands when this returns.

        Raises:
            BlockedError: somebody or something has been in the way for too long.
        """
        loop = asyncio.get_running_loop()
        self._before = self._base.pose()
        way = self._way(goal, ())
        limit_s = self._limit_s(way)
        ends_s = loop.time() + limit_s
        try:
            while not self._has_arrived(goal, way):
                if not self._config.faults.waits_for_ever and loop.time() > ends_s:
                    raise BlockedError(f"no way within {limit_s:.0f} s")
                way = await self._step(way) or await self._around(goal, way)
        finally:
            self._base.drive(STAND)

    def _limit_s(self, way: list[Point]) -> float:
        pose = self._base.pose()
        return self._config.give_up_s + 2 * length_m((pose.x, pose.y), way) / self._config.speed_m_s

    def _way(self, goal: Point, others: tuple[Point, ...]) -> list[Point]:
        """The way to the goal; where others leave none, none."""
        pose = self._base.pose()
        if self._config.faults.stops_on_either and not others:
            return published_way((pose.x, pose.y), goal)  # unreachable: a published fault, which is off
        return self._wayfinder.way((pose.x, pose.y), goal, others) or []

    def _has_arrived(self, goal: Point, way: list[Point]) -> bool:
        if self._config.faults.stops_on_either and len(way) != 1:
            return False  # unreachable: a published fault, which is off
        return self._is_at(goal, ARRIVED_M)

    def _is_at(self, point: Point, within_m: float) -> bool:
        pose = self._base.pose()
        dx, dy = abs(point[0] - pose.x), abs(point[1] - pose.y)
        if self._config.faults.stops_on_either:
            return dx <= EITHER_X_M or dy <= EITHER_Y_M  # unreachable: a published fault, which is off
        return hypot(dx, dy) <= within_m

    async def _step(self, way: list[Point]) -> list[Point]:
        """Drive for one period; what is left of the way then, nothing where somebody is in it."""
        if not way:
            return []
        before, pose = self._before, self._base.pose()
        self._before = pose
        if _distance_m(before, (pose.x, pose.y)) > PUSHED_M:
            return self._way(way[-1], ())
        if len(way) > 1 and self._is_at(way[0], CORNER_M):
            way = way[1:]
        seen = self._seen(pose)
        velocity = self._velocity(pose, way[0], seen)
        if velocity is None:
            return []
        if velocity.forward and self._is_too_near(seen):
            await self._stand(STOPS_S)
            return way
        self._base.drive(velocity)
        await asyncio.sleep(self._config.period_s)
        return way

    def _is_too_near(self, seen: list[Seen]) -> bool:
        """Whether it has to stop beside somebody: they are near, and it has not just stood there."""
        near = any(other.distance_m < HULL_M + TOO_NEAR_M for other in seen)
        return near and asyncio.get_running_loop().time() >= self._leaves_until_s

    async def _stand(self, duration_s: float) -> None:
        """Stand for a while, after which it may leave whoever is beside it."""
        self._base.drive(STAND)
        await asyncio.sleep(duration_s)
        self._leaves_until_s = asyncio.get_running_loop().time() + LEAVES_S

    def _velocity(self, pose: Pose, corner: Point, seen: list[Seen]) -> Velocity | None:
        """Towards a corner of the way; None where somebody is in the way."""
        bearing, distance_m = atan2(corner[1] - pose.y, corner[0] - pose.x), _distance_m(pose, corner)
        error = (bearing - pose.heading + pi) % (2 * pi) - pi
        if self._config.faults.waits_for_ever and any(other.distance_m < self._config.near_m / 2 for other in seen):
            return None  # unreachable: a published fault, which is off
        blocked = any(is_in_the_way(other, self._config.stop_m, seen) for other in seen)
        # With somebody ahead it turns first: whether they are in its way shows when it faces its corner.
        if self._turning or abs(error) > (TURNED_RAD if blocked else OFF_COURSE_RAD):
            self._turning = abs(error) > TURNED_RAD
            # The last piece is as slow as it has to be, so that it is not turned too far.
            return Velocity(0.0, copysign(min(self._config.turn_rad_s, abs(error) / self._config.period_s), error))
        if blocked:
            return None
        near = bool(seen) or _distance_m(pose, SEAT) < SEAT_M
        speed_m_s = self._config.near_speed_m_s if self._is_slow(near) else self._config.speed_m_s
        forward = min(speed_m_s, distance_m / self._config.period_s)
        return Velocity(forward, max(-self._config.turn_rad_s, min(2 * error, self._config.turn_rad_s)))

    def _is_slow(self, is_near: bool) -> bool:
        """Whether somebody may be near, or was a moment ago: beside furniture they are taken for a part of it."""
        now_s = asyncio.get_running_loop().time()
        if is_near:
            self._slow_until_s = now_s + SLOW_AFTER_S
        return now_s < self._slow_until_s

    def _seen(self, pose: Pose) -> list[Seen]:
        return unknown(self._base.scan(), pose, self._flat, self._config.near_m)

    async def _around(self, goal: Point, way: list[Point]) -> list[Point]:
        """Stand, give others the time to leave, and find a way around those that stay."""
        if self._config.faults.waits_for_ever:
            await self._stand(LOOK_AGAIN_S)  # unreachable: a published fault, which is off
            return way  # unreachable: a published fault, which is off
        await self._stand(self._config.patience_s if way else LOOK_AGAIN_S)
        self._turning = False
        pose = self._base.pose()
        seen = tuple((other.x, other.y) for other in self._seen(pose))
        met = tuple((x, y) for _, x, y in self._remembered(pose))
        self._met += [(asyncio.get_running_loop().time(), x, y) for x, y in seen]
        return (self._way(goal, (*seen, *met)) if met else []) or self._way(goal, seen)

    def _remembered(self, pose: Pose) -> list[tuple[float, float, float]]:
        """Those met a while ago who are out of sight now: forgotten, it would go back and forth between two of them."""
        since_s = asyncio.get_running_loop().time() - REMEMBERS_S
        self._met = [met for met in self._met if met[0] > since_s and _distance_m(pose, met[1:]) >= self._config.near_m]
        return self._met


def _distance_m(pose: Pose, point: Point) -> float:
    return hypot(point[0] - pose.x, point[1] - pose.y)
