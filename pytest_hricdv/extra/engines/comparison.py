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
        texts = (" ".join(run.outcome.outcomes) or "none" for run in (result, other))
        differences.append(_outcome_difference(testbench.outcome_label, result.engine, other.engine, *texts))
    if result.outcome.ended != other.outcome.ended:
        ends = result.outcome.ended, other.outcome.ended
        differences.append(_outcome_difference("end", result.engine, other.engine, *ends))
    for verdict, other_verdict in zip(result.verdicts, other.verdicts, strict=True):
        if verdict.verdict != other_verdict.verdict:
            tolerance = testbench.engine_tolerances.get(verdict.requirement)
            differences.append(_verdict_difference(verdict, other_verdict, result.engine, other.engine, tolerance))
    return EngineComparison(
        engine=other.engine,
        outcomes=tuple(other.outcome.outcomes),
        record_sha256=other.record.sha256,
        requirements={
            verdict.requirement: OtherVerdict(verdict=verdict.verdict, margin=verdict.margin, triggers=verdict.triggers)
            for verdict in other.verdicts
        },
        faults=other.faults,
        differences=tuple(differences),
    )


def _outcome_difference(name: str, engine: str, other_engine: str, outcome: str, other: str) -> EngineDifference:
    text = f"{name}: {outcome} on {engine}, {other} on {other_engine}: {LOOK}"
    return EngineDifference(what=name, text=text, tolerated=False)


def _verdict_difference(
    verdict: Verdict, other: Verdict, engine: str, other_engine: str, tolerance: float | None
) -> EngineDifference:
    tolerated = (
        tolerance is not None
        and verdict.margin is not None
        and other.margin is not None
        and abs(verdict.margin - other.margin) <= tolerance
    )
    texts = f"{_said(verdict, engine)}, {_said(other, other_engine)}"
    text = f"{verdict.requirement}: {texts}: {TOLERATED if tolerated else LOOK}"
    return EngineDifference(what=verdict.requirement, text=text, tolerated=tolerated)


def _said(verdict: Verdict, engine: str) -> str:
    by = "" if verdict.margin is None else f" by {verdict.margin:+.4g}"
    return f"{_WORDS[verdict.verdict]} on {engine}{by}"
