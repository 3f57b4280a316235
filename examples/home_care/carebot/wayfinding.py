"""The way from here to there: A* on a grid of the map, then its corners only. All lengths in m."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import pairwise, product
from math import ceil, hypot

from carebot.flatmap import DOORWAY, HULL_M, WALL_Y_M, FlatMap
from carebot.watching import SAME_M

CELL_M = 0.25
"""Chosen: the narrowest place, in front of the kitchen unit, is 0.35 m from its goal, which need not be on the grid."""

MARGIN_M = 0.06
"""Between hull and map (chosen: at the sink there are 7.5 cm)."""

AROUND_M = 0.35
"""Between hull and what is not in the map (chosen: more than the room that the robot leaves ahead of it)."""

SQUEEZE_M = 0.28
"""The same where there is no way else, as between two of them (chosen: hull and wheels need 0.12 m)."""

FINE_M = 0.125
"""Of cells, where there is no way on the others: between a wall and somebody who stands near to it (chosen: half)."""

LEAVES_M = 0.75
"""Beside somebody the first cell of a way may be so far (chosen: those next to the robot may all be too near)."""

TRIES = ((AROUND_M, False, CELL_M), (SQUEEZE_M, False, CELL_M), (SQUEEZE_M, True, CELL_M), (SQUEEZE_M, True, FINE_M))
"""One after the other until there is a way: room around others, whether it may leave somebody beside it, and cells."""

STEPS = tuple((dx, dy, hypot(dx, dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy)

Point = tuple[float, float]
Cell = tuple[int, int]
Circle = tuple[float, float, float]
"""Where somebody is, and how near the robot's middle may come."""


class Wayfinder:
    """Finds ways on the map, around what else is seen."""

    def __init__(self, flat: FlatMap) -> None:
        self._flat = flat
        self._free: dict[tuple[float, Cell], bool] = {}
        self._is_leaving, self._cell_m = False, CELL_M

    def way(self, start: Point, goal: Point, others: Sequence[Point] = ()) -> list[Point] | None:
        """The corners of a way, without its start and with its goal; None where there is none.

        With others about it keeps well away from them, or a little less where there is no way else. Nearer to one than
        that already, it may go wherever it does not come nearer to that one than it is.

        Args:
            start: where the robot is: it may leave from wherever it stands.
            goal: where it is to go.
            others: points that are not in the map, to keep away from.
        """
        for room_m, self._is_leaving, self._cell_m in TRIES:
            circles = [(x, y, HULL_M + room_m) for x, y in others]
            way = self._way(start, goal, _left(circles, start) if self._is_leaving else circles)
            if way is not None or not others:
                break
        return way

    def _way(self, start: Point, goal: Point, circles: Sequence[Circle]) -> list[Point] | None:
        if self._is_clear(start, goal, circles):
            return [goal]
        if self._is_near(goal, circles):
            return None
        cells = self._search(start, self._cell(goal), circles)
        if cells is None:
            return None
        return self._corners([start, *(map(self._centre, cells[1:-1])), goal], circles)

    def _search(self, start: Point, goal: Cell, circles: Sequence[Circle]) -> list[Cell] | None:
        first = self._cell(start)
        costs, came_from = {first: 0.0}, {first: first}
        open_cells, closed = [(0.0, first)], set()
        while open_cells:
            _, cell = heappop(open_cells)
            if cell == goal:
                return _traced(came_from, goal)
            if cell in closed:
                continue
            closed.add(cell)
            leaves = self._is_leaving and cell == first
            near = self._around(start, circles) if leaves else self._neighbours(cell, goal, circles)
            for neighbour, length in near:
                cost = costs[cell] + length
                if cost < costs.get(neighbour, float("inf")):
                    costs[neighbour], came_from[neighbour] = cost, cell
                    rest = hypot(goal[0] - neighbour[0], goal[1] - neighbour[1])
                    heappush(open_cells, (cost + rest, neighbour))
        return None

    def _neighbours(self, cell: Cell, goal: Cell, circles: Sequence[Circle]) -> Iterator[tuple[Cell, float]]:
        for dx, dy, length in STEPS:
            neighbour = cell[0] + dx, cell[1] + dy
            if neighbour == goal or self._is_free(neighbour, circles):
                yield neighbour, length

    def _around(self, start: Point, circles: Sequence[Circle]) -> Iterator[tuple[Cell, float]]:
        """Cells to which it can leave straight from where it is, which need not be on the grid."""
        cells = round(LEAVES_M / self._cell_m)
        first, reach = self._cell(start), range(-cells, cells + 1)
        for dx, dy in product(reach, reach):
            cell = first[0] + dx, first[1] + dy
            if self._is_free(cell, circles) and self._is_clear(start, self._centre(cell), circles):
                yield cell, hypot(dx, dy)

    def _is_free(self, cell: Cell, circles: Sequence[Circle]) -> bool:
        centre = self._centre(cell)
        free = self._free.get((self._cell_m, cell))
        if free is None:
            free = self._free[self._cell_m, cell] = self._flat.clearance_m(*centre) >= HULL_M + MARGIN_M
        return free and not self._is_near(centre, circles)

    def _corners(self, points: list[Point], circles: Sequence[Circle]) -> list[Point]:
        """Leaves out what a straight line can do without."""
        way, at = [], 0
        while at < len(points) - 1:
            ahead = len(points) - 1
            while ahead > at + 1 and not self._is_clear(points[at], points[ahead], circles):
                ahead -= 1
            way.append(points[ahead])
            at = ahead
        return way

    def _is_clear(self, start: Point, end: Point, circles: Sequence[Circle]) -> bool:
        """Whether the robot can drive straight; it can leave and reach a place that is narrower than the rest."""
        length_m = hypot(end[0] - start[0], end[1] - start[1])
        pieces = max(ceil(length_m / self._cell_m), 1)
        for piece in range(1, pieces):
            part = piece / pieces
            point = start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1])
            if self._flat.clearance_m(*point) < HULL_M + MARGIN_M or self._is_near(point, circles):
                return False
        return not self._is_near(end, circles)

    def _cell(self, point: Point) -> Cell:
        return round(point[0] / self._cell_m), round(point[1] / self._cell_m)

    def _centre(self, cell: Cell) -> Point:
        return cell[0] * self._cell_m, cell[1] * self._cell_m

    def _is_near(self, point: Point, circles: Sequence[Circle]) -> bool:
        return any(hypot(point[0] - x, point[1] - y) < keeps_m for x, y, keeps_m in circles)


def _left(circles: Sequence[Circle], start: Point) -> list[Circle]:
    """The circles, smaller where the robot already is nearer to somebody; one person is seen as many points."""
    far_m = [hypot(start[0] - x, start[1] - y) for x, y, _ in circles]
    return [
        (
            x,
            y,
            min(
                [keeps_m, *(far for far, (u, v, _) in zip(far_m, circles, strict=True) if hypot(u - x, v - y) < SAME_M)]
            ),
        )
        for x, y, keeps_m in circles
    ]


def published_way(start: Point, goal: Point) -> list[Point]:
    """The way of the published program: straight, and from one room to the other by the doorway."""
    leaves = (start[1] > WALL_Y_M) != (goal[1] > WALL_Y_M)  # unreachable: a published fault, which is off
    return [*((DOORWAY,) if leaves else ()), goal]  # unreachable: a published fault, which is off


def length_m(start: Point, way: Sequence[Point]) -> float:
    """How long a way is."""
    corners = [start, *way]
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(corners))


def _traced(came_from: dict[Cell, Cell], goal: Cell) -> list[Cell]:
    cells = [goal]
    while came_from[cells[-1]] != cells[-1]:
        cells.append(came_from[cells[-1]])
    return cells[::-1]
