"""Shrinking: when all tests have run, the shortest failing one of each requirement is made as short as possible.

One process does it at the end, not each worker when a test fails: so the result does not depend on how tests were
distributed over workers, and no requirement is shrunk twice.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pytest_hricdv.case import CaseResult, HriCase
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.results.model import ShrunkTest, TestResult
from pytest_hricdv.search import Budget
from pytest_hricdv.search.replay import Origin
from pytest_hricdv.search.shrink import FailureSignature, Shrunk, failure_signature, has_signature, shrink
from pytest_hricdv.session.replaying import Rerunning, named

HOW = "shrunk"
ELSEWHERE = "it did not fail again outside of its test function: does a fixture change what the run depends on?"


def shortest_failures(results: Iterable[TestResult], requirements: Iterable[Requirement]) -> dict[str, TestResult]:
    """Requirement -> the shortest test that failed it, by actions and then by id; where one did."""
    found = {}
    by_length = sorted(results, key=lambda result: (len(result.abstract), result.id, result.nodeid))
    for requirement in requirements:
        failed = (result for result in by_length if result.requirements[requirement.id].verdict == "Failed")
        if (result := next(failed, None)) is not None:
            found[requirement.id] = result
    return found


@dataclass
class Shrinking:
    """Shrinks one failure: a test, and the requirement that it failed.

    Args:
        rerunning: runs tests.
        requirement: that failed.
        case: the test that failed it.
        nodeid: of the pytest item that ran it.
    """

    rerunning: Rerunning
    requirement: Requirement
    case: HriCase
    nodeid: str

    def __post_init__(self) -> None:
        self._wanted: FailureSignature | None = None
        self._best: CaseResult | None = None

    def shrink(self, budget: Budget) -> ShrunkTest:
        """Shrink it; keeps the result as a replay file."""
        try:
            if budget.runs > 0:
                budget.spend()
                self._learn_reason()
        except KeyboardInterrupt:
            return self._record(Shrunk(self.case.concrete, budget.used, budget.elapsed_s, "interrupted"))
        if self._best is None:
            return self._record(Shrunk(self.case.concrete, budget.used, budget.elapsed_s, "done"), ELSEWHERE)
        return self._record(shrink(self.case.concrete, self.case.ranges, self._fails, budget))

    def _learn_reason(self) -> None:
        result = self._run(self.case.concrete)
        verdict = result and result.verdict(self.requirement.id)
        if verdict and verdict.violations:
            self._wanted = failure_signature(self.requirement, verdict.violations[0])
            self._best = result

    def _fails(self, test: ConcreteTest) -> bool:
        result = self._run(test)
        if result is None or self._wanted is None:
            return False
        same = has_signature(self.requirement, self._wanted, result.verdict(self.requirement.id))
        if same:
            self._best = result
        return same

    def _run(self, test: ConcreteTest) -> CaseResult | None:
        # Under the id that the test will have: a run is a function of all of its test.
        return self.rerunning.run(named(test, f"{self.requirement.id}-{HOW}"))

    def _record(self, found: Shrunk, note: str = "") -> ShrunkTest:
        made, replay = None, None
        if self._best is not None and found.test != self.case.concrete:
            origin = Origin(HOW, self.case.abstract.id, self.requirement.id, found.runs)
            made, replay = self.rerunning.keep(self.case, self._best, self.nodeid, origin)
        return ShrunkTest(
            id=None if made is None else made.abstract.id,
            replay=replay,
            abstract=tuple(action.command for action in found.test.actions),
            concrete=tuple(self.case.ranges.shown(found.test)),
            actions_before=len(self.case.concrete.actions),
            runs=found.runs,
            wall_s=round(found.wall_s, 3),
            ended=found.ended,
            reason=tuple(self._wanted or ()),
            note=note,
        )
