"""The closure of tests: what they cover together, which of them are enough for it, and what is still open."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from typing import Any

from pytest_hricdv.cover.gain import Measured, grown, smallest, unique
from pytest_hricdv.cover.points import Points

Plain = dict[str, Any]
Runs = Callable[[Plain], Iterable[Plain]]


def gains(points: Points, tests: Sequence[Plain], runs: Runs) -> Plain:
    """What each test is worth, as the report has it.

    Returns:
        `points`: how many are covered. `minimal`: tests that are enough for all of them, in the order in which they add
        most per simulated second: `nodeid`, `id`, `gain` (points new with it), `points` and `sim_s` up to it.
        `adds_nothing`: node ids of the others. `unique`: node id -> points that only this test covers, if any.
        `growth`: [simulated s, points] of the tests as they come, at each that adds some. `sim_s`: of all tests.
    """
    measured = [Measured(test["nodeid"], points.of(runs(test)), test["sim_s"] or 0.0) for test in tests]
    steps = smallest(measured)
    ids = {test["nodeid"]: test["id"] for test in tests}
    enough = {step.name for step in steps}
    ran = [test["nodeid"] for test in tests if test["outcome"] != "not-run"]
    total = reduce(lambda covered, test: covered | test.points, measured, 0)
    return {
        "points": total.bit_count(),
        "sim_s": round(sum(test.cost_s for test in measured), 6),
        "growth": [list(step) for step in grown(measured)],
        "minimal": [
            {"nodeid": step.name, "id": ids[step.name], "gain": step.gain, "points": step.points, "sim_s": step.cost_s}
            for step in steps
        ],
        "adds_nothing": [nodeid for nodeid in ran if nodeid not in enough],
        "unique": unique(measured),
    }
