"""The suite of a closing loop: a small part of its tests that hits all that its runs hit."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable

from pytest_hricdv.coverage.closure import MeasuredTest, Point, minimal_suite
from pytest_hricdv.extra.closing.archive import GIVEN, Archive, Entry
from pytest_hricdv.extra.closing.loop import Runner

UNCOUNTED = frozenset({"antecedent"})
"""Kinds of points that no test has to be kept for."""


def repeatable_suite(
    archive: Archive, ways: Collection[str], runner: Runner
) -> tuple[tuple[Entry, ...], tuple[Entry, ...]]:
    """The smallest suite of tests that do the same again; and those left out, because they did not.

    Args:
        archive: all runs.
        ways: whose tests were not run as they will be in the suite, and so are run again.
        runner: runs tests as in the suite.
    """
    checked: set[int] = set()
    left_out: dict[int, Entry] = {}
    while True:
        suite = smallest_suite(archive, left_out)
        unchecked = [entry for entry in suite if entry.way in ways and entry.number not in checked]
        if not unchecked:
            return suite, tuple(left_out.values())
        checked.update(entry.number for entry in unchecked)
        again = dict(runner([entry.test for entry in unchecked], {}))
        for place, entry in enumerate(unchecked):
            if again[place].record_sha256 != entry.observation.record_sha256:
                left_out[entry.number] = entry


def smallest_suite(archive: Archive, without: Container[int] = ()) -> tuple[Entry, ...]:
    """The runs whose tests make the suite, those that add most per simulated second first.

    Tests that were given are not part of it: what they hit, it need not hit.

    Args:
        archive: all runs.
        without: the numbers of runs that are left out.
    """
    hit_before = set[Point]()
    for entry in archive.entries:
        if entry.way == GIVEN:
            hit_before.update(entry.observation.points)
    numbers: dict[Point, int] = {}
    usable = [entry for entry in archive.entries if entry.way != GIVEN and entry.number not in without]
    runs = {str(entry.number): entry for entry in usable}
    measured = [
        MeasuredTest(name, _bits(entry.observation.points, hit_before, numbers), entry.observation.sim_s)
        for name, entry in runs.items()
    ]
    return tuple(runs[step.name] for step in minimal_suite(measured))


def _bits(points: Iterable[Point], hit_before: set[Point], numbers: dict[Point, int]) -> int:
    bits = 0
    for point in points:
        if point[0] not in UNCOUNTED and point not in hit_before:
            bits |= 1 << numbers.setdefault(point, len(numbers))
    return bits
