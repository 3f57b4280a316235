"""Pictures of shapes by ray casting in numpy: the same everywhere, without a graphics library, driver or display.

The rays of all pixels around a shape are cast at once. A shape is where a few simpler ones overlap, each of which a
ray enters and leaves once: a box is three slabs, a cylinder is an endless round column and a slab.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.geometry import UPRIGHT, Pose, Vector
from sim.rotation import matrix_of
from sim.shapes import Box, Cylinder, Shape, Sphere

Exact = NDArray[np.float64]
Many = NDArray[np.float32]
"""A number of each ray. Half as many digits are enough, and take half the time."""

NEAR_M, FAR_M = 0.05, 6.0
"""What is nearer to the camera, or farther, is not seen."""

MIDDLE, LIT, SHADED = 0.67, 0.33, -0.1
"""Brightness of a surface along the light; what is added per cosine of its angle to the light, and in a shadow.

What faces away from the light gets darker with the angle, too: else its edges would not be seen.
"""

TOUCH_M = 0.001
"""A shape throws no shadow where a ray to the light leaves it sooner: on a surface that it lies on."""

TINY = 1e-12
"""In place of zero, for a ray that is parallel to a column."""

CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@dataclass
class Solid:
    """A shape that is rendered.

    Args:
        half_m: half its extents (m).
        round_axes: how many of its axes it is round about: 3 of a sphere, 2 of a cylinder (x and y), 0 of a box.
        rgb: its colour, 0 to 255.
        pose: where it is.
    """

    half_m: Vector
    round_axes: int
    rgb: tuple[float, ...]
    pose: Pose = ((0.0, 0.0, 0.0), UPRIGHT)


class Placed(NamedTuple):
    """A shape, and in its own axes: the eye, the directions right, down and ahead, and the direction to the light.

    Args:
        solid: the shape.
        turn: its axes, column by column.
        eye: where the eye is (m).
        axes: right, down and ahead.
        light: the direction to the light.
        corners: of the box around it: how far right, down and ahead of the eye (m).
    """

    solid: Solid
    turn: Sequence[Sequence[float]]
    eye: Sequence[float]
    axes: Sequence[Sequence[float]]
    light: Sequence[float]
    corners: Exact


class Sights(NamedTuple):
    """What is seen at each pixel.

    Args:
        ahead: how far ahead of the eye it is (m).
        owner: the index of the shape, from 1; 0 for nothing.
        facing: the cosine of the angle between its surface and the light.
    """

    ahead: Many
    owner: NDArray[np.int32]
    facing: Many


class View:
    """Rays from the eye, as long as 1 m ahead; see `Raycaster.picture`."""

    def __init__(self, eye: Vector, target: Vector, degrees: float, size: tuple[int, int]) -> None:
        self.eye = np.array(eye)
        ahead = _unit(np.subtract(target, eye))
        right = _unit(np.cross(ahead, (0.0, 0.0, 1.0)))
        self.axes = np.array([right, np.cross(ahead, right), ahead])
        self._size = np.array(size)
        self._px = size[1] / (2.0 * math.tan(math.radians(degrees / 2.0)))
        self.xs, self.ys = (((np.arange(n) + 0.5 - 0.5 * n) / self._px).astype(np.float32) for n in size)

    def window(self, corners: Exact) -> tuple[slice, slice] | None:
        """Rows and columns in which something may be seen, by corners of a box around it."""
        aheads = corners[:, 2]
        if aheads.max() < NEAR_M or aheads.min() > FAR_M:
            return None
        if aheads.min() < NEAR_M:  # partly next to the eye
            return slice(None), slice(None)
        at = corners[:, :2] / aheads[:, None] * self._px + 0.5 * self._size
        left, top = np.clip(np.floor(at.min(axis=0)), 0, self._size).astype(int).tolist()
        right, bottom = np.clip(np.ceil(at.max(axis=0)), 0, self._size).astype(int).tolist()
        return slice(top, bottom), slice(left, right)

    def pixel(self, place: Vector) -> tuple[float, float]:
        """Where a place (m) ahead of the eye is seen: column and row."""
        right, down, ahead = self.axes @ np.subtract(place, self.eye)
        column, row = np.array([right, down]) / ahead * self._px + 0.5 * self._size
        return float(column), float(row)

    def points(self, sights: Sights, pixels: NDArray[np.intp]) -> Sequence[Many]:
        """The places that are seen at some pixels (m)."""
        rows, columns = np.divmod(pixels, self.xs.size)
        ahead = sights.ahead.ravel()[pixels]
        parts = (self.xs[columns] * ahead, self.ys[rows] * ahead, ahead)
        return [at + _dot(axis, parts) for at, axis in zip(self.eye.tolist(), self.axes.T.tolist(), strict=True)]


class Raycaster:
    """Shapes, opaque and dull."""

    def __init__(self) -> None:
        self._solids: dict[int, Solid] = {}
        self._count = 0

    def add(self, shape: Shape, rgba: Sequence[float]) -> int:
        """Add a shape; returns its number."""
        number, self._count = self._count, self._count + 1
        rgb = tuple(255.0 * part for part in rgba[:3])
        match shape:
            case Box(half_m):
                self._solids[number] = Solid(half_m, 0, rgb)
            case Sphere(r):
                self._solids[number] = Solid((r, r, r), 3, rgb)
            case Cylinder(r, length_m):
                self._solids[number] = Solid((r, r, length_m / 2.0), 2, rgb)
        return number

    def remove(self, number: int) -> None:
        """Remove a shape."""
        del self._solids[number]

    def put(self, number: int, pose: Pose) -> None:
        """Set the pose of a shape."""
        self._solids[number].pose = pose

    def picture(
        self, eye: Vector, target: Vector, degrees: float, size: tuple[int, int], light: Vector, *, shadows: bool
    ) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """What is seen: height x width x 3 (RGB), and height x width: whether nothing is there.

        Args:
            eye: position (m).
            target: that is looked at (m), not straight below or above.
            degrees: vertical field of view.
            size: width and height (px).
            light: direction to the light.
            shadows: whether it throws shadows.
        """
        view, to_light = View(eye, target, degrees, size), _unit(np.array(light))
        placed = _placed(list(self._solids.values()), view, to_light)
        with np.errstate(all="ignore"):  # rays that are parallel to a side, or miss: the results are not used
            sights = _sights(placed, view)
            seen = np.flatnonzero(sights.owner)
            owner, facing = sights.owner.ravel()[seen], sights.facing.ravel()[seen]
            shade = MIDDLE + LIT * facing
            if shadows:
                lit = np.flatnonzero(facing > 0.0)
                dark = lit[_shadowed(placed, view.points(sights, seen[lit]), owner[lit], to_light)]
                shade[dark] = MIDDLE + SHADED * facing[dark]
        colours = np.array([(0.0, 0.0, 0.0), *(shape.solid.rgb for shape in placed)], dtype=np.float32)
        rgb = np.zeros((size[1], size[0], 3), dtype=np.uint8)
        rgb.reshape(-1, 3)[seen] = np.clip(colours[owner] * shade[:, None], 0.0, 255.0)
        return rgb, sights.owner == 0


def _placed(solids: Sequence[Solid], view: View, light: Exact) -> Sequence[Placed]:
    places = np.array([solid.pose[0] for solid in solids]).reshape(-1, 3)
    turns = np.array([matrix_of(solid.pose[1]) for solid in solids]).reshape(-1, 3, 3)
    halves = np.array([solid.half_m for solid in solids]).reshape(-1, 1, 3)
    eyes = np.einsum("ni,nij->nj", view.eye - places, turns)
    axes = np.einsum("ai,nij->naj", view.axes, turns)
    lights = np.einsum("i,nij->nj", light, turns)
    corners = np.einsum("nci,nai->nca", CORNERS * halves - eyes[:, None, :], axes)
    return list(map(Placed, solids, turns.tolist(), eyes.tolist(), axes.tolist(), lights.tolist(), corners))


def _sights(placed: Sequence[Placed], view: View) -> Sights:
    """What is seen; the first of shapes that are equally far."""
    shape = (view.ys.size, view.xs.size)
    sights = Sights(np.full(shape, FAR_M, np.float32), np.zeros(shape, np.int32), np.zeros(shape, np.float32))
    for number, body in enumerate(placed, 1):
        window = view.window(body.corners)
        if window is not None:
            xs, ys = view.xs[window[1]], view.ys[window[0], None]
            rays = [right * xs + (down * ys + ahead) for right, down, ahead in zip(*body.axes, strict=True)]
            enter, leave, facing = _met(body, rays)
            ahead = sights.ahead[window]
            nearer = (enter < ahead) & (enter <= leave) & (enter > NEAR_M)
            np.copyto(ahead, enter, where=nearer)
            np.copyto(sights.owner[window], number, where=nearer)
            np.copyto(sights.facing[window], facing, where=nearer)
    return sights


def _met(placed: Placed, rays: Sequence[Many]) -> tuple[Many, Many, Many]:
    """Where rays from the eye enter and leave a shape, and the cosine between its surface there and the light."""
    solid, _, eye, _, light, _ = placed
    sides = [np.float32(part if at > 0.0 else -part) for at, part in zip(eye, light, strict=True)]
    (enter, leave), *slabs = _spans(solid, eye, rays)
    facing: Any = sides[0]
    if count := solid.round_axes:
        facing = (_dot(rays[:count], light) * enter + _dot(eye[:count], light)) / solid.half_m[0]
    for side, (start, end) in zip(sides[count or 1 :], slabs, strict=True):
        facing = np.where(start > enter, side, facing)
        enter, leave = np.maximum(enter, start), np.minimum(leave, end)
    return enter, leave, facing


def _spans(solid: Solid, starts: Sequence[Any], rays: Sequence[Any]) -> Iterator[tuple[Many, Many]]:
    """Where rays enter and leave the parts of a shape, in lengths of the ray; all in the axes of the shape.

    Of starts and rays, one are numbers and the other ones arrays.
    """
    count = solid.round_axes
    if count:
        square = _dot(rays[:count], rays) + TINY
        middle = _dot(starts[:count], rays) / square
        root = np.sqrt(middle * middle - (_dot(starts[:count], starts) - solid.half_m[0] ** 2) / square)
        yield -root - middle, root - middle
    for axis in range(count, 3):
        first = (-solid.half_m[axis] - starts[axis]) / rays[axis]
        other = (solid.half_m[axis] - starts[axis]) / rays[axis]
        yield np.minimum(first, other), np.maximum(first, other)


def _shadowed(
    placed: Sequence[Placed], points: Sequence[Many], owner: NDArray[np.int32], light: Exact
) -> NDArray[np.bool_]:
    """Which points another shape than their own keeps the light from."""
    dark = np.zeros(owner.size, dtype=np.bool_)
    across = _unit(np.cross(light, np.eye(3)[np.abs(light).argmin()]))
    axes = np.array([across, np.cross(light, across), light])
    at = [_dot(axis, points) for axis in axes.tolist()]
    for number, (solid, turn, _, _, ray, _) in enumerate(placed, 1):
        reach, (x, y, z) = math.hypot(*solid.half_m), (axes @ solid.pose[0]).tolist()
        beside = (np.abs(at[0] - x) < reach) & (np.abs(at[1] - y) < reach)
        some = np.flatnonzero(beside & (at[2] < z + reach) & (owner != number))
        ways = [coordinates[some] - place for coordinates, place in zip(points, solid.pose[0], strict=True)]
        starts = [_dot(axis, ways) for axis in zip(*turn, strict=True)]
        enters, leaves = zip(*_spans(solid, starts, ray), strict=True)
        leave = np.minimum.reduce(leaves)
        dark[some] |= (leave > TOUCH_M) & (leave >= np.maximum.reduce(enters))
    return dark


def _dot(some: Sequence[Any], others: Sequence[Any]) -> Any:
    """The sum of products, for as many axes as the first has."""
    total = some[0] * others[0]
    for factor, other in zip(some[1:], others[1:], strict=False):
        total = total + factor * other
    return total


def _unit(vector: Exact) -> Exact:
    return vector / np.linalg.norm(vector)
