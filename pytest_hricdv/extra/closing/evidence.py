"""`evidence`: what a closing loop has shown for each point, and how many kinds of violations another run would find.

`ClosureGenerator` calls it after the loop; it returns the `ClosingResult` of the report. Bounds are those of
independent trials: if n runs had no success, the probability of a success is below 3/n with 95 % confidence (rule of
three; Hanley, Lippman-Hand, If nothing goes wrong, is everything all right?, JAMA 249, 1983).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.observation import FAULT, KINDS, NEW, describe
from pytest_hricdv.extra.closing.records import (
    RULE_OF_THREE,
    ClosingEnd,
    ClosingResult,
    GrowthStep,
    HitPoint,
    ImpossiblePoint,
    KindCount,
    NearestRun,
    OpenPoint,
    StrategyResult,
    ViolationEstimate,
    ViolationKind,
)
from pytest_hricdv.extra.closing.strategy import GIVEN, Archive, ArchivedRun
from pytest_hricdv.extra.closing.targets import Surroundings, by_kind, explain_gap, nearest, waiver
from pytest_hricdv.extra.closing.violation_strategy import NAME, vacuous_alternatives
from pytest_hricdv.extra.closing.violation_strategy import NAME as SEARCHING
from pytest_hricdv.generate.suite_files import dump_tests


def evidence(
    archive: Archive,
    tests: Iterable[ArchivedRun],
    impossible: Sequence[ImpossiblePoint],
    surroundings: Surroundings,
    *,
    suite: str,
    ended: ClosingEnd,
    budget: int,
    without: Container[int] = (),
) -> ClosingResult:
    """The evidence from the runs of an archive.

    Args:
        archive: all runs.
        tests: the runs whose tests are in the suite.
        impossible: points that cannot be hit. One that was hit nevertheless counts as hit.
        surroundings: the code, model and requirements that are tested.
        budget: largest number of runs.
        without: numbers of runs that do not repeat: what only they hit is open.
    """
    seen = _HitCounts(archive, impossible, without)
    handed = (*(entry for entry in archive.entries if entry.strategy == GIVEN), *tests)
    runs = [entry for entry in archive.entries if entry.strategy != GIVEN]
    hit = tuple(seen.hit(handed))
    closed = tuple(point for point in impossible if point.point not in seen.first)
    left, others = _open(
        [target for target in archive.targets if target not in seen.first], archive, handed, surroundings
    )
    near = tuple(nearest_runs(archive, {entry.number for entry in handed}, without))
    others |= _test_texts(archive, handed, {run.test for run in near if run.spread})
    return ClosingResult(
        suite=suite,
        end_reason=ended,
        budget=budget,
        runs=len(runs),
        initial_runs=len(archive.entries) - len(runs),
        errored_runs=sum(bool(entry.observation.error) for entry in runs),
        sim_s=round(sum(entry.observation.sim_s for entry in runs), 6),
        bound=rule_of_three(len(runs)),
        kinds=_kinds(hit, closed, left),
        strategies=_strategies(runs, seen.new),
        growth=tuple(_growth(archive.entries, seen.new)),
        hit=hit,
        impossible=closed,
        open=left,
        violations=_violations(archive, handed, without),
        searched=sum(entry.strategy == SEARCHING for entry in runs),
        closest_runs=near,
        estimated_undetected=violation_estimate(archive, without),
        closest_tests=others,
    )


def rule_of_three(trials: int) -> float | None:
    """Upper bound of the probability of what never happened in a number of trials; None without trials."""
    return min(1.0, RULE_OF_THREE / trials) if trials else None


class _HitCounts:
    """Counts of hits of the targets and of the points that were thought impossible."""

    def __init__(self, archive: Archive, impossible: Iterable[ImpossiblePoint], without: Container[int]) -> None:
        points = dict.fromkeys([*archive.targets, *(point.point for point in impossible)])
        self._archive = archive
        self._given = sum(entry.strategy == GIVEN for entry in archive.entries)
        self.first: dict[Point, ArchivedRun] = {}
        self.new: dict[int, Counter[str]] = {}
        """Number of a run -> kind -> points that no earlier run had hit; without runs that hit no such point."""
        for entry in (run for run in archive.entries if run.number not in without):
            hit = [point for point in entry.observation.points if point in points]
            fresh = [point for point in hit if point not in self.first]
            self.first.update(dict.fromkeys(fresh, entry))
            if fresh:
                self.new[entry.number] = by_kind(fresh)
        self._order = [point for point in points if point in self.first]

    def hit(self, handed: Sequence[ArchivedRun]) -> Iterable[HitPoint]:
        """The points that are hit, each with the first of these tests that hits it, else with the best of all."""
        tests = _tests(self._archive, handed)
        for point in self._order:
            first = self.first[point]
            run = 0 if first.strategy == GIVEN else first.number - self._given + 1
            yield HitPoint(point=point, test=tests[point], strategy=first.strategy, run=run)


def _tests(archive: Archive, handed: Sequence[ArchivedRun]) -> dict[Point, str]:
    """A test that hits each point: the first of these that does, else the best of all."""
    tests = {point: entry.test.id for point, entry in archive.best.items()}
    for entry in reversed(handed):
        tests.update(dict.fromkeys(entry.observation.points, entry.test.id))
    return tests


def _violations(archive: Archive, handed: Sequence[ArchivedRun], without: Container[int]) -> tuple[ViolationKind, ...]:
    counts = Counter(
        point
        for entry in archive.entries
        if entry.number not in without
        for point in entry.observation.points
        if point[0] in KINDS
    )
    tests = _tests(archive, handed)
    violations = [describe(point, counts[point], tests[point]) for point in sorted(counts)]
    return tuple(sorted(violations, key=lambda violation: violation.known))


def _open(
    points: Iterable[Point], archive: Archive, handed: Sequence[ArchivedRun], surroundings: Surroundings
) -> tuple[tuple[OpenPoint, ...], dict[str, str]]:
    """The open points; and the tests that came nearest and are not handed over, with their texts."""
    preferred = {entry.number for entry in handed}
    open_points, others = [], {}
    for point in points:
        entry = nearest(point, archive, preferred)
        if entry is not None and entry.number not in preferred:
            others[entry.test.id] = dump_tests([entry.test])
        open_points.append(
            OpenPoint(
                point=point,
                tries=archive.tries[point],
                bound=rule_of_three(archive.tries[point]),
                test=entry.test.id if entry is not None else "",
                lacking=explain_gap(point, entry, archive, surroundings),
                waiver=waiver(point, archive),
            )
        )
    return tuple(open_points), others


def _test_texts(archive: Archive, handed: Sequence[ArchivedRun], ids: Container[str]) -> dict[str, str]:
    """The texts of tests with these ids that are not handed over."""
    numbers = {entry.number for entry in handed}
    return {
        entry.test.id: dump_tests([entry.test])
        for entry in archive.entries
        if entry.test.id in ids and entry.number not in numbers
    }


def _kinds(
    hit: Iterable[HitPoint], impossible: Iterable[ImpossiblePoint], left: Iterable[OpenPoint]
) -> dict[str, KindCount]:
    counts = [by_kind(point.point for point in points) for points in (hit, impossible, left)]
    kinds = dict.fromkeys(kind for count in counts for kind in count)
    return {kind: KindCount(hit=counts[0][kind], impossible=counts[1][kind], open=counts[2][kind]) for kind in kinds}


def _strategies(runs: Sequence[ArchivedRun], new: Mapping[int, Counter[str]]) -> dict[str, StrategyResult]:
    by_strategy: dict[str, list[ArchivedRun]] = {}
    for entry in runs:
        by_strategy.setdefault(entry.strategy, []).append(entry)
    return {
        strategy: StrategyResult(
            runs=len(entries),
            sim_s=round(sum(entry.observation.sim_s for entry in entries), 6),
            new=sum((new.get(entry.number, Counter()) for entry in entries), Counter()),
        )
        for strategy, entries in by_strategy.items()
    }


def _growth(entries: Iterable[ArchivedRun], new: Mapping[int, Counter[str]]) -> Iterable[GrowthStep]:
    run, sim_s = 0, 0.0
    for entry in entries:
        if entry.strategy != GIVEN:
            run += 1
            sim_s += entry.observation.sim_s
        if entry.number in new:
            yield GrowthStep(run=run, sim_s=round(sim_s, 6), strategy=entry.strategy, new=new[entry.number])


def nearest_runs(archive: Archive, handed: Container[int], without: Container[int]) -> Iterator[NearestRun]:
    """The run with the least margin for each requirement that any run triggered.

    Args:
        archive: all runs.
        handed: numbers of runs whose tests are handed over; they win between equal margins.
        without: numbers of runs that do not repeat.
    """
    runs = [entry for entry in archive.entries if entry.number not in without]
    tried = Counter(target[1] for entry in runs if entry.strategy == NAME for target in entry.targets)
    for name in sorted({name for entry in runs for name in entry.observation.unused}):
        triggered = [entry for entry in runs if name in entry.observation.unused]
        margins = {entry.number: entry.observation.margins.get(name, math.inf) for entry in triggered}
        nearest = min(triggered, key=lambda entry: (margins[entry.number], entry.number not in handed, entry.number))
        finite = [margin for margin in margins.values() if margin < math.inf]
        yield NearestRun(
            requirement=name,
            margin=min(finite, default=None),
            spread=round(max(finite) - min(finite), 9) if finite else None,
            test=nearest.test.id if finite else "",
            runs=len(triggered),
            searched=tried[name],
            vacuous_alternatives=vacuous_alternatives(archive, name),
        )


def violation_estimate(archive: Archive, without: Container[int]) -> ViolationEstimate | None:
    """The expected number of new kinds of violations in another run; None without runs."""
    runs = [entry for entry in archive.entries if entry.number not in without and not entry.observation.error]
    if not runs:
        return None
    times = Counter(point for entry in runs for point in entry.observation.points if point[0] in (NEW, FAULT))
    once = sum(count == 1 for count in times.values())
    return ViolationEstimate(kinds=len(times), once=once, runs=len(runs), new=once / len(runs))
