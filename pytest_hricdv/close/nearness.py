"""Which runs came near to a point that no run has hit."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.close.archive import Archive, Entry
from pytest_hricdv.coverage.closure import Point


def nearest_runs(point: Point, archive: Archive) -> list[tuple[float, Entry]]:
    """The runs that came near to an open point, the nearest first, each with its distance.

    The distance is the run's own where it has one. To a branch it is 1 for runs that executed the statement it leads
    away from; to a statement, the number of statements of its file between it and the last one before it that a run
    executed. Of other points nothing is known.
    """
    measured = [
        (distance, entry)
        for entry in archive.entries
        for each, distance in entry.observation.distances
        if each == point
    ]
    found = measured or [*_by_code(point, archive)]
    return sorted(found, key=lambda each: (each[0], each[1].number))


def _by_code(point: Point, archive: Archive) -> Iterator[tuple[float, Entry]]:
    if point[0] == "branch":
        before: list[Point] = [("statement", point[1], point[2])]
    elif point[0] == "statement":
        lines = [each for each in archive.wanted if each[:2] == point[:2]]
        before = [each for each in reversed(lines) if int(each[2]) < int(point[2]) and each in archive.best][:1]
    else:
        return
    for each in before:
        distance = 1.0 if point[0] == "branch" else float(abs(int(point[2]) - int(each[2])))
        yield from ((distance, entry) for entry in archive.entries if each in entry.observation.points)
