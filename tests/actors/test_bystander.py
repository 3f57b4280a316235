"""Bystanders: a dog in the corridor, which no plan describes: drawn, recorded, repeated, shrunk away."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.shrink import shrink
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest, concretize
from pytest_hricdv.monitor import load_requirements
from pytest_hricdv.testbench import Bystander, People, Run, Testbench, TestbenchError, Uniform
from pytest_hricdv.testbench_faults import check_testbench
from tests.actors.corridor.bench import Corridor, child, nurse, running, ward

DOG = Bystander("dog", {"bark": {}, "run": {"far_m": Uniform(1.0, 5.0, "m")}}, fewest=1, most=3)
LINES = ("nurse: send_on", "child: step_in", "child: wait")


def dog(run: Run, corridor: Corridor) -> None:
    """What the dog does: it runs in front of the cart, where the sensor does not see it."""
    for action in run.actions("dog"):
        if action.command == "run":
            assert 1.0 <= action.parameters["far_m"] <= 5.0
            run.recorder.signal(run.kernel.now_s, "dog", action.parameters["far_m"])


@cache
def bench() -> Testbench:
    made = replace(ward((nurse, child, dog)), people=People(bystanders=(DOG,)))
    return check_testbench(replace(made, signals={**made.signals, "dog": float}), "tests")


def run(test: ConcreteTest, testbench: Testbench | None = None) -> CaseResult:
    made = testbench or bench()
    return execute(RunSettings(made, load_requirements(made.requirements, made.vocabulary())), test)


def concrete(k: int = 0) -> ConcreteTest:
    return concretize(AbstractTest("t", "s", "t", (), LINES, seed=5), bench().commands, k)


def test_what_it_does_is_drawn_recorded_and_repeated() -> None:
    for k in range(3):
        result = run(concrete(k))
        acts = DOG.acts_of(concrete(k).run)
        assert [act for _, act in result.bystander_events] == [f"dog: {act}" for _, act, _ in acts]
        assert result.bystander_events[0][0] == pytest.approx(acts[0][0], abs=1e-5)
        assert run(concrete(k)).record.sha256 == result.record.sha256
    assert len({str(DOG.acts_of(concrete(k).run)) for k in range(3)}) == 3


def test_shrinking_leaves_it_as_little_as_it_may_do() -> None:
    test = concrete(1)
    shrunk = shrink(test, bench().commands, lambda other: other.actions[:1] == test.actions[:1], Budget(500, 60.0)).test
    assert shrunk.run["dog_acts"] == 1.0
    assert [act for _, act, _ in DOG.acts_of(shrunk.run)] == ["bark"]


def test_a_bystander_whom_no_node_enacts_is_a_fault() -> None:
    assert run(concrete()).errors == ()
    (fault,) = run(concrete(), replace(bench(), run=running((nurse, child)))).errors
    assert fault.startswith("no node enacts the actions of dog: expected a node of the testbench's run")


@pytest.mark.parametrize(
    ("bystander", "complaint"),
    [
        (Bystander("nurse", {"walk": {}}), "bystander 'nurse': another actor has this name; rename one of them"),
    ],
)
def test_names_that_are_taken_are_refused(bystander: Bystander, complaint: str) -> None:
    made = replace(ward(), people=People(bystanders=(bystander,)))
    with pytest.raises(TestbenchError, match=complaint):
        check_testbench(made, "tests")


@pytest.mark.parametrize(
    ("declared", "complaint"),
    [
        ({"name": "The dog", "acts": {"walk": {}}}, "name is 'The dog'; expected one of small letters, such as 'dog'"),
        ({"name": "dog", "acts": {}}, "acts are []; expected one word each"),
        ({"name": "dog", "acts": {"lie down": {}}}, "acts are ['lie down']; expected one word each"),
        ({"name": "dog", "acts": {"walk": {}}, "fewest": 3, "most": 2}, "3 to 2 acts; expected 0 <= fewest <= most"),
        ({"name": "dog", "acts": {"walk": {"far_m": 3.0}}}, "3.0 is not a Uniform, Sometimes or Constant"),
        ({"name": "dog", "acts": {"walk": {}}, "pause_s": 3.0}, "3.0 is not a Uniform, Sometimes or Constant"),
    ],
)
def test_a_declaration_that_is_none_is_refused(declared: dict[str, object], complaint: str) -> None:
    with pytest.raises(GenerateError) as refused:
        Bystander(**declared)  # type: ignore[arg-type]
    assert complaint in str(refused.value)
