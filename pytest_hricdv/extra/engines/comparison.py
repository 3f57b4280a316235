"""What depends on the physics engine in a test that ran on two."""

from __future__ import annotations

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.engines.records import EngineComparison, EngineDifference, OtherVerdict
from pytest_hricdv.monitor import Verdict
from pytest_hricdv.testbench import Testbench

LOOK = "outcome differs: look"
TOLERATED = "within engine tolerance"
_WORDS = {"Passed": "passed", "Failed": "failed", "NC": "not checked"}


def compare(result: CaseResult, other: CaseResult, testbench: Testbench) -> EngineComparison:
    """How a test went on two engines.

    Args:
        result: on the first.
        other: of the same test on the second.
        testbench: says by how much margins may differ.
    """
    differences = []
    if result.outcome.outcomes != other.outcome.outcomes:
        texts = (" ".join(each.outcome.outcomes) or "none" for each in (result, other))
        differences.append(_outcome_difference(testbench.outcome_label, result.engine, other.engine, *texts))
    if result.outcome.ended != other.outcome.ended:
        ends = result.outcome.ended, other.outcome.ended
        differences.append(_outcome_difference("end", result.engine, other.engine, *ends))
    for one, two in zip(result.verdicts, other.verdicts, strict=True):
        if one.verdict != two.verdict:
            tolerance = testbench.engine_tolerances.get(one.requirement)
            differences.append(_verdict_difference(one, two, result.engine, other.engine, tolerance))
    return EngineComparison(
        engine=other.engine,
        outcomes=tuple(other.outcome.outcomes),
        record_sha256=other.record.sha256,
        requirements={
            each.requirement: OtherVerdict(verdict=each.verdict, margin=each.margin, triggers=each.triggers)
            for each in other.verdicts
        },
        faults=other.faults,
        differences=tuple(differences),
    )


def _outcome_difference(what: str, one: str, two: str, first: str, second: str) -> EngineDifference:
    text = f"{what}: {first} on {one}, {second} on {two}: {LOOK}"
    return EngineDifference(what=what, text=text, tolerated=False)


def _verdict_difference(
    one: Verdict, two: Verdict, first: str, second: str, tolerance: float | None
) -> EngineDifference:
    tolerated = (
        tolerance is not None
        and one.margin is not None
        and two.margin is not None
        and abs(one.margin - two.margin) <= tolerance
    )
    text = f"{one.requirement}: {_said(one, first)}, {_said(two, second)}: {TOLERATED if tolerated else LOOK}"
    return EngineDifference(what=one.requirement, text=text, tolerated=tolerated)


def _said(verdict: Verdict, engine: str) -> str:
    by = "" if verdict.margin is None else f" by {verdict.margin:+.4g}"
    return f"{_WORDS[verdict.verdict]} on {engine}{by}"
