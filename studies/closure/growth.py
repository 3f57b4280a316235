"""The points that a session reached, run by run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.extra.closing.observation import code_points
from pytest_hricdv.extra.closing.records import CLOSING, ClosingResult
from pytest_hricdv.generate.rng import make_rng, shuffle
from pytest_hricdv.results.model import Report, TestResult
from studies.session import SessionError


@dataclass(frozen=True)
class Step:
    """A run that hit new points: its number from 1, the simulated time up to its end (s), and these points."""

    run: int
    sim_s: float
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Growth:
    """What a session reached.

    Args:
        series: the suite, or the loop without one of its strategies.
        seed: of the session.
        steps: the runs that hit new points, in order.
        runs: all of them.
        sim_s: their simulated time.
        closing: what the loop has shown; None of another suite.
        wall_s: how long the session took.
    """

    series: str
    seed: int
    steps: tuple[Step, ...]
    runs: int
    sim_s: float
    closing: ClosingResult | None = None
    wall_s: float = 0.0

    def reached(self, wanted: Set[Point], *, sim_s: float | None = None, runs: int | None = None) -> Counter[str]:
        """Kind -> the wanted points that were hit; by so much simulated time, or so many runs, where given."""
        return Counter(
            point[0]
            for step in self.steps
            if (sim_s is None or step.sim_s <= sim_s) and (runs is None or step.run <= runs)
            for point in step.points
            if point in wanted
        )


def of_loop(series: str, seed: int, report: Report) -> Growth:
    """What a closing loop reached, in the order of its runs. Raises SessionError where the report has none."""
    closing = CLOSING.of(report)
    if closing is None:
        raise SessionError(f"{series} at seed {seed}: the report has no closing loop")
    by_run: dict[int, list[Point]] = {}
    for hit in closing.hit:
        by_run.setdefault(hit.run, []).append(hit.point)
    times = {step.run: step.sim_s for step in closing.growth}
    steps = tuple(Step(run, times[run], tuple(points)) for run, points in sorted(by_run.items()))
    return Growth(series, seed, steps, closing.runs, closing.sim_s, closing, report.wall_s)


def of_suite(series: str, seed: int, report: Report) -> Growth:
    """What the tests of a suite reached, in a random order that depends on suite and seed only.

    They stand in the report sorted by their ids, so those of a kind side by side.

    Raises:
        SessionError: the code under test was not measured.
    """
    code = CodeMap.of(report.code_under_test)
    if code is None or not report.code_under_test.measured:
        raise SessionError(f"{series} at seed {seed}: unmeasured: {report.code_under_test.reason}")
    tests = shuffle(make_rng("closure", series, seed), report.tests)
    steps = tuple(_steps(tests, code))
    return Growth(series, seed, steps, len(tests), sum(test.sim_s for test in tests), None, report.wall_s)


def _steps(tests: Iterable[TestResult], code: CodeMap) -> Iterator[Step]:
    seen: set[Point] = set()
    sim_s = 0.0
    for number, test in enumerate(tests, 1):
        sim_s += test.sim_s
        new = tuple(point for point in dict.fromkeys(_points(test, code)) if point not in seen)
        seen.update(new)
        if new:
            yield Step(number, sim_s, new)


def _points(test: TestResult, code: CodeMap) -> Iterator[Point]:
    """The points that a test hits, as the closing loop counts them."""
    yield from code_points(code, Bits.of(test.code))
    yield from (("plan", agent, label) for agent, labels in test.plans.items() for label in labels)
    yield from (("bin", name, *hit) for name, hits in (test.cross or {}).items() for hit in hits)
    yield from (("verdict", name, result.verdict) for name, result in test.requirements.items())


UNRECORDED = frozenset({"condition", "transition"})
"""Points of these kinds are in no report of a suite that is not closed."""


def wanted_points(sessions: Iterable[Growth]) -> set[Point]:
    """The points that are to be hit: of the loops, those that are hit or open.

    Without those that were thought impossible, though a disturbed run may hit one.
    """
    loops = [growth.closing for growth in sessions if growth.closing is not None]
    hit = {point.point for closing in loops for point in closing.hit}
    wanted = hit | {point.point for closing in loops for point in closing.open}
    wanted -= {point.point for closing in loops for point in closing.impossible}
    return {point for point in wanted if point[0] not in UNRECORDED}
