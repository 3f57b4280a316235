"""The laser: distances all around the robot's middle, with noise.

All boxes of the flat have sides along the axes, so that a ray meets each by the slab method, all rays and boxes at
once. Only sums, products and quotients decide a distance: they are the same on each machine, whereas sines of numpy
differ in their last bits between processors. Single precision is enough for whole mm, and takes half the time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from house.flat import BOXES
from house.shapes import Box, Point, box_around, turned

Many = NDArray[np.float32]

RAYS = 626
LEAST_M, GREATEST_M = 0.02, 5.6
NOISE_M = 0.03
"""Rays of a turn, the range, and the standard deviation of a distance: as published."""

PERIOD_US = 100_000
"""Between two turns: 10 Hz, as of small scanners (chosen)."""

DIGITS = 3
"""Distances are in whole mm, as scanners report them."""

_ANGLES = [-math.pi + 2.0 * math.pi * ray / RAYS for ray in range(RAYS)]
_AHEAD = np.array([math.cos(angle) for angle in _ANGLES], dtype=np.float32)
_LEFT = np.array([math.sin(angle) for angle in _ANGLES], dtype=np.float32)
_TINY = np.float32(1e-7)
"""In place of a zero, for a ray along an axis."""


class Disc(NamedTuple):
    """A round thing that moves: middle and radius (m)."""

    middle: Point
    radius_m: float


class TurnedBox(NamedTuple):
    """A box that moves: middle (m), heading (rad), extents along its own axes (m)."""

    middle: Point
    heading_rad: float
    size: Point


class Laser:
    """A scanner with noise of its own stream.

    Args:
        seed: of the noise, of 32 bits. The stream is that of `numpy.random.RandomState`, which NumPy keeps as it is.
    """

    def __init__(self, seed: int) -> None:
        self._noise = np.random.RandomState(seed)

    def ranges(
        self, at: Point, heading_rad: float, discs: Sequence[Disc], boxes: Sequence[TurnedBox]
    ) -> NDArray[np.float64]:
        """Distances (m) of one turn, infinite where nothing is in range; see `carebot.messages.Scan` for its order."""
        exact = distances(at, heading_rad, discs, boxes)
        measured = np.round(exact + NOISE_M * self._noise.standard_normal(RAYS), DIGITS)
        measured[measured > GREATEST_M] = math.inf
        return np.maximum(measured, LEAST_M)


class _Boxes:
    """Boxes with sides along the axes, for rays. It keeps its memory: to ask for it takes longer than to compute."""

    def __init__(self, boxes: Sequence[Box]) -> None:
        sides = np.array([(box.x1, box.y1, box.x2, box.y2) for box in boxes], dtype=np.float32)
        self._x1, self._y1, self._x2, self._y2 = (sides[:, side, None].copy() for side in range(4))
        shape = (len(boxes), RAYS)
        self._enter, self._leave, self._one, self._other = (np.empty(shape, np.float32) for _ in range(4))
        self._missed = np.empty(shape, np.bool_)

    def nearest(self, at: Point, dx: Many, dy: Many) -> Many:
        """The distance at which each ray enters the nearest box, infinite where it meets none."""
        x, y = np.float32(at[0]), np.float32(at[1])
        per_x = np.float32(1.0) / np.where(np.abs(dx) < _TINY, _TINY, dx)
        per_y = np.float32(1.0) / np.where(np.abs(dy) < _TINY, _TINY, dy)
        rays = dx.size  # views: not each call has all
        enter, leave, one, other = (held[:, :rays] for held in (self._enter, self._leave, self._one, self._other))
        missed = self._missed[:, :rays]
        np.multiply(self._x1 - x, per_x, out=one)
        np.multiply(self._x2 - x, per_x, out=other)
        np.minimum(one, other, out=enter)
        np.maximum(one, other, out=leave)
        np.multiply(self._y1 - y, per_y, out=one)
        np.multiply(self._y2 - y, per_y, out=other)
        np.maximum(enter, np.minimum(one, other), out=enter)
        np.maximum(one, other, out=one)
        np.minimum(leave, one, out=leave)
        np.copyto(enter, np.float32(math.inf), where=np.less(leave, enter, out=missed))
        np.copyto(enter, np.float32(math.inf), where=np.less(leave, np.float32(0.0), out=missed))
        nearest: Many = enter.min(axis=0)
        return np.maximum(nearest, np.float32(0.0))


_FLAT = _Boxes(BOXES)


@cache
def _around_zero(size: Point) -> _Boxes:
    """A box of this size about the origin, along the axes."""
    return _Boxes((box_around((0.0, 0.0), size),))


def distances(at: Point, heading_rad: float, discs: Sequence[Disc], boxes: Sequence[TurnedBox]) -> Many:
    """Distances (m) without noise from a place in the flat to what is nearest along each ray."""
    cos, sin = np.float32(math.cos(heading_rad)), np.float32(math.sin(heading_rad))
    dx, dy = cos * _AHEAD - sin * _LEFT, sin * _AHEAD + cos * _LEFT
    nearest = _FLAT.nearest(at, dx, dy)
    for disc in discs:
        rays = _rays_to(at, heading_rad, disc.middle, disc.radius_m)
        np.minimum(nearest[rays], _to_disc(at, dx[rays], dy[rays], disc), out=nearest[rays])
    for box in boxes:
        rays = _rays_to(at, heading_rad, box.middle, math.hypot(*box.size) / 2.0)
        np.minimum(nearest[rays], _to_turned_box(at, dx[rays], dy[rays], box), out=nearest[rays])
    return nearest


def _rays_to(at: Point, heading_rad: float, middle: Point, radius_m: float) -> slice:
    """The rays that may meet what is within a circle: none where it is out of range, all where it is about the seam."""
    far_m = math.dist(at, middle)
    if far_m - radius_m > GREATEST_M + 6.0 * NOISE_M:
        return slice(0, 0)
    if far_m <= radius_m:
        return slice(None)
    bearing_rad = turned(math.atan2(middle[1] - at[1], middle[0] - at[0]) - heading_rad)
    half_rad = math.asin(radius_m / far_m)
    per_rad = RAYS / (2.0 * math.pi)
    first = math.floor((bearing_rad - half_rad + math.pi) * per_rad) - 1
    last = math.ceil((bearing_rad + half_rad + math.pi) * per_rad) + 1
    return slice(first, last + 1) if first >= 0 and last < RAYS else slice(None)


def _to_disc(at: Point, dx: Many, dy: Many, disc: Disc) -> Many:
    to_x, to_y = np.float32(disc.middle[0] - at[0]), np.float32(disc.middle[1] - at[1])
    along = to_x * dx + to_y * dy
    aside = to_x * dy - to_y * dx
    square = np.float32(disc.radius_m**2) - aside * aside
    enter = along - np.sqrt(np.maximum(square, np.float32(0.0)))
    return np.where((square < 0.0) | (along < 0.0), np.float32(math.inf), np.maximum(enter, np.float32(0.0)))


def _to_turned_box(at: Point, dx: Many, dy: Many, box: TurnedBox) -> Many:
    cos, sin = math.cos(box.heading_rad), math.sin(box.heading_rad)
    from_x, from_y = at[0] - box.middle[0], at[1] - box.middle[1]
    place = (cos * from_x + sin * from_y, cos * from_y - sin * from_x)
    single_cos, single_sin = np.float32(cos), np.float32(sin)
    return _around_zero(box.size).nearest(place, single_cos * dx + single_sin * dy, single_cos * dy - single_sin * dx)
