"""Searching: when all tests have run, those that came nearest to violating a requirement are varied to come nearer.

The suite has checked its own tests already, so every run of a search is a new test. A requirement that the suite itself
violates needs no search; one that no test triggers has no margin to follow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from msgspec.structs import replace

from pytest_hricdv.case import HriCase
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.results.model import SearchResult, TestResult
from pytest_hricdv.search import Budget
from pytest_hricdv.search.evolution_strategy import Evaluation, SearchOutcome, search_violation
from pytest_hricdv.search.replay import Origin
from pytest_hricdv.session.replaying import Rerunning, named

HOW = "search"
STARTS = 5
"""So many tests are varied: few, or the runs are spread too thin; more than one, for the nearest may be a dead end."""


@dataclass(frozen=True)
class Searching:
    """Looks for violations beside a suite.

    Args:
        rerunning: runs tests.
        chosen: node id -> test, of the session.
        seed: of the session.
    """

    rerunning: Rerunning
    chosen: Mapping[str, HriCase]
    seed: int

    def search(
        self, requirement: Requirement, results: Iterable[TestResult], budget: Budget
    ) -> tuple[SearchResult, HriCase | None]:
        """Search for one requirement.

        Returns:
            The record for the report, and the test that violates the requirement where one was found.
        """
        results = sorted(results, key=lambda result: _objective(result, requirement.id))
        triggered = [result for result in results if result.requirements[requirement.id].triggers]
        if not triggered:
            return _without_runs("never triggered"), None
        margin = triggered[0].requirements[requirement.id].margin
        if any(result.requirements[requirement.id].verdict == "Failed" for result in triggered):
            return _without_runs("violated by the suite", margin, triggered[0].id), None
        starts = triggered[:STARTS]
        found = self._search(requirement, starts, budget)
        start = starts[found.start]
        record = SearchResult(
            status="violated" if found.evaluation.violated else "not violated",
            suite_margin=margin,
            margin=found.evaluation.margin,
            test=start.id,
            runs=found.runs,
            wall_s=round(found.wall_s, 3),
            ended=found.ended,
            id=None,
            replay=None,
            abstract=(),
        )
        return self._kept(requirement, start, found, record) if found.evaluation.violated else (record, None)

    def _search(self, requirement: Requirement, starts: Iterable[TestResult], budget: Budget) -> SearchOutcome:
        def run(test: ConcreteTest) -> Evaluation:
            result = self.rerunning.run(_named(test, requirement))
            if result is None:
                return Evaluation(None, violated=False)
            verdict = result.verdict(requirement.id)
            return Evaluation(verdict.margin, verdict.verdict == "Failed")

        cases = [(self.chosen[start.nodeid], start.requirements[requirement.id]) for start in starts]
        tests = [(case.concrete, Evaluation(judged.margin, violated=False)) for case, judged in cases]
        rng = make_rng(HOW, self.seed, requirement.id)
        return search_violation(tests, cases[0][0].ranges, run, budget, rng)

    def _kept(
        self, requirement: Requirement, start: TestResult, found: SearchOutcome, record: SearchResult
    ) -> tuple[SearchResult, HriCase | None]:
        """The record with the test that was found, which is kept as a replay file."""
        result = self.rerunning.run(_named(found.test, requirement))
        if result is None:
            return record, None
        origin = Origin(HOW, start.id, requirement.id, found.runs)
        made, replay = self.rerunning.keep(self.chosen[start.nodeid], result, start.nodeid, origin)
        return replace(record, id=made.abstract.id, replay=replay, abstract=made.abstract.lines), made


def _named(test: ConcreteTest, requirement: Requirement) -> ConcreteTest:
    return named(test, f"{requirement.id}-{HOW}")


def _objective(result: TestResult, requirement: str) -> tuple[float, str, str]:
    margin = result.requirements[requirement].margin
    return math.inf if margin is None else margin, result.id, result.nodeid


def _without_runs(
    status: Literal["never triggered", "violated by the suite"], margin: float | None = None, test: str | None = None
) -> SearchResult:
    return SearchResult(
        status=status,
        suite_margin=margin,
        margin=margin,
        test=test,
        runs=0,
        wall_s=0.0,
        ended="done",
        id=None,
        replay=None,
        abstract=(),
    )
