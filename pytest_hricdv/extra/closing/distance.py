"""Distances of runs from a point that none of them has hit."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive, Entry

ELITE = 0.2
"""The share of runs, those that came nearest, that count (cross-entropy method; R. Rubinstein, D. Kroese: The
Cross-Entropy Method, 2004). The literature has 1 to 10 % of many draws; here there are some dozens of runs: chosen
(0.1: no change, 0.4: -0.5 +- 1.0, for runs near to a point only; see the package)."""


def elite_size(runs: int) -> int:
    """How many of so many runs are the elite."""
    return math.ceil(ELITE * runs)


def nearest_runs(point: Point, archive: Archive) -> list[tuple[float, Entry]]:
    """The runs that came near to an open point, the nearest first, each with its distance.

    The distance is the run's own where it has one. To a branch it is 1 for runs that executed the statement it leads
    away from; to a statement, the number of lines between it and the last statement before it that a run executed. Of
    such runs those are nearer, by less than 1, that executed something unusual near it: fewer than half of them did
    (half is chosen; its effect was not measured).
    From other points no distance is known.
    """
    measured = [
        (distance, entry)
        for entry in archive.entries
        for other, distance in entry.observation.distances
        if other == point
    ]
    return sorted(measured or _by_code(point, archive), key=lambda run: (run[0], run[1].number))


def _by_code(point: Point, archive: Archive) -> Iterator[tuple[float, Entry]]:
    if point[0] == "branch":
        before: list[Point] = [("statement", point[1], point[2])]
    elif point[0] == "statement":
        lines = [target for target in archive.targets if target[:2] == point[:2]]
        before = [line for line in reversed(lines) if int(line[2]) < int(point[2]) and line in archive.best][:1]
    else:
        return
    for line in before:
        runs = archive.hit_by.get(line, [])
        distance = 1.0 if point[0] == "branch" else float(abs(int(point[2]) - int(line[2])))
        gaps = _gaps_to_unusual(point[1], int(point[-1]), runs, archive)
        yield from ((distance + gaps.get(number, 1.0), archive.entries[number]) for number in runs)


def _gaps_to_unusual(file: str, line: int, runs: Collection[int], archive: Archive) -> dict[int, float]:
    """Number of a run -> how far the line is from a statement that the run executed and few of these runs did: 0 to 1.

    Without those that executed none. Normalized by x / (x + 1), which keeps the order: Arcuri, It really does matter
    how you normalize the branch distance in search-based software testing, Softw. Test. Verif. Reliab. 23 (2013).
    """
    among, gaps = frozenset(runs), dict[int, float]()
    statements = (point for point in archive.hit_by if point[:2] == ("statement", file))
    for statement in sorted(statements, key=lambda point: (abs(int(point[2]) - line), int(point[2]))):
        gap, same = abs(int(statement[2]) - line), among.intersection(archive.hit_by[statement])
        if 2 * len(same) < len(among):
            for number in same:
                gaps.setdefault(number, gap / (gap + 1.0))
    return gaps
