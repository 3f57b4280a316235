"""Failing tests are run again without what they are thought to fail for."""

from __future__ import annotations

import pytest

from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group, group_failures
from pytest_hricdv.extra.diagnosis.pair_search import PairSearch
from pytest_hricdv.extra.diagnosis.records import Neighbour
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.extra.diagnosis.spectrum import Spectra
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization


def concrete(name: str, *commands: str) -> ConcreteTest:
    return ConcreteTest(name, "suite", 0, tuple(ConcreteAction(command) for command in commands))


TESTS = {
    "a": concrete("a", "disturb noise", "go", "disturb shut"),
    "b": concrete("b", "disturb noise", "go", "go", "disturb shut"),
}
DISTURBANCES = {"a": ("noise", "shut"), "b": ("noise", "shut")}
FAILURES = [Failure(name, "R1", "", "", 1.0, ("noise", "shut"), is_known=False) for name in TESTS]


def robot(test: ConcreteTest) -> RunSummary:
    """Its R1 fails whenever there is noise, whatever else comes."""
    return RunSummary(violated=("R1",) if any(action.command == "disturb noise" for action in test.actions) else ())


def groups_of(evidence: ExperimentEvidence) -> tuple[Group, ...]:
    return group_failures(DISTURBANCES, FAILURES, Spectra(), evidence)


def test_a_refuted_change_gives_way_to_the_next() -> None:
    experiments = Experiments(groups_of, TESTS, robot, budget=10)
    [group] = experiments.groups()
    assert (group.change, group.nodeids) == ("noise", ("a", "b"))
    assert experiments.ended == "done"
    assert experiments.confirmed == {("a", "R1"): "noise", ("b", "R1"): "noise"}
    assert experiments.refuted == {("a", "R1"): {"shut"}}  # and so it is no longer thought of b


@pytest.mark.parametrize(("budget", "changes"), [(0, [""]), (9, ["", "shut"])])
def test_what_may_go_with_failures_by_chance_is_tried(budget: int, changes: list[str]) -> None:
    """Of five tests, two fail: one for a disturbance, one without. Without experiments, nothing tells them apart."""
    tests = {"a": concrete("a", "disturb shut"), "b": concrete("b", "go")}
    disturbances: dict[str, tuple[str, ...]] = {"a": ("shut",), "b": (), **{f"passing{n}": () for n in range(3)}}
    failures = [Failure(name, "R1", "", "", 1.0, disturbances[name], is_known=False) for name in tests]

    def grouping(evidence: ExperimentEvidence) -> tuple[Group, ...]:
        return group_failures(disturbances, failures, Spectra(), evidence)

    def run(test: ConcreteTest) -> RunSummary:
        return RunSummary(violated=("R1",) if test.actions else ())

    assert sorted(group.change for group in Experiments(grouping, tests, run, budget).groups()) == changes


def test_the_budget_ends_them() -> None:
    experiments = Experiments(groups_of, TESTS, robot, budget=2)
    experiments.groups()
    assert (experiments.used, experiments.ended) == (2, "runs")


def test_ctrl_c_keeps_what_was_shown() -> None:
    runs: list[ConcreteTest] = []

    def run(test: ConcreteTest) -> RunSummary:
        runs.append(test)
        if len(runs) == 3:
            raise KeyboardInterrupt
        return robot(test)

    experiments = Experiments(groups_of, TESTS, run, budget=10)
    assert experiments.groups()
    assert experiments.ended == "interrupted"
    assert experiments.refuted


@pytest.mark.parametrize("budget", range(3, 20))
def test_the_run_of_the_neighbour_that_is_shown_is_one_of_those_allowed(budget: int) -> None:
    made: list[ConcreteTest] = []

    def run(test: ConcreteTest) -> RunSummary:
        made.append(test)
        ran = robot(test)
        return ran if ran.violated else RunSummary(violated=(), checked=("R1",))

    def neighbour_runner(test: ConcreteTest) -> Neighbour | None:
        made.append(test)
        return None

    experiments = Experiments(groups_of, TESTS, run, budget)
    groups = experiments.groups()
    before = len(made)
    space = Concretization(commands={"go": {}})
    decisions = PairSearch(experiments, dict.fromkeys(TESTS, space), neighbour_runner)
    decisions.decide(groups)
    assert experiments.used == len(made) <= budget
    if budget > before:
        assert [decision.words for decision in decisions.made.values()] == ["without the disturbance noise"]
