"""Judges runs: the only place that decides the outcome of a run, and of its test function.

`judge_run` judges one run, for `TestRunner`, custom tests and `run_process`; `judge_test` also uses how pytest saw the
test function end. What pytest raises or reports is derived from this `Judgement`, never the other way round.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Literal, Protocol

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.outcome import XFAILED, Judgement, TestOutcome, is_declared

ENGINE_SENSITIVE = "engine-sensitive"

FunctionEnd = Literal["returned", "raised", "xfailed"]
"""How a test function ended for pytest; xfailed: by a mark or call in the test, or by what the judgement had raised."""


class Discrepancy(Protocol):
    """A difference between the results on two physics engines."""

    @property
    def what(self) -> str:
        """The name of the requirement; another text where it is the course of the run."""

    @property
    def text(self) -> str:
        """How it was on which engine, for people."""

    @property
    def tolerated(self) -> bool:
        """Whether margins differ by no more than the testbench allows engines to differ."""


def judge_run(
    result: CaseResult | None,
    known_violations: Mapping[str, str],
    *,
    differences: Sequence[Discrepancy] = (),
    mismatch: str = "",
) -> Judgement:
    """Judge a run.

    Args:
        result: the run's result, with that on a second engine where engines check each other; None if it did not end.
        known_violations: requirement -> why its violation is known; none in a strict session.
        differences: between this run and the one on the second engine.
        mismatch: why the run of a replay is not the recorded one, without an excuse; empty if it is.
    """
    if result is None:
        return Judgement("error")
    undeclared = list_undeclared_violations(result, known_violations)
    if mismatch or result.errors:
        return Judgement("failed", undeclared)
    if result.cross_check is not None:
        by_engine = _judge_engines(result.cross_check, undeclared, known_violations, differences)
        if by_engine is not None:
            return by_engine
    if undeclared:
        return Judgement("failed", undeclared)
    if result.failed:
        declared = "; ".join(f"{name} ({known_violations[name]})" for name in result.failed)
        return Judgement("known-violation", reason=f"known violation of {declared}")
    return Judgement("passed")


def judge_test(end: FunctionEnd, judgement: Judgement | None, *, has_run: bool) -> TestOutcome:
    """Judge a test whose function has ended.

    The author has the last word, as everywhere in pytest: a function that returns passes, even if it catches the error
    of the check. An xfail of the author stays one, and makes no violation a known one.

    Args:
        end: how the function ended.
        judgement: the run's judgement, if what was raised for it ended the function; otherwise None.
        has_run: whether a run came to its end.
    """
    if end == "xfailed":
        return judgement.outcome if judgement is not None and judgement.outcome in XFAILED else "expected-failure"
    if not has_run:
        return "error"
    return "passed" if end == "returned" else "failed"


def list_undeclared_violations(result: CaseResult, known_violations: Container[str]) -> tuple[str, ...]:
    """The requirements that a run violated, on whichever engine, and whose violation there is not declared as known."""
    runs = (result,) if result.cross_check is None else (result, result.cross_check)
    names = (
        verdict.requirement
        for run in runs
        for verdict in run.verdicts
        if verdict.verdict == "Failed"
        and not is_declared(verdict.requirement, known_violations, outside=verdict.outside)
    )
    return tuple(dict.fromkeys(names))


def _judge_engines(
    second: CaseResult,
    undeclared: tuple[str, ...],
    known_violations: Container[str],
    differences: Sequence[Discrepancy],
) -> Judgement | None:
    """The judgement where the engine decides; None if it does not, as where the same violation is on both.

    A test whose verdict depends on the engine is never a pass. Where margins explain it, it is expected to fail. A
    failure on one engine that they do not explain is one, as another course of the run and a fault there are, too.
    """
    if not (differences or second.errors):
        return None
    depending = {difference.what for difference in differences}
    if any(name not in depending for name in undeclared):
        return None
    texts = [*(difference.text for difference in differences), *(f"{second.engine}: {text}" for text in second.errors)]
    unexplained = any(
        not difference.tolerated and (difference.what in undeclared or difference.what not in known_violations)
        for difference in differences
    )
    outcome: TestOutcome = "failed" if second.errors or unexplained else "engine-sensitive"
    return Judgement(outcome, undeclared, f"{ENGINE_SENSITIVE}: {'; '.join(texts)}", depends_on_engine=True)
