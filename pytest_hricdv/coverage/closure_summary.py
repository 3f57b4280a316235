"""The closure of tests: the points that they cover together, the minimal suite for these, and what each test adds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import reduce

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.minimization import MeasuredTest, growth, minimal_suite, unique
from pytest_hricdv.coverage.records import Closure, MinimalStep
from pytest_hricdv.coverage.suite_coverage import RunCoverage, TestCoverage

Point = tuple[str, ...]
"""What it is ("plan", "bin", "verdict"), and its names."""


class PointIndex:
    """Numbers the points of a report's tests, so that sets of points are compared with `|` and `&`.

    Statements and branches come first, with the numbers that they have in tests' bits. Plans, bins of cross products
    (legal ones) and verdicts of requirements (Passed, Failed) follow in the order in which they are met.

    Args:
        statements: how many statements the code has.
        branches: how many branches.
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
            for point in self._named(run):
                covered |= 1 << self._first + self._numbers.setdefault(point, len(self._numbers))
        return covered

    def _named(self, run: RunCoverage) -> Iterable[Point]:
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
