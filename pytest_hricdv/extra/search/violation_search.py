"""`ViolationSearch`: searches for violations by varying the tests that came closest to violating a requirement.

`PostSession` uses it for `--hri-search`, with `experiments.evolution_strategy`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

from msgspec.structs import replace

from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.evolution_strategy import Evaluation, SearchOutcome, search_violation
from pytest_hricdv.extra.search.records import SearchResult
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.monitor import Criterion, RequirementResult
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.replay import ReplayOrigin
from pytest_hricdv.session.replaying import TestRerunner, name_test

SEARCH: Final = "search"
STARTS = 5
"""Number of tests to vary, the closest: many would get too few runs each; a single one may be a dead end."""


@dataclass(frozen=True)
class ViolationSearch:
    """Searches for violations in addition to a suite: varies the tests that came nearest to violating a requirement.

    The suite has checked its own tests already, so every run of a search is a new test. A requirement that the suite
    itself violates needs no search; a requirement that no test triggers has no margin to follow.

    Args:
        chosen: node id -> test, of the session.
        judged: runs a test elsewhere, and says what became of a requirement; None: tests run here.
    """

    rerunner: TestRerunner
    chosen: Mapping[str, HriCase]
    seed: int
    judged: Callable[[ConcreteTest, str], RequirementResult | None] | None = None

    def search(
        self, requirement: Criterion, results: Iterable[TestResult], budget: Budget
    ) -> tuple[SearchResult, HriCase | None]:
        """Search for one requirement.

        Returns:
            The record for the report, and the test that violates the requirement where one was outcome.
        """
        results = sorted(results, key=lambda result: _objective(result, requirement.id))
        triggered = [result for result in results if result.requirements[requirement.id].triggers]
        if not triggered:
            return _without_runs("never triggered"), None
        margin = triggered[0].requirements[requirement.id].margin
        if any(self._is_violated(requirement, result.requirements[requirement.id]) for result in triggered):
            return _without_runs("violated by the suite", margin, triggered[0].id), None
        starts = triggered[:STARTS]
        outcome = self._search(requirement, starts, budget)
        start = starts[outcome.start]
        record = SearchResult(
            status="violated" if outcome.evaluation.violated else "not violated",
            suite_margin=margin,
            margin=outcome.evaluation.margin,
            test=start.id,
            runs=outcome.runs,
            wall_s=round(outcome.wall_s, 3),
            end_reason=outcome.ended,
            id=None,
            replay=None,
            abstract=(),
        )
        return self._keep(requirement, start, outcome, record) if outcome.evaluation.violated else (record, None)

    def _search(self, requirement: Criterion, starts: Iterable[TestResult], budget: Budget) -> SearchOutcome:
        def run(test: ConcreteTest) -> Evaluation:
            verdict = self._judge(_rename(test, requirement), requirement.id)
            if verdict is None:
                return Evaluation(None, violated=False)
            return Evaluation(verdict.margin, self._is_violated(requirement, verdict))

        cases = [(self.chosen[start.nodeid], start.requirements[requirement.id]) for start in starts]
        tests = [(case.concrete, Evaluation(judged.margin, violated=False)) for case, judged in cases]
        rng = make_rng(SEARCH, self.seed, requirement.id)
        return search_violation(tests, cases[0][0].ranges, run, budget, rng)

    def _judge(self, test: ConcreteTest, requirement: str) -> RequirementResult | None:
        if self.judged is not None:
            return self.judged(test, requirement)
        result = self.rerunner.run(test)
        return None if result is None else result.verdict(requirement)

    def _is_violated(self, requirement: Criterion, result: RequirementResult) -> bool:
        return self.rerunner.is_violated(requirement.id, result)

    def _keep(
        self, requirement: Criterion, start: TestResult, outcome: SearchOutcome, record: SearchResult
    ) -> tuple[SearchResult, HriCase | None]:
        """The record with the test that was outcome, which is kept as a replay file."""
        try:
            result = self.rerunner.run(_rename(outcome.test, requirement))
        except KeyboardInterrupt:  # that it is violated is known, and the test is not
            return replace(record, end_reason="interrupted"), None
        if result is None:
            return record, None
        origin = ReplayOrigin(SEARCH, start.id, requirement.id, outcome.runs)
        made, replay = self.rerunner.keep(self.chosen[start.nodeid], result, start.nodeid, origin)
        return replace(record, id=made.abstract.id, replay=replay, abstract=made.abstract.lines), made


def _rename(test: ConcreteTest, requirement: Criterion) -> ConcreteTest:
    return name_test(test, f"{requirement.id}-{SEARCH}")


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
        end_reason="done",
        id=None,
        replay=None,
        abstract=(),
    )
