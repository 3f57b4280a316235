"""What comes of a run and of its test, as a table: each situation with its judgement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import pytest

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.judge import FunctionEnd, judge_run, judge_test
from pytest_hricdv.execution.outcome import Judgement, TestOutcome
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Verdict, Violation
from pytest_hricdv.runtime import Record
from pytest_hricdv.testbench import Outcome

KNOWN = {"R2": "no dimmer", "R3": "no voice"}
FAULT = "the run ended at its time limit of 60 s"
MISMATCH = "this run differs from the one in x.json"


def verdict(requirement: str, result: Literal["Passed", "Failed", "NC"], *, outside: bool = False) -> Verdict:
    violations = (Violation(1.0, 2.0, {}, -1.0, outside=outside),) if result == "Failed" else ()
    return Verdict(
        requirement=requirement,
        verdict=result,
        triggers=1,
        passes=0,
        failures=len(violations),
        untriggered=0,
        pending=0,
        violations=violations,
        margin=None,
        margin_time_s=None,
    )


def run(
    *failed: str, outside: Sequence[str] = (), faults: tuple[str, ...] = (), beside: CaseResult | None = None
) -> CaseResult:
    """A run that violates some of three requirements, and some outside of the condition under which that is known."""
    verdicts = [
        verdict(name, "Failed" if name in (*failed, *outside) else "Passed", outside=name in outside)
        for name in ("R1", "R2", "R3")
    ]
    return CaseResult(
        test=ConcreteTest("t", "s", 1, ()),
        outcome=Outcome("done"),
        record=Record((), {}, "hash"),
        sim_s=9.0,
        verdicts=tuple(verdicts),
        code=None,
        ending_faults=faults,
        engine="led" if beside is None else "bulb",
        cross_check=beside,
    )


@dataclass(frozen=True)
class Differs:
    """Something that came out otherwise on the second engine."""

    what: str
    tolerated: bool = False
    text: str = field(default="differs", init=False)


RUNS: dict[str, tuple[CaseResult | None, TestOutcome, tuple[str, ...]]] = {
    "no run": (None, "error", ()),
    "nothing violated": (run(), "passed", ()),
    "a violation that is known": (run("R2"), "known-violation", ()),
    "two that are known": (run("R2", "R3"), "known-violation", ()),
    "one that nobody declared": (run("R1"), "failed", ("R1",)),
    "a known one and one that nobody declared": (run("R1", "R2"), "failed", ("R1",)),
    "a known one, outside of its condition": (run(outside=["R2"]), "failed", ("R2",)),
    "a fault": (run(faults=(FAULT,)), "failed", ()),
    "a fault and a known violation": (run("R2", faults=(FAULT,)), "failed", ()),
    "a fault and another violation": (run("R1", faults=(FAULT,)), "failed", ("R1",)),
}


@pytest.mark.parametrize("situation", RUNS)
def test_a_run_is_judged_by_its_verdicts_and_faults(situation: str) -> None:
    result, outcome, undeclared = RUNS[situation]
    judgement = judge_run(result, KNOWN)
    assert (judgement.outcome, judgement.undeclared) == (outcome, undeclared)
    assert not judgement.depends_on_engine


def test_a_known_violation_is_told_with_its_reason() -> None:
    assert judge_run(run("R2"), KNOWN).reason == "known violation of R2 (no dimmer)"
    assert judge_run(run("R2", "R3"), KNOWN).reason == "known violation of R2 (no dimmer); R3 (no voice)"


@pytest.mark.parametrize("result", [run(), run("R2"), run("R1")])
def test_a_replay_that_is_another_run_fails_whatever_it_violates(result: CaseResult) -> None:
    assert judge_run(result, KNOWN, mismatch=MISMATCH).outcome == "failed"


within, beyond = Differs("R1", tolerated=True), Differs("R1")
ENGINES: dict[str, tuple[CaseResult, tuple[Differs, ...], TestOutcome, bool]] = {
    "alike": (run(beside=run()), (), "passed", False),
    "alike, with a known violation": (run("R2", beside=run("R2")), (), "known-violation", False),
    "the same violation on both": (run("R1", beside=run("R1")), (), "failed", False),
    "violated here, within tolerance": (run("R1", beside=run()), (within,), "engine-sensitive", True),
    "violated there, within tolerance": (run(beside=run("R1")), (within,), "engine-sensitive", True),
    "violated here, beyond it": (run("R1", beside=run()), (beyond,), "failed", True),
    "violated there, beyond it": (run(beside=run("R1")), (beyond,), "failed", True),
    "known, and violated here only": (run("R2", beside=run()), (Differs("R2"),), "engine-sensitive", True),
    "known, and violated there only": (run(beside=run("R2")), (Differs("R2"),), "engine-sensitive", True),
    "outside of the known condition there": (run(beside=run(outside=["R2"])), (Differs("R2"),), "failed", True),
    "outside of it there, within tolerance": (
        run(beside=run(outside=["R2"])),
        (Differs("R2", tolerated=True),),
        "engine-sensitive",
        True,
    ),
    "another course of the run": (run(beside=run()), (Differs("end"),), "failed", True),
    "a fault there": (run(beside=run(faults=(FAULT,))), (), "failed", True),
    "a fault there, and a known violation on both": (run("R2", beside=run("R2", faults=(FAULT,))), (), "failed", True),
    "a fault here": (run(faults=(FAULT,), beside=run()), (Differs("end"),), "failed", False),
    "one violation on both, another here only": (
        run("R1", "R3", beside=run("R1")),
        (Differs("R3", tolerated=True),),
        "failed",
        False,
    ),
}


@pytest.mark.parametrize("situation", ENGINES)
def test_what_depends_on_the_engine_is_never_a_pass(situation: str) -> None:
    result, differences, outcome, depends = ENGINES[situation]
    judgement = judge_run(result, KNOWN, differences=differences)
    assert (judgement.outcome, judgement.depends_on_engine) == (outcome, depends)
    assert judgement.reason.startswith("engine-sensitive: ") == depends


def test_the_reason_names_what_differs_and_the_engine_of_a_fault() -> None:
    result = run(beside=run(faults=(FAULT,)))
    judgement = judge_run(result, KNOWN, differences=(Differs("end"),))
    assert judgement.reason == f"engine-sensitive: differs; led: {FAULT}"


FAILED, TOLERATED = Judgement("failed", ("R1",)), Judgement("known-violation", reason="known")
TESTS: dict[str, tuple[FunctionEnd, Judgement | None, bool, TestOutcome]] = {
    "it returned": ("returned", None, True, "passed"),
    "the check failed it": ("raised", FAILED, True, "failed"),
    "the check found a known violation": ("xfailed", TOLERATED, True, "known-violation"),
    "the check found what depends on the engine": ("xfailed", Judgement("engine-sensitive"), True, "engine-sensitive"),
    "the check failed it under its author's mark": ("xfailed", FAILED, True, "expected-failure"),
    "its author's xfail ended it": ("xfailed", None, True, "expected-failure"),
    "its author's xfail ended it before a run": ("xfailed", None, False, "expected-failure"),
    "its author's assertion failed": ("raised", None, True, "failed"),
    "a known violation under --runxfail": ("raised", TOLERATED, True, "failed"),
    "the run came to no end": ("raised", None, False, "error"),
    "it returned without a run": ("returned", None, False, "error"),
}


@pytest.mark.parametrize("situation", TESTS)
def test_the_author_of_a_test_has_the_last_word(situation: str) -> None:
    end, judgement, has_run, outcome = TESTS[situation]
    assert judge_test(end, judgement, has_run=has_run) == outcome
