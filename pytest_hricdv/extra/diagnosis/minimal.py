"""Minimal tests: the shortest failing test of a cause without what it does not need to fail.

Actions, disturbances, orders of actors and values are taken away by experiment, as `--hri-shrink` does. It goes on to
fail the same requirement; what exactly is violated is not compared, because a cause is more than one violation.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

from pytest_hricdv.execution.case import HriCase
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.shrink import shrink
from pytest_hricdv.extra.diagnosis.runs import Ran, Run, forked
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.results.replay import ReplayOrigin
from pytest_hricdv.session.replaying import TestRerunner, named


@dataclass(frozen=True)
class Minimal:
    """A test that was shrunk.

    Args:
        test: what is left of it.
        ran: its run.
        requirement: that it violates, as the whole test does.
        runs: how many it took.
        is_done: nothing more can be taken away; otherwise the runs were used up.
    """

    test: ConcreteTest
    ran: Ran
    requirement: str
    runs: int
    is_done: bool


def shrunk(test: ConcreteTest, space: Concretization, control: Ran, requirement: str, run: Run, budget: int) -> Minimal:
    """A failing test without what it does not need.

    Args:
        test: that fails.
        space: the ranges of its parameters.
        control: its run.
        requirement: that it violates.
        run: runs a test.
        budget: at most so many runs.

    Raises:
        KeyboardInterrupt: the user pressed Ctrl-C.
    """
    runs = {test.to_json(): control}

    def fails(candidate: ConcreteTest) -> bool:
        result = run(candidate)
        if result is None or requirement not in result.violated:
            return False
        runs[candidate.to_json()] = result
        return True

    outcome = shrink(test, space, fails, Budget(budget))
    if outcome.ended == "interrupted":
        raise KeyboardInterrupt
    return Minimal(outcome.test, runs[outcome.test.to_json()], requirement, outcome.runs, outcome.ended == "done")


def kept(rerunning: TestRerunner, case: HriCase, nodeid: str, minimal: Minimal) -> str | None:
    """Run it once more and keep it as a replay file; returns the file's name, None where there is none.

    Args:
        rerunning: runs tests.
        case: the test that it was made of.
        nodeid: of this.
        minimal: what was left.
    """
    origin = ReplayOrigin("shrunk", case.abstract.id, minimal.requirement, minimal.runs)

    def work() -> Ran | None:
        result = rerunning.run(named(minimal.test, f"{minimal.requirement}-shrunk"))
        return None if result is None else Ran(violated=(), replay=rerunning.keep(case, result, nodeid, origin)[1])

    made = forked(rerunning, work) if hasattr(os, "fork") else work()
    return None if made is None else made.replay
