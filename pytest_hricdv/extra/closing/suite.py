"""The suite that a closing loop yields: a small part of its tests, which hits all that its runs hit; and its cache.

`ClosureGenerator` calls `repeatable_suite`, or `smallest_suite` if tests cannot be run again, and keeps the suite in a
`SuiteCache` for later sessions.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from hashlib import sha256

import msgspec

from pytest_hricdv._base import sealed_cache
from pytest_hricdv.coverage.closure import MeasuredTest, Point, minimal_suite
from pytest_hricdv.extra.closing.loop import BatchRunner
from pytest_hricdv.extra.closing.records import CLOSING, ClosingResult
from pytest_hricdv.extra.closing.strategy import GIVEN, Archive, ArchivedRun
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.suite import Suite
from pytest_hricdv.results.report_builder import GeneratedSuite
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.suites import CACHE_FOLDER

UNCOUNTED = frozenset({"antecedent"})
"""Kinds of points for which the suite needs no test."""


def repeatable_suite(
    archive: Archive, strategies: Container[str], runner: BatchRunner
) -> tuple[tuple[ArchivedRun, ...], tuple[ArchivedRun, ...]]:
    """The smallest suite of tests whose runs repeat, and the runs left out because they did not repeat.

    Args:
        archive: all runs.
        strategies: the strategies whose tests run otherwise in the suite than in the loop, and so are run again.
        runner: runs tests as in the suite.
    """
    checked: set[int] = set()
    left_out: dict[int, ArchivedRun] = {}
    while True:
        suite = smallest_suite(archive, left_out)
        unchecked = [entry for entry in suite if entry.strategy in strategies and entry.number not in checked]
        if not unchecked:
            return suite, tuple(left_out.values())
        checked.update(entry.number for entry in unchecked)
        again = dict(runner([entry.test for entry in unchecked], frozenset()))
        for place, entry in enumerate(unchecked):
            if again[place].record_sha256 != entry.observation.record_sha256:
                left_out[entry.number] = entry


def smallest_suite(archive: Archive, without: Container[int] = ()) -> tuple[ArchivedRun, ...]:
    """The runs whose tests make the suite, those that add most per simulated second first.

    It leaves out the runs numbered in `without`, the tests of suites before the loop, and what only these hit.
    """
    hit_before = set[Point]()
    for entry in archive.entries:
        if entry.strategy == GIVEN:
            hit_before.update(entry.observation.points)
    numbers: dict[Point, int] = {}
    usable = [entry for entry in archive.entries if entry.strategy != GIVEN and entry.number not in without]
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


class SuiteCache:
    """The cache of a suite, its evidence and the files that its runs loaded; it is outdated when one of these changes.

    Args:
        key: the key of all else that the suite depends on.
    """

    def __init__(self, collection: Collection, key: str) -> None:
        self._cache = getattr(collection.config, "cache", None)
        self._root = collection.config.rootpath
        self._key = f"{CACHE_FOLDER}/{key}"

    def read(self) -> GeneratedSuite | None:
        """The suite; None if there is none, or it is of other files."""
        kept = sealed_cache.read(self._cache, self._key)
        try:
            if kept is None or kept["files"] != self._digests(kept["files"]):
                return None
            closing = msgspec.json.decode(kept["closing"], type=ClosingResult)
            return GeneratedSuite(Suite.from_json(kept["suite"]), 0.0, cached=True, sections={CLOSING.name: closing})
        except (GenerateError, KeyError, TypeError, msgspec.DecodeError):
            return None  # written by another version, or cut off

    def write(self, suite: Suite, closing: ClosingResult, files: Sequence[str]) -> None:
        """Keep a suite."""
        if self._cache is not None:
            evidence = msgspec.json.encode(closing).decode()
            digests = self._digests(dict.fromkeys(files, ""))
            sealed_cache.write(
                self._cache, self._key, {"files": digests, "suite": suite.to_json(), "closing": evidence}
            )

    def _digests(self, files: Mapping[str, str]) -> dict[str, str]:
        digests = {}
        for name in files:
            path = self._root / name
            digests[name] = sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        return digests
