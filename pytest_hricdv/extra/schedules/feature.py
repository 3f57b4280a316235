"""Schedules and time budgets in a session: their options, and the experiments after the last test.

`SchedulesFeature` is the `FEATURE` of this folder (see `registry`). Its `after_tests` calls `search_schedules` for
`--hri-schedules=N` and `measure_session_budgets` for `--hri-budgets=N`.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from pytest_hricdv.extra.schedules.records import BUDGETS, FAILURE_KIND, LANES, SCHEDULES, THREADS
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.extra.schedules.execution import Instrumentation
    from pytest_hricdv.generate.concrete import ConcreteTest
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext


def _instrumentation() -> Instrumentation:
    """The `INSTRUMENTATION` of this process, imported late: a session without a suite does not need its modules."""
    from pytest_hricdv.extra.schedules.execution import INSTRUMENTATION

    return INSTRUMENTATION


class ScheduleOptions(NamedTuple):
    """The number of runs with other schedules, and of tests with which time budgets are measured; 0: none."""

    runs: int
    budgets: int


class SchedulesFeature(Feature[ScheduleOptions]):
    """Runs tests with other schedules, after all tests."""

    name = "schedules"
    options = (
        Value(
            "schedules",
            "N",
            "after all tests, make N more runs of passing tests with other schedules: threads, tasks and callbacks of "
            "the code are held up where they share data (default 0)",
        ),
        Value(
            "budgets",
            "N",
            "after all tests, measure with N passing ones how slow each function and loop of the code may be before a "
            "requirement fails (default 0)",
        ),
    )

    def read(self, reader: OptionReader) -> ScheduleOptions:
        """How many runs and tests."""
        return ScheduleOptions(reader.integer("schedules", 0, minimum=0), reader.integer("budgets", 0, minimum=0))

    def check(self, context: RunContext) -> None:
        """With `--pdb`, a test with a schedule stops where it holds a node up.

        Raises:
            pytest.UsageError: the system cannot fork processes.
        """
        if (what := self.follow_up(context)) and not hasattr(os, "fork"):
            raise usage_error(f"{what}: this system cannot fork processes; use Linux or macOS")
        _instrumentation().is_debugged = bool(getattr(context.collection.config.option, "usepdb", False))

    def after_run(self, context: RunContext, test: ConcreteTest, run: CaseResult) -> CaseResult:
        """Ends the session if the debugger was told to."""
        if (quits := _instrumentation().quit) is not None:
            raise quits
        return run

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """Add the number of threads that took turns; with a schedule, when they did, and why it fails."""
        if run.test.schedule and (last := _instrumentation().last) is not None:
            from pytest_hricdv.extra.schedules.scheduler import lanes

            result = LANES.put(result, lanes(last))
        replay = context.collection.replays.get(result.id)
        if replay is not None and replay.replay.origin is not None and (run.failed or run.errors):
            result = FAILURE_KIND.put(result, replay.replay.origin.failure_kind)
        return THREADS.put(result, run.threads) if run.threads > 1 else result

    def follow_up(self, context: RunContext) -> str:
        """The experiments that were asked for."""
        asked = self.settings(context.options)
        names = {"schedules (--hri-schedules)": asked.runs, "time budgets (--hri-budgets)": asked.budgets}
        return " and ".join(name for name, count in names.items() if count)

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """Search, if asked to."""
        asked = self.settings(session.options)
        if session.interrupted or stopped or not any(asked):
            return results
        from pytest_hricdv.extra.schedules.post_session import measure_session_budgets, search_schedules

        if asked.runs:
            result, problems = search_schedules(session, results, asked.runs)
            session.sections[SCHEDULES.name] = result
            session.interrupted = result.end_reason == "interrupted"
            session.problems += problems
        if asked.budgets and not session.interrupted:
            session.sections[BUDGETS.name] = tuple(measure_session_budgets(session, results, asked.budgets))
        session.done.update(() if session.interrupted else [self.name])
        return results


FEATURE = SchedulesFeature()
