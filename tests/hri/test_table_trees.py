"""Trees of the table's tests: what a test does in one is what it does from the start, wherever it parts."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cache

import pytest

from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.extra.closing.branching import Leaf, may_fork
from pytest_hricdv.extra.closing.tree_runner import TreeRunner
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.results.codec import encode
from pytest_hricdv.run import Actions
from tests.hri import bench


@cache
def measurement() -> Measurement:
    return choose(map_code(bench.testbench().code, bench.ROOT), contexts_by_test=False)


def concrete(lines: Sequence[str], seed: int) -> ConcreteTest:
    return concretize(AbstractTest("test", "tests", "a test", (), tuple(lines), seed=seed), bench.testbench().commands)


def runner(fidelity: str) -> TreeRunner[CaseResult]:
    """Runs tests on two processes; what is loaded once has been loaded, so that no fork has to."""
    table = RunSettings(bench.testbench().simulated(fidelity), bench.requirements(), measurement=measurement())

    def executed(test: ConcreteTest, actions: Actions) -> CaseResult:
        return execute(table, test, "tree", producing=actions)

    executed(concrete(["tell leg"], seed=1), lambda run: iter(run.test.actions))
    return TreeRunner(executed, _facts, 2, 60.0)


def _facts(leaf: Leaf[CaseResult]) -> str:
    """What equal runs have in common."""
    result = leaf.result
    if result is None:
        return leaf.problem
    code = None if result.code is None else [result.code.statements, result.code.branches]
    verdicts = [encode(verdict.result) for verdict in result.verdicts]
    found = [result.record.sha256, verdicts, code, result.cross, result.acted_s, result.sim_s, result.faults]
    return json.dumps([*found, result.test.to_json()])


@pytest.mark.parametrize(
    ("fidelity", "begun", "instead"),
    [
        ("kinematic", bench.leg("111"), bench.leg("010")),
        ("kinematic", ["tell leg", "disturb request_doubled", *bench.leg("111")[1:]], ["disturb ready_lost", "bored"]),
        ("dynamic", ["tell leg", "disturb hand_held_shut", "receivesignal"], ["disturb leg_taken", "bored"]),
    ],
    ids=["undisturbed", "messages disturbed", "hand and leg disturbed"],
)
def test_wherever_tests_part_each_does_what_it_does_from_the_start(
    fidelity: str, begun: list[str], instead: list[str]
) -> None:
    tests = [concrete([*begun[:place], *instead], seed=5) for place in range(1, len(begun) + 1)]
    tests.append(concrete(begun, seed=5))
    table = runner(fidelity)
    together, alone = dict(table.run(tests)), dict(table.run(tests, from_the_start=True))
    for number, test in enumerate(tests):
        assert together[number] == alone[number]
        assert test.to_json() in json.loads(alone[number])
    assert len(set(alone.values())) == len(tests)


def test_where_there_is_no_fork_all_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    tests = [concrete(["tell leg", *rest], seed=6) for rest in (bench.leg()[1:], ["disturb leg_taken"], ["bored"])]
    table = runner("kinematic")
    together = dict(table.run(tests))
    monkeypatch.delattr(os, "fork")
    assert dict(table.run(tests)) == together
    assert not may_fork()
