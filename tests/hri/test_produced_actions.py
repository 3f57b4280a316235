"""Actions that are produced while the run goes on: the run is stored as an ordinary test, which is the same run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, abstract_from, concretize
from pytest_hricdv.run import Actions, Run
from tests.hri import bench


def kinematic() -> RunSettings:
    return RunSettings(bench.testbench().choose(fidelity="kinematic"), bench.requirements())


def produced(test: ConcreteTest, producing: Actions) -> CaseResult:
    return execute(kinematic(), test, producing=producing)


def test_a_run_with_produced_actions_is_stored_as_a_test_that_is_the_same_run() -> None:
    source = bench.concrete([*bench.leg("101"), "tell leg", "receivesignal", "bored"])
    asked_s: list[float] = []

    def producing(run: Run, actor: str) -> Iterator[ConcreteAction]:
        for action in source.actions:
            asked_s.append(run.kernel.now_s)
            yield action

    found = produced(replace(source, actions=()), producing)
    assert found.test == source
    assert tuple(asked_s) == found.action_times_s
    assert asked_s[1] > 0.0

    stored = concretize(abstract_from(found.test, "produced"), bench.testbench().concretization)
    again = produced(stored, lambda run, actor: iter(run.test.actions))
    fixed = execute(kinematic(), stored)
    assert again.record.sha256 == fixed.record.sha256 == found.record.sha256
    assert fixed.outcome == found.outcome
    assert fixed.cross == found.cross
    assert fixed.cross["handover"]
    assert fixed.action_times_s == found.action_times_s
