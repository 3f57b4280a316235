"""`SchedulesView`: shows schedules under which tests fail, and time budgets, in the terminal and on the page.

The report calls it by way of `registry`. `budget_lines` and `title` make the lines of the terminal.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from msgspec import to_builtins

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.schedules.records import (
    BUDGETS,
    LANES,
    OTHERWISE,
    SCHEDULES,
    THREADS,
    BudgetRecord,
    RaceRecord,
    ScheduleResult,
)
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, plural
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report, TestResult

MAX_BUDGETS = 12
"""Maximum number of budgets in the terminal, the smallest ones: half a screen."""


class SchedulesView(View):
    """Races with their commands, and the pairs that were tried."""

    name = "schedules"
    scripts = ("schedule_lanes",)

    def of_test(self, report: Report, test: TestResult) -> Mapping[str, Any]:
        """When each node ran, where the test has a schedule."""
        return {"nodes": [to_builtins(lane) for lane in lanes]} if (lanes := LANES.of(test)) else {}

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """A note that one order was tested, if the code has threads and no schedules were searched."""
        if any(test.concrete.schedule for test in report.tests):
            return
        if SCHEDULES.of(report) is None and any(THREADS.of(test) for test in report.tests):
            yield Line("schedules     one thread order was tested; --hri-schedules=100 tries others")

    def findings(self, report: Report) -> Iterator[Line]:
        """Each race, then how much was tried; the smallest time budgets."""
        yield from budget_lines(BUDGETS.of(report), report.rerun_options.options)
        result = SCHEDULES.of(report)
        if result is None:
            return
        for race in result.races:
            yield Line(visible(title(race)), "bad" if race.is_counted else "warn")
            yield Line(visible(f"  {race.words}"))
            if race.replay:
                yield Line(visible(f"  {replay_command(race.replay, report.rerun_options.options)}"), "dim")
        is_whole = not (result.races or result.lost or result.left_out)
        yield Line(visible(f"schedules: {describe_effort(result)}"), "ok" if is_whole else "warn")

    def section(self, report: Report) -> PageSection | None:
        """Races, the pairs that came in one order only, and time budgets."""
        result, budgets = SCHEDULES.of(report), BUDGETS.of(report)
        if result is None and not budgets:
            return None
        options, races = report.rerun_options.options, result.races if result else ()
        replays = [*(race.replay for race in races), *(budget.replay for budget in budgets)]
        values = {
            "result": result,
            "budgets": budgets,
            "commands": {name: replay_command(name, options) for name in replays if name},
            "titles": [title(race) for race in races],
            "tried": describe_effort(result) if result else "",
        }
        return PageSection("schedules", "Schedules", "schedules/schedules.html.jinja", values, place="in closure")


VIEW = SchedulesView()


def budget_lines(budgets: Sequence[BudgetRecord], options: Sequence[str]) -> Iterator[Line]:
    """A line for each of the smallest, of those that break a requirement; how to see the first one break it."""
    broken = [budget for budget in budgets if budget.test is not None]
    if budgets:
        yield Line(f"time budgets of {plural(len(budgets), 'function')} and loops until a requirement breaks:")
    for budget in broken[:MAX_BUDGETS]:
        what = budget.requirement or "a fault"
        both = f"{budget.name}, and {budget.other}" if budget.other else budget.name
        yield Line(visible(f"  {budget.budget_s:9.3f} s  {what:8} {budget.place} {both} ({budget.test})"))
    if broken and broken[0].replay:
        yield Line(visible(f"  the first, a millisecond slower: {replay_command(broken[0].replay, options)}"), "dim")
    if (left := len(broken) - MAX_BUDGETS) > 0:
        yield Line(f"  {left} more: see the report")
    if never := [budget.budget_s for budget in budgets if budget.test is None]:
        yield Line(f"  {len(never)} of them: no requirement breaks up to {min(never):g} s")


def title(race: RaceRecord) -> str:
    """`R2 of rl-go-once-21db2ad5 fails in the wrong order`; of a fault, what it is."""
    if not race.requirement:
        return f"{race.test}: {race.fault}"
    fails = f"{race.requirement} of {race.test} fails"
    if race.failure_kind == "late":
        counted = "" if race.is_counted else "; listed only, as no Timing(slowest_s=...) is declared"
        return f"{fails} if the code is {race.least_s:.4g} s late{counted}"
    return f"{fails} in the wrong order"


def describe_effort(result: ScheduleResult) -> str:
    """`100 runs of 6 tests, 12 of 14 pairs in either order, nodes held up for 0.05 s at most`, and what is missing."""
    if result.left_out and not result.tests:
        return f"nothing was run: {plural(result.left_out, 'test')} left out: {OTHERWISE}"
    left_out = f"; {plural(result.left_out, 'test')} left out: {OTHERWISE}" if result.left_out else ""
    if result.end_reason == "nothing to order":
        return f"nothing to order: in no run did two threads, tasks or callbacks of the code take turns{left_out}"
    lost = f"; {plural(result.lost, 'run')} did not end" if result.lost else ""
    ended = "; interrupted" if result.end_reason == "interrupted" else ""
    return (
        f"{plural(result.runs, 'run')} of {plural(result.tests, 'test')}, {result.both} of "
        f"{plural(result.pairs, 'pair')} of statements in either order, nodes held up for {result.slowest_s:g} s at "
        f"most{lost}{left_out}{ended}"
    )
