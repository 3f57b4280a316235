"""Causes that one repair mends are one."""

from __future__ import annotations

from typing import Any, cast

import pytest

from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import Group, Spectra, grouped
from pytest_hricdv.extra.diagnosis.hints import Hint
from pytest_hricdv.extra.diagnosis.locating import Locating
from pytest_hricdv.extra.diagnosis.repairs import Repair
from pytest_hricdv.extra.diagnosis.runs import Ran
from pytest_hricdv.generate.concrete import ConcreteTest
from tests.report import sample

REPAIR = Repair("robot.py", 3, "act", "left out", "without `x`", "")
TESTS = {name: ConcreteTest(name, "suite", 1, (), {}) for name in ("a", "b", "c")}
FAILURES = [
    Failure(name, requirement, "", "", 1.0, (), is_known=False)
    for name, requirement in (("a", "R1"), ("b", "R2"), ("c", "R3"))
]
RESULT = sample.report(tests=1).tests[0]


def groups_of(experiments: Experiments) -> tuple[Group, ...]:
    tests: dict[str, tuple[str, ...]] = dict.fromkeys((*TESTS, "passing"), ())
    return grouped(tests, FAILURES, Spectra(), experiments.evidence)


def robot(repair: Repair, test: ConcreteTest) -> Ran:
    """With the repair, all but the test c pass."""
    return Ran(violated=("R3",) if test.id == "c" else (), checked=("R1", "R2"))


@pytest.mark.parametrize(("budget", "unchanged", "left"), [(9, 1, 2), (9, 0, 3), (0, 1, 3)])
def test_causes_that_one_repair_mends_are_one(budget: int, unchanged: int, left: int) -> None:
    experiments = Experiments(lambda evidence: (), TESTS, lambda test: None, budget)
    locating = Locating(cast("Any", None), experiments, Spectra(), dict.fromkeys(TESTS, RESULT), robot)
    groups = groups_of(experiments)
    assert len(groups) == 3
    first = next(number for number, group in enumerate(groups) if group.nodeids == ("a",))
    hints = [[Hint(REPAIR, 1, unchanged)] if number == first else [] for number in range(3)]
    experiments.mended += locating.joined(groups, hints)
    assert experiments.used == (2 if budget and unchanged else 0)
    assert len(groups_of(experiments)) == left
    assert {entry.nodeid for entry in experiments.mended} == ({"a", "b"} if left == 2 else set())
