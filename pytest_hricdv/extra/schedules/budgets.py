"""Time budgets (`--hri-budgets`): how slow each function and loop of the code may be before a requirement fails.

`measure_session_budgets` calls `measure_budgets`, which runs passing tests with one function or loop delayed, and finds
the budget by bisection.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from msgspec.structs import replace

from pytest_hricdv.extra.schedules.records import BudgetRecord
from pytest_hricdv.extra.schedules.schedule_run import RunTest
from pytest_hricdv.extra.schedules.search import ScheduleCandidate
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.schedule import EACH_TIME, ScheduleDecision

LONGEST_S = 10.0
"""Largest delay (s) that is tried for a budget: longer than any reaction of a robot to a person may take."""

PRECISION_S = 0.001
"""Precision of a budget (s): as fine as the clocks of robots' middleware tick."""

PAIRED = 3
"""Number of the smallest budgets of which pairs are measured, too: the table still fits on a screen."""


def measure_budgets(
    run: RunTest, candidates: Sequence[ScheduleCandidate], starts: Mapping[str, str]
) -> Iterator[BudgetRecord]:
    """The budget of each function and loop that a test executes; for pairs of the smallest, how slow both may be.

    Args:
        candidates: tests that pass, with their usual runs.
        starts: place of the first statement of each function and loop -> its name.
    """
    made: list[BudgetRecord] = []
    for place in sorted(starts):
        if executing := [candidate for candidate in candidates if place in candidate.usual.executed]:
            made.append(
                _budget(run, executing, BudgetRecord(place=place, name=starts[place], budget_s=LONGEST_S), [place])
            )
            yield made[-1]
    broken = sorted((budget for budget in made if budget.test is not None), key=lambda budget: budget.budget_s)
    for first, second in combinations(broken[:PAIRED], 2):
        both = [candidate for candidate in candidates if {first.place, second.place} <= {*candidate.usual.executed}]
        if both:
            yield _budget(run, both, replace(first, other=f"{second.place} {second.name}"), [first.place, second.place])


def _budget(
    run: RunTest, candidates: Sequence[ScheduleCandidate], record: BudgetRecord, places: Sequence[str]
) -> BudgetRecord:
    for candidate in candidates:
        # Most tests do not decide: one run with the budget so far shows it.
        if (broken := _breaks(run, candidate, places, record.budget_s)) is None:
            continue
        passes, fails = 0, round(record.budget_s / PRECISION_S)
        while fails - passes > 1:
            middle = (passes + fails) // 2
            again = _breaks(run, candidate, places, middle * PRECISION_S)
            if again is None:
                passes = middle
            else:
                fails, broken = middle, again
        record = replace(record, budget_s=round(passes * PRECISION_S, 6), requirement=broken, test=candidate.test.id)
    return record


def _breaks(run: RunTest, candidate: ScheduleCandidate, places: Sequence[str], delay_s: float) -> str | None:
    """The requirement that a delay at each place breaks, or an empty string for a fault; None where all pass."""
    ran = run(slow_down(candidate.test, places, delay_s))
    if ran is None:
        return ""
    new = ran.fails - candidate.usual.fails
    return max(new) if new else None


def slow_down(test: ConcreteTest, places: Sequence[str], delay_s: float) -> ConcreteTest:
    """The test with a delay (s) before each execution of the statements at these places."""
    decisions = tuple(ScheduleDecision("delay", place, EACH_TIME, round(delay_s, 6)) for place in places)
    return dataclasses.replace(test, schedule=decisions)
