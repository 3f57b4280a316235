"""Trees of the table's tests: what a test does in one is what it does from the start, wherever it parts."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import pytest

from pytest_hricdv.case import CaseResult, execute
from pytest_hricdv.close.branching import Leaf
from pytest_hricdv.close.tree_runner import TreeRunner
from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.coverage.measurement import Measurement, choose
from pytest_hricdv.disturbance import Doubled, Late, Lost
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.run import Actions
from pytest_hricdv.testbench import Range, Testbench
from tests.hri import bench

DISTURBANCES = {
    "ready_lost": Lost("human_ready"),
    "offer_late": Late("leg_ready", delay_s=Range(1.0, 4.0, "s")),
    "request_doubled": Doubled("request", delay_s=Range(5.0, 20.0, "s")),
}


@cache
def table() -> Testbench:
    """The table, quick, with disturbances of messages beside its own."""
    quick = bench.testbench().simulated("kinematic")
    return replace(quick, disturbances={**quick.disturbances, **DISTURBANCES})


@cache
def measurement() -> Measurement:
    return choose(map_code(table().code, bench.ROOT), contexts_by_test=False)


def concrete(lines: Sequence[str], seed: int) -> ConcreteTest:
    return concretize(AbstractTest("test", "tests", "a test", (), tuple(lines), seed=seed), table().commands)


def _execute(test: ConcreteTest, actions: Actions) -> CaseResult:
    measured = measurement()
    return execute(table(), bench.requirements(), test, measured, "tree", producing=actions)


def _facts(leaf: Leaf[CaseResult]) -> str:
    """What equal runs have in common."""
    result = leaf.result
    if result is None:
        return leaf.problem
    code = None if result.code is None else [result.code.statements, result.code.branches]
    verdicts = [verdict.to_json() for verdict in result.verdicts]
    found = [result.record.sha256, verdicts, code, result.cross, result.acted_s, result.sim_s, result.faults]
    return json.dumps([*found, result.test.to_json()])


@pytest.mark.parametrize(
    ("begun", "instead"),
    [
        (bench.leg("111"), bench.leg("010")),
        (["tell leg", "disturb request_doubled", *bench.leg("111")[1:]], ["disturb ready_lost", *bench.leg("111")]),
        (["tell leg", "disturb offer_late", *bench.leg("101")[1:], "bored"], [*bench.leg("111"), "bored"]),
    ],
    ids=["undisturbed", "disturbed", "bored"],
)
def test_wherever_tests_part_each_does_what_it_does_from_the_start(begun: list[str], instead: list[str]) -> None:
    tests = [concrete([*begun[:place], *instead], seed=5) for place in range(1, len(begun) + 1)]
    tests.append(concrete(begun, seed=5))
    _execute(tests[-1], lambda run: iter(tests[-1].actions))  # what is loaded once, no fork has to load
    runner = TreeRunner(_execute, _facts, 2, 60.0)
    together = dict(runner.run(tests))
    alone = dict(runner.run(tests, from_the_start=True))
    for number, test in enumerate(tests):
        assert together[number] == alone[number]
        assert test.to_json() in json.loads(alone[number])
    assert len(set(alone.values())) > len(tests) / 2
