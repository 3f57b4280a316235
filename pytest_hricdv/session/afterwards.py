"""What a session does when all tests have run, where it was asked to: shrink failures, search for violations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.case import HriCase
from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.search.budget import Budget
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.rerunning import Rerunning
from pytest_hricdv.session.searching import Searching
from pytest_hricdv.session.shrinking import Shrinking, worst


@dataclass
class Afterwards:
    """Shrinks and searches; stops at Ctrl-C, with what it has.

    Args:
        rerunning: runs tests.
        options: of the session.
        chosen: node id -> test, of the session.
        say: told what is going on.
    """

    rerunning: Rerunning
    options: Options
    chosen: Mapping[str, HriCase]
    say: Callable[[str], None]
    interrupted: bool = field(default=False, init=False)
    problems: list[str] = field(default_factory=list, init=False)
    """Violations that were found and are not known."""

    def shrink(self, entries: Iterable[Entry]) -> None:
        """Shrink the shortest failure of each requirement; adds `shrunk` to its entry."""
        requirements = {requirement.id: requirement for requirement in self.rerunning.requirements}
        for name, entry in worst(entries, requirements.values()).items():
            if not self.interrupted:
                told = self._shrunk(requirements[name], self.chosen[entry["nodeid"]], entry["nodeid"])
                entry.setdefault("shrunk", {})[name] = told

    def _shrunk(self, requirement: Requirement, case: HriCase, nodeid: str) -> dict[str, Any]:
        self.say(f"hricdv: shrinking {case.abstract.id}, which failed {requirement.id} ...")
        budget = Budget(self.options.shrink_runs, self.options.shrink_seconds)
        told = Shrinking(self.rerunning, requirement, case, nodeid).shrink(budget)
        self.interrupted = told["ended"] == "interrupted"
        return told

    def search(self, entries: Iterable[Entry]) -> dict[str, Any]:
        """Search for a violation of each requirement; returns the report's `search`."""
        entries = list(entries)
        searching = Searching(self.rerunning, self.chosen, self.options.seed)
        found = {}
        for requirement in self.rerunning.requirements:
            if self.interrupted:
                break
            self.say(f"hricdv: searching for a violation of {requirement.id} ...")
            told, made = searching.search(requirement, entries, Budget(self.options.search))
            self.interrupted = told["ended"] == "interrupted"
            found[requirement.id] = told
            if told["status"] == "violated" and (self.options.strict or requirement.id not in self.options.known):
                self.problems.append(f"{requirement.id} is violated by a test that a search found: {told['id']}")
            if made is not None and self.options.shrink and not self.interrupted:
                told["shrunk"] = self._shrunk(requirement, made, made.abstract.id)
        return found
