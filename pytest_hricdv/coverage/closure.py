"""Coverage closure: what the tests of a suite cover together, the minimal suite, and what each test adds.

`PointIndex` makes one bit set of all that a test covers. `closure_summary` and `cross_closure` give a report's records
to `results.derivation`; the closing loop and mutation select tests with `minimal_suite`.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

from pytest_hricdv.coverage.cross_product import (
    Bin,
    BinHits,
    Coordinate,
    CrossCoverage,
    CrossProduct,
    IllegalBin,
    ImpossibleBin,
    ProductCoverage,
    ProductDeclaration,
    Proof,
)
from pytest_hricdv.coverage.records import Closure, MinimalStep
from pytest_hricdv.coverage.suite_coverage import RunCoverage, TestCoverage

Point = tuple[str, ...]
"""A coverage point: its kind ("plan", "bin", "verdict"), and its names."""


@dataclass(frozen=True)
class MeasuredTest:
    """A test, the points that it covers (a bit set), and what it costs (s of simulated time)."""

    name: str
    points: int
    cost_s: float


@dataclass(frozen=True)
class CoverageStep:
    """A test of the minimal suite: points it adds to the tests before it; points and cost of all up to it."""

    name: str
    gain: int
    points: int
    cost_s: float


def minimal_suite(tests: Sequence[MeasuredTest]) -> tuple[CoverageStep, ...]:
    """A small subset of the tests that covers as much as all of them, ordered by points gained per simulated second.

    Greedy: within a factor of ln(n) + 1 of the cheapest suite (Chvatal 1979). Tests that later ones made redundant are
    removed again.
    """
    return _sort(_without_redundant(_greedy(tests)))


def growth(tests: Sequence[MeasuredTest]) -> tuple[tuple[float, int], ...]:
    """Cumulative coverage in the order of the tests: (cost up to a test, points) at each test that adds any."""
    covered, cost_s = 0, 0.0
    steps = []
    for test in tests:
        cost_s += test.cost_s
        if test.points & ~covered:
            covered |= test.points
            steps.append((round(cost_s, 6), covered.bit_count()))
    return tuple(steps)


def unique(tests: Sequence[MeasuredTest]) -> dict[str, int]:
    """Name -> how many points no other test covers; tests without such a point are left out."""
    once = twice = 0
    for test in tests:
        twice |= once & test.points
        once |= test.points
    alone = {test.name: (test.points & ~twice).bit_count() for test in tests}
    return {name: count for name, count in alone.items() if count}


def _greedy(tests: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Tests that add most per second, until nothing is added. A gain only falls, so a lazy heap re-evaluates few."""
    by_name = {test.name: test for test in tests}
    queue = [(-_rate(test, test.points), test.name) for test in tests if test.points]
    heapq.heapify(queue)
    chosen, covered = [], 0
    while queue:
        _, name = heapq.heappop(queue)
        test = by_name[name]
        added = test.points & ~covered
        if not added:
            continue
        now = (-_rate(test, added), name)
        if queue and queue[0] < now:
            heapq.heappush(queue, now)
            continue
        chosen.append(test)
        covered |= added
    return chosen


def _without_redundant(chosen: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Drop tests whose points the others cover, the most expensive ones first."""
    count: Counter[int] = Counter()
    points = {test.name: _bits(test.points) for test in chosen}
    for places in points.values():
        count.update(places)
    kept = []
    for test in sorted(chosen, key=lambda test: (-test.cost_s, test.name)):
        if all(count[point] > 1 for point in points[test.name]):
            count.subtract(points[test.name])
        else:
            kept.append(test)
    return kept


def _sort(chosen: Sequence[MeasuredTest]) -> tuple[CoverageStep, ...]:
    steps: list[CoverageStep] = []
    covered, cost_s = 0, 0.0
    for test in _greedy(chosen):
        gain = (test.points & ~covered).bit_count()
        covered |= test.points
        cost_s += test.cost_s
        steps.append(CoverageStep(test.name, gain, covered.bit_count(), round(cost_s, 6)))
    return tuple(steps)


def _rate(test: MeasuredTest, points: int) -> float:
    """Points per second; a test that ends at once counts as one second, or its rate would be infinite."""
    return points.bit_count() / max(test.cost_s, 1.0)


def _bits(points: int) -> list[int]:
    text = bin(points)[:1:-1]
    return [place for place, digit in enumerate(text) if digit == "1"]


class PointIndex:
    """Numbers the points of a report's tests, so that sets of points are compared with `|` and `&`.

    Statements and branches come first, with the numbers that they have in tests' bits. Plans, bins of cross products
    (legal ones) and verdicts of requirements (Passed, Failed) follow in the order in which they are met.

    Args:
        statements: how many statements the code has.
        illegal: bins that do not have to be covered, by cross product.
    """

    def __init__(self, statements: int, branches: int, illegal: Mapping[str, Iterable[Bin]]) -> None:
        self._statements = statements
        self._first = statements + branches
        self._illegal = {name: set(bins) for name, bins in illegal.items()}
        self._numbers: dict[Point, int] = {}

    def points(self, runs: Iterable[RunCoverage]) -> int:
        """The points that any of these runs covers, as a bit set."""
        covered = 0
        for run in runs:
            if run.code is not None:
                covered |= run.code.statements | (run.code.branches or 0) << self._statements
            for point in self._names(run):
                covered |= 1 << self._first + self._numbers.setdefault(point, len(self._numbers))
        return covered

    def _names(self, run: RunCoverage) -> Iterable[Point]:
        for agent, labels in run.plans.items():
            yield from (("plan", agent, label) for label in labels)
        for name, hits in run.cross.items():
            illegal = self._illegal.get(name, set())
            yield from (("bin", name, *hit) for hit in hits if hit not in illegal)
        for requirement, result in run.requirements.items():
            if result.verdict != "NC":
                yield "verdict", requirement, result.verdict


def closure_summary(index: PointIndex, tests: Sequence[TestCoverage]) -> Closure:
    """The closure record of some tests."""
    measured = [MeasuredTest(test.nodeid, index.points(test.runs), test.sim_s) for test in tests]
    steps = minimal_suite(measured)
    ids = {test.nodeid: test.id for test in tests}
    minimal = {step.name for step in steps}
    total = reduce(lambda covered, test: covered | test.points, measured, 0)
    return Closure(
        points=total.bit_count(),
        sim_s=round(sum(test.cost_s for test in measured), 6),
        growth=growth(measured),
        minimal=tuple(
            MinimalStep(nodeid=step.name, id=ids[step.name], gain=step.gain, points=step.points, sim_s=step.cost_s)
            for step in steps
        ),
        adds_nothing=tuple(test.nodeid for test in tests if test.was_run and test.nodeid not in minimal),
        unique=unique(measured),
    )


def declare(product: CrossProduct, proof: Proof, by_model: Mapping[Bin, str]) -> ProductDeclaration:
    """The record of a declared cross product.

    Args:
        proof: what is known of the model (see `pytest_hricdv.coverage.reachability`).
        by_model: the bins that the model proves impossible, each with the reason.
    """
    impossible = [ImpossibleBin(bin=bin_, reason=why, by="declared") for bin_, why in product.impossible_bins.items()]
    impossible += [
        ImpossibleBin(bin=bin_, reason=why, by="model")
        for bin_, why in by_model.items()
        if bin_ not in product.impossible_bins
    ]
    return ProductDeclaration(
        coordinates=tuple(Coordinate(name=name, bins=bins) for name, bins in product.coordinates.items()),
        impossible=tuple(sorted(impossible, key=lambda record: record.bin)),
        illegal=tuple(IllegalBin(bin=bin_, reason=reason) for bin_, reason in sorted(product.forbidden.items())),
        proof=proof,
    )


def cross_closure(declared: Mapping[str, ProductDeclaration], runs: Iterable[RunCoverage]) -> CrossCoverage:
    """The cross products of a suite: each one, and all together.

    An illegal bin does not have to be covered. A bin that the model proves impossible and that is nevertheless hit, as
    by a test that no model generated, counts as possible.
    """
    runs = list(runs)
    products = {
        name: _coverage_of(product, [run.cross.get(name, ()) for run in runs]) for name, product in declared.items()
    }
    several = len(products) > 1
    missing = [
        (f"{name}: " if several else "") + " x ".join(bin_)
        for name, product in products.items()
        for bin_ in product.missing
    ]
    return CrossCoverage(
        bins=sum(product.bins for product in products.values()),
        hit=sum(product.hit for product in products.values()),
        impossible=sum(product.impossible for product in products.values()),
        illegal=sum(product.illegal for product in products.values()),
        missing=tuple(missing),
        products=products,
    )


def _coverage_of(declared: ProductDeclaration, hits_of_runs: Iterable[Iterable[Bin]]) -> ProductCoverage:
    hits: Counter[Bin] = Counter()
    tests: Counter[Bin] = Counter()
    for hit_bins in hits_of_runs:
        hit = [*hit_bins]
        hits.update(hit)
        tests.update(set(hit))
    bins = CrossProduct({coordinate.name: coordinate.bins for coordinate in declared.coordinates}).bins()
    illegal = {record.bin for record in declared.illegal}
    impossible = {record.bin for record in declared.impossible} - set(hits) - illegal
    return ProductCoverage(
        bins=len(bins),
        hit=len(hits.keys() - illegal),
        impossible=len(impossible),
        illegal=len(illegal),
        hits=tuple(BinHits(bin=bin_, tests=tests[bin_], hits=hits[bin_]) for bin_ in sorted(hits)),
        missing=tuple(bin_ for bin_ in bins if bin_ not in hits and bin_ not in impossible | illegal),
    )
