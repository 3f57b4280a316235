"""What a session does when all tests have run, where it was asked to: shrink failures, search for violations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from msgspec.structs import replace

from pytest_hricdv.case import HriCase
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.results.model import SearchResult, ShrunkTest, TestResult
from pytest_hricdv.search import Budget
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.replaying import Rerunning
from pytest_hricdv.session.searching import Searching
from pytest_hricdv.session.shrinking import Shrinking, shortest_failures


@dataclass
class PostSession:
    """Shrinks and searches; stops at Ctrl-C, and keeps what was found until then.

    Args:
        rerunning: runs tests.
        options: of the session.
        chosen: node id -> test, of the session.
        say: receives progress messages.
    """

    rerunning: Rerunning
    options: Options
    chosen: Mapping[str, HriCase]
    say: Callable[[str], None]
    interrupted: bool = field(default=False, init=False)
    problems: list[str] = field(default_factory=list, init=False)
    """Violations that were found and are not known."""

    def shrink(self, results: Iterable[TestResult]) -> list[TestResult]:
        """Shrink the shortest failure of each requirement; returns the results, with what they were shrunk to."""
        requirements = {requirement.id: requirement for requirement in self.rerunning.requirements}
        by_nodeid = {result.nodeid: result for result in results}
        for name, failed in shortest_failures(by_nodeid.values(), requirements.values()).items():
            if not self.interrupted:
                shrunk = self._shrunk(requirements[name], self.chosen[failed.nodeid], failed.nodeid)
                result = by_nodeid[failed.nodeid]
                by_nodeid[failed.nodeid] = replace(result, shrunk={**result.shrunk, name: shrunk})
        return [*by_nodeid.values()]

    def _shrunk(self, requirement: Requirement, case: HriCase, nodeid: str) -> ShrunkTest:
        self.say(f"hricdv: shrinking {case.abstract.id}, which failed {requirement.id} ...")
        budget = Budget(self.options.shrink_runs, self.options.shrink_seconds)
        shrunk = Shrinking(self.rerunning, requirement, case, nodeid).shrink(budget)
        self.interrupted = shrunk.ended == "interrupted"
        return shrunk

    def search(self, results: Iterable[TestResult]) -> dict[str, SearchResult]:
        """Search for a violation of each requirement."""
        results = list(results)
        searching = Searching(self.rerunning, self.chosen, self.options.seed)
        found = {}
        for requirement in self.rerunning.requirements:
            if self.interrupted:
                break
            self.say(f"hricdv: searching for a violation of {requirement.id} ...")
            record, made = searching.search(requirement, results, Budget(self.options.search))
            self.interrupted = record.ended == "interrupted"
            if record.status == "violated" and (self.options.strict or requirement.id not in self.options.known):
                self.problems.append(f"{requirement.id} is violated by a test that a search found: {record.id}")
            if made is not None and self.options.shrink and not self.interrupted:
                record = replace(record, shrunk=self._shrunk(requirement, made, made.abstract.id))
            found[requirement.id] = record
        return found
