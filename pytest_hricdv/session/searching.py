"""Searching: when all tests have run, the ones that came nearest to violating a requirement are varied to come nearer.

The suite has judged its own tests already, so every run of a search is spent on a new one. A requirement that the suite
itself violates needs none; one that no test triggers cannot be steered towards.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.case import HriCase
from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.search.budget import Budget
from pytest_hricdv.search.evolution_strategy import Evaluation, SearchResult, search_violation
from pytest_hricdv.search.replay import Origin
from pytest_hricdv.session.rerunning import Rerunning, named

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
        self, requirement: Requirement, entries: Iterable[Entry], budget: Budget
    ) -> tuple[dict[str, Any], HriCase | None]:
        """Search for one requirement.

        Returns:
            What the report has of it, and the test that violates it where one was found.
        """
        entries = sorted(entries, key=lambda entry: _objective(entry, requirement.id))
        triggered = [entry for entry in entries if entry["requirements"][requirement.id]["triggers"]]
        if not triggered:
            return _told("never triggered"), None
        nearest = triggered[0]
        verdict = nearest["requirements"][requirement.id]
        if any(entry["requirements"][requirement.id]["verdict"] == "Failed" for entry in triggered):
            return _told("violated by the suite", suite_margin=verdict["margin"], test=nearest["id"]), None
        starts = triggered[:STARTS]
        found = self._search(requirement, starts, budget)
        told = _told(
            "violated" if found.evaluation.violated else "not violated",
            suite_margin=verdict["margin"],
            margin=found.evaluation.margin,
            test=starts[found.start]["id"],
            runs=found.runs,
            wall_s=round(found.wall_s, 3),
            ended=found.ended,
        )
        if not found.evaluation.violated:
            return told, None
        return told, self._keep(requirement, starts[found.start], found, told)

    def _search(self, requirement: Requirement, starts: Iterable[Entry], budget: Budget) -> SearchResult:
        def run(test: ConcreteTest) -> Evaluation:
            result = self.rerunning.run(_named(test, requirement))
            if result is None:
                return Evaluation(None, violated=False)
            verdict = result.verdict(requirement.id)
            return Evaluation(verdict.margin, verdict.verdict == "Failed")

        cases = [(self.chosen[entry["nodeid"]], entry["requirements"][requirement.id]) for entry in starts]
        tests = [(case.concrete, Evaluation(verdict["margin"], violated=False)) for case, verdict in cases]
        rng = make_rng(HOW, self.seed, requirement.id)
        return search_violation(tests, cases[0][0].ranges, run, budget, rng)

    def _keep(
        self, requirement: Requirement, start: Entry, found: SearchResult, told: dict[str, Any]
    ) -> HriCase | None:
        result = self.rerunning.run(_named(found.test, requirement))
        if result is None:
            return None
        origin = Origin(HOW, start["id"], requirement.id, found.runs)
        made, told["replay"] = self.rerunning.keep(self.chosen[start["nodeid"]], result, start["nodeid"], origin)
        told["id"], told["abstract"] = made.abstract.id, list(made.abstract.lines)
        return made


def _named(test: ConcreteTest, requirement: Requirement) -> ConcreteTest:
    return named(test, f"{requirement.id}-{HOW}")


def _objective(entry: Entry, requirement: str) -> tuple[float, str, str]:
    margin = entry["requirements"][requirement]["margin"]
    return math.inf if margin is None else margin, entry["id"], entry["nodeid"]


def _told(status: str, **known: Any) -> dict[str, Any]:
    nothing = {"suite_margin": None, "margin": known.get("suite_margin"), "test": None, "runs": 0, "wall_s": 0.0}
    return {"status": status, **nothing, "ended": "done", "id": None, "replay": None, "abstract": [], **known}
