"""The kinematic world: equal legs, messages and verdicts where only plans and logic matter; named in every report."""

from __future__ import annotations

import pytest

import conftest
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.report import html, junit
from pytest_hricdv.results.report_builder import build_result
from sim.engine import SimulationError
from tests.hri import bench
from tests.report import sample
from tests.report.parsed import Page, details

RELEASED = bench.concrete([*bench.leg("111"), *bench.leg("011")], seed=7)
BORED = bench.concrete(["tell leg", "receivesignal", "bored", *bench.leg("101")], seed=8)
FOUR = bench.concrete(bench.leg() * 4, seed=4)


def kinematic(test: ConcreteTest, monkeypatch: pytest.MonkeyPatch) -> CaseResult:
    """Run a test without dynamics."""
    with monkeypatch.context() as patch:
        patch.setattr(conftest, "FIDELITY", "kinematic")
        return bench.run(test)


def story(result: CaseResult) -> list[tuple[str, str]]:
    """What is said and done, without the times."""
    messages = [message for message in result.record.messages if message.topic != "table_done"]
    asking = [message for message in messages if message.fields.get("name") not in ("Receive1", "Timeout1")]
    return [(message.topic, str(dict(message.fields))) for message in asking]


@pytest.mark.parametrize("test", [RELEASED, BORED, FOUR], ids=["two legs", "bored", "four legs"])
def test_the_story_and_the_verdicts_are_those_of_the_dynamic_world(
    test: ConcreteTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    dynamic, plans_only = bench.run(test), kinematic(test, monkeypatch)
    assert plans_only.outcome.outcomes == dynamic.outcome.outcomes
    assert plans_only.outcome.ended == dynamic.outcome.ended
    assert [each.verdict for each in plans_only.verdicts] == [each.verdict for each in dynamic.verdicts]
    assert story(plans_only) == story(dynamic)
    assert plans_only.sim_s == pytest.approx(dynamic.sim_s, rel=0.05)  # its joints need no time to settle
    assert max(plans_only.record.signals["arm_speed"][1]) == pytest.approx(0.24, abs=1e-3)


def test_a_kinematic_run_is_the_same_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assert kinematic(BORED, monkeypatch).record.sha256 == kinematic(BORED, monkeypatch).record.sha256


@pytest.mark.slow
def test_the_fidelity_is_in_every_report(monkeypatch: pytest.MonkeyPatch) -> None:
    abstract = AbstractTest(BORED.id, BORED.suite, "a test", (), tuple(action.command for action in BORED.actions))
    case = HriCase(BORED.suite, abstract, bench.testbench().concretization, fixed=BORED)
    for fidelity, run in {"kinematic": kinematic(BORED, monkeypatch), "dynamic": bench.run(BORED)}.items():
        assert build_result(case, "", run, requirements=bench.requirements()).fidelity == fidelity
    data = sample.data(tests=1)
    data["suites"][0]["fidelity"] = data["tests"][0]["fidelity"] = "kinematic"
    report = sample.typed(data)
    assert ("hri.fidelity", "kinematic") in junit.junit_properties(report.tests[0], report.outcome_label)
    page, _ = html.page(report)
    assert "kinematic simulation" in page
    assert [each["facts"]["Simulation"] for each in details(Page(page))] == ["kinematic"]


def test_an_unknown_fidelity_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conftest, "FIDELITY", "quantum")
    with pytest.raises(SimulationError, match="fidelity 'quantum': expected one of dynamic, kinematic"):
        bench.run(BORED)
    monkeypatch.undo()
    bench.run(BORED)
