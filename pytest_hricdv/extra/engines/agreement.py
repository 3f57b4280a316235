"""How far two physics engines agree over the tests of a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import zip_longest

from pytest_hricdv.extra.engines.records import BESIDE, EngineComparison
from pytest_hricdv.results.model import TestResult


@dataclass(frozen=True)
class VerdictAgreement:
    """A requirement on two engines.

    Args:
        tests: that ran on both.
        same: of them with the same verdict.
        tolerated: of the others, those whose margins differ by no more than the testbench allows.
        triggers: tests with the same number of triggers.
        margin: largest difference of margins, in the requirement's own unit; None where no test has both.
    """

    tests: int
    same: int
    tolerated: int
    triggers: int
    margin: float | None


@dataclass(frozen=True)
class Agreement:
    """Two engines over some tests.

    Args:
        engines: their names.
        tests: that ran on both.
        interactions: of these tests, on the engine where there are more.
        same: those that ended alike.
        verdicts: requirement -> how far its verdicts agree.
        differing: test id -> what depends on the engine, a sentence each.
    """

    engines: tuple[str, str]
    tests: int
    interactions: int
    same: int
    verdicts: Mapping[str, VerdictAgreement]
    differing: Mapping[str, tuple[str, ...]]


def agreement(tests: Iterable[TestResult]) -> Agreement | None:
    """How far the engines agree; None where no test ran on two."""
    both = [(test, beside) for test in tests if (beside := BESIDE.of(test)) is not None]
    if not both:
        return None
    ends = [pair for test, beside in both for pair in zip_longest(test.outcomes, beside.outcomes)]
    return Agreement(
        engines=(both[0][0].engine, both[0][1].engine),
        tests=len(both),
        interactions=len(ends),
        same=sum(first == second for first, second in ends),
        verdicts={name: _of(name, both) for name in both[0][1].requirements},
        differing={
            test.id: tuple(difference.text for difference in beside.differences)
            for test, beside in both
            if beside.differences or beside.faults
        },
    )


def _of(name: str, both: list[tuple[TestResult, EngineComparison]]) -> VerdictAgreement:
    pairs = [(test.requirements[name], beside.requirements[name]) for test, beside in both]
    margins = [
        abs(first.margin - second.margin)
        for first, second in pairs
        if first.margin is not None and second.margin is not None
    ]
    differences = [difference for _, beside in both for difference in beside.differences if difference.what == name]
    return VerdictAgreement(
        tests=len(pairs),
        same=sum(first.verdict == second.verdict for first, second in pairs),
        tolerated=sum(difference.tolerated for difference in differences),
        triggers=sum(first.triggers == second.triggers for first, second in pairs),
        margin=max(margins, default=None),
    )
