"""The ways of people and dogs: the shortest one around walls and furniture, by a visibility graph.

The robot has a way-finding of its own, in its code.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from functools import cache
from typing import NamedTuple

from house.flat import BOXES, INSIDE
from house.shapes import Box, Point, box_around, distance_to_segment, gap_to_box

SPARE_M = 0.02
"""Ways keep this far from what they must not touch: more than rounding, less than any passage leaves (chosen)."""

_EIGHTH = tuple((math.cos(corner * math.pi / 4.0), math.sin(corner * math.pi / 4.0)) for corner in range(8))


class Around(NamedTuple):
    """Something round to go around: its middle (m), and how near to it a middle may come (m)."""

    middle: Point
    keeps_m: float


def route(start: Point, end: Point, clearance_m: float, *around: Around) -> tuple[Point, ...]:
    """The corners of the shortest way, without its start and with its end; empty where there is none.

    Args:
        start: where it begins. Who stands nearer to something than allowed goes no nearer.
        end: where it is to end.
        clearance_m: radius of who goes.
        around: what else is in the way, such as the robot; all at once.
    """
    blocked = _blocked(clearance_m)
    if any(box.contains(end) for box in blocked):
        return ()
    if any(math.dist(end, other.middle) < other.keeps_m for other in around):
        return ()
    ring = [point for other in around for point in _ring(other, around, blocked)]
    nearer = tuple(Around(other.middle, min(other.keeps_m, math.dist(start, other.middle) - 1e-6)) for other in around)
    return _Search(start, end, ring, clearance_m, nearer).shortest()


def _ring(other: Around, around: Sequence[Around], blocked: Sequence[Box]) -> Iterator[Point]:
    """Where ways may bend about something: points around it at which nothing is."""
    far_m = (other.keeps_m + SPARE_M) / math.cos(math.pi / 8.0)
    for x, y in _EIGHTH:
        point = other.middle[0] + far_m * x, other.middle[1] + far_m * y
        is_near = any(math.dist(point, third.middle) < third.keeps_m for third in around)
        if not is_near and not any(box.contains(point) for box in blocked):
            yield point


@cache
def _blocked(clearance_m: float) -> tuple[Box, ...]:
    return tuple(box.grown(clearance_m) for box in BOXES)


@cache
def _corners(clearance_m: float) -> tuple[Point, ...]:
    """Where ways may bend: the corners of grown boxes, where nothing else is."""
    inside = INSIDE.grown(-clearance_m)
    corners = (corner for box in BOXES for corner in box.grown(clearance_m + SPARE_M).corners)
    return tuple(
        corner
        for corner in corners
        if inside.contains(corner) and all(gap_to_box(corner, clearance_m, box).width_m > 0.0 for box in BOXES)
    )


@cache
def _visible(clearance_m: float) -> tuple[tuple[int, ...], ...]:
    """Of each corner, those that are seen from it past all grown boxes."""
    corners, blocked = _corners(clearance_m), _blocked(clearance_m)
    return tuple(
        tuple(
            there
            for there, other in enumerate(corners)
            if there != here and not any(box.crosses(corner, other) for box in blocked)
        )
        for here, corner in enumerate(corners)
    )


class _Search:
    """Dijkstra's algorithm. Points are corners of the flat, then the start, the end, and the ring around something."""

    def __init__(
        self, start: Point, end: Point, ring: Sequence[Point], clearance_m: float, around: Sequence[Around]
    ) -> None:
        corners = _corners(clearance_m)
        self._points = (*corners, start, end, *ring)
        self._start, self._end = len(corners), len(corners) + 1
        self._visible, self._blocked, self._around = _visible(clearance_m), _blocked(clearance_m), around
        self._for_start = tuple(_shrunk(box, start, clearance_m) for box in BOXES)

    def shortest(self) -> tuple[Point, ...]:
        """The way without its start; empty where there is none."""
        points = self._points
        best = {self._start: 0.0}
        queue: list[tuple[float, int, tuple[int, ...]]] = [(0.0, self._start, ())]
        done: set[int] = set()
        while queue:
            length_m, here, way = heapq.heappop(queue)
            if here == self._end:
                return tuple(points[corner] for corner in way)
            if here in done:
                continue
            done.add(here)
            for there in self._candidates(here):
                total_m = length_m + math.dist(points[here], points[there])
                if there not in done and total_m < best.get(there, math.inf) and self._is_free(here, there):
                    best[there] = total_m
                    heapq.heappush(queue, (total_m, there, (*way, there)))
        return ()

    def _candidates(self, here: int) -> Sequence[int]:
        if here < self._start:
            return (*self._visible[here], *range(self._end, len(self._points)))
        return range(len(self._points))

    def _is_free(self, here: int, there: int) -> bool:
        start, end = self._points[here], self._points[there]
        if any(distance_to_segment(other.middle, start, end) < other.keeps_m for other in self._around):
            return False
        if here < self._start and there < self._start:
            return True  # seen, as it is a candidate
        boxes = self._for_start if here == self._start else self._blocked
        return not any(box.crosses(start, end) for box in boxes)


def _shrunk(box: Box, start: Point, clearance_m: float) -> Box:
    """A box grown by the clearance, or by less, so that the start is not inside."""
    near = box.nearest(start)
    far_m = max(abs(start[0] - near[0]), abs(start[1] - near[1]))
    if far_m == 0.0:  # in the box itself, as a person on the sofa: it is no obstacle
        return box_around(start, (0.0, 0.0))
    return box.grown(min(clearance_m, far_m - 1e-9))
