"""The suite of a closing loop: a small part of its tests that hits all that its runs hit."""

from __future__ import annotations

from collections.abc import Iterable

from pytest_hricdv.close.archive import GIVEN, Archive, Entry
from pytest_hricdv.coverage.closure import MeasuredTest, Point, minimal_suite

UNCOUNTED = frozenset({"antecedent"})
"""Kinds of points that no test has to be kept for."""


def smallest_suite(archive: Archive) -> tuple[Entry, ...]:
    """The runs whose tests make the suite, those that add most per simulated second first.

    Tests that were given are not part of it: what they hit, it need not hit.
    """
    given = set[Point]()
    for entry in archive.entries:
        if entry.way == GIVEN:
            given.update(entry.observation.points)
    numbers: dict[Point, int] = {}
    runs = {str(entry.number): entry for entry in archive.entries if entry.way != GIVEN}
    measured = [
        MeasuredTest(name, _bits(entry.observation.points, given, numbers), entry.observation.sim_s)
        for name, entry in runs.items()
    ]
    return tuple(runs[step.name] for step in minimal_suite(measured))


def _bits(points: Iterable[Point], given: set[Point], numbers: dict[Point, int]) -> int:
    bits = 0
    for point in points:
        if point[0] not in UNCOUNTED and point not in given:
            bits |= 1 << numbers.setdefault(point, len(numbers))
    return bits
