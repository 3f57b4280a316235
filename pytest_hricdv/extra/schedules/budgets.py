"""Time budgets: how slow each function and loop of the code may become before a requirement is violated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from pytest_hricdv.extra.schedules.records import BudgetRecord
from pytest_hricdv.extra.schedules.schedule_run import RunTest
from pytest_hricdv.extra.schedules.search import ScheduleCandidate
from pytest_hricdv.generate.schedule import EACH_TIME, ScheduleDecision

LONGEST_S = 10.0
"""Up to this delay (s) a budget is looked for: longer than any reaction of a robot to a person may take."""

PRECISION_S = 0.001
"""A budget is known to a millisecond, which is as fine as the clocks of robots' middleware tick."""


def measure_budgets(
    run: RunTest, candidates: Sequence[ScheduleCandidate], starts: Mapping[str, str]
) -> Iterator[BudgetRecord]:
    """The budget of each function and loop that a test executes.

    Args:
        run: runs tests.
        candidates: tests that pass, with their usual runs.
        starts: place of the first statement of each function and loop -> its name.
    """
    for place in sorted(starts):
        executing = [candidate for candidate in candidates if place in candidate.usual.executed]
        if executing:
            yield _budget(run, executing, place, starts[place])


def _budget(run: RunTest, candidates: Sequence[ScheduleCandidate], place: str, name: str) -> BudgetRecord:
    record = BudgetRecord(place=place, name=name, budget_s=LONGEST_S)
    for candidate in candidates:
        # Most tests do not decide: one run with the budget so far shows it.
        if (broken := _breaks(run, candidate, place, record.budget_s)) is None:
            continue
        passes_s, fails_s = 0.0, record.budget_s
        while fails_s - passes_s > PRECISION_S:
            middle_s = (passes_s + fails_s) / 2
            again = _breaks(run, candidate, place, middle_s)
            if again is None:
                passes_s = middle_s
            else:
                fails_s, broken = middle_s, again
        record = BudgetRecord(
            place=place, name=name, budget_s=round(passes_s, 6), requirement=broken, test=candidate.test.id
        )
    return record


def _breaks(run: RunTest, candidate: ScheduleCandidate, place: str, delay_s: float) -> str | None:
    """The requirement that a delay breaks, or an empty text for a fault; None where all pass."""
    decision = ScheduleDecision("delay", place, EACH_TIME, delay_s)
    ran = run(replace(candidate.test, schedule=(decision,)))
    if ran is None:
        return ""
    new = ran.fails - candidate.usual.fails
    return max(new) if new else None
