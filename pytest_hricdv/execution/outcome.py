"""Outcomes of tests, which `judge` decides: which ones fail a session, are reported as xfailed, or are as declared.

A `Judgement` has the outcome of a run. Reports, campaigns and features compare outcomes with the tuples below.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import Literal, get_args

TestOutcome = Literal[
    "failed",  # a violation that nobody declared, a fault, another run than the replayed one, or the test's own failure
    "error",  # no run came to its end, so nothing was checked
    "expected-failure",  # the test function's own xfail ended it
    "engine-sensitive",  # another result on a second engine, within the tolerances of margins
    "known-violation",  # it violated only what is declared as known to be violated
    "passed",
    "not-run",
]

OUTCOMES: tuple[TestOutcome, ...] = get_args(TestOutcome)
"""All outcomes, the worst first: if runs of one test differ, the worst represents the test."""

FAILING: tuple[TestOutcome, ...] = ("failed", "error")
"""Outcomes that fail a session, a merge and a campaign."""

XFAILED: tuple[TestOutcome, ...] = ("known-violation", "engine-sensitive", "expected-failure")
"""Outcomes that pytest reports as xfailed: they fail nothing, and do not pass."""

AS_DECLARED: tuple[TestOutcome, ...] = ("passed", "known-violation")
"""Outcomes of runs without a deviation from the project's declarations."""


@dataclass(frozen=True)
class Judgement:
    """The judgement of one run.

    Args:
        outcome: the run's outcome, if nothing else ends its test.
        undeclared: requirements that it violated, on whichever engine, and whose violation is not declared as known.
        reason: why, in a line, where the outcome is expected to fail or depends on the engine.
        depends_on_engine: whether that is what decided.
    """

    outcome: TestOutcome
    undeclared: tuple[str, ...] = ()
    reason: str = ""
    depends_on_engine: bool = False


def is_declared(requirement: str, known_violations: Container[str], *, outside: bool) -> bool:
    """Whether a violation is declared as known.

    Args:
        known_violations: requirements whose violations are known.
        outside: whether it was outside of the condition under which they are.
    """
    return requirement in known_violations and not outside
