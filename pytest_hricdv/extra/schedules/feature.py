"""Schedules in a session: the option, and the search after the last test."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.extra.schedules.records import SCHEDULES, THREADS
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext


class SchedulesFeature(Feature[int]):
    """Runs tests with other schedules, after all tests."""

    name = "schedules"
    options = (
        Value(
            "schedules",
            "N",
            "after all tests, run those that passed N times with other schedules: threads, tasks and callbacks of the "
            "code are held up where they share data (default 0)",
        ),
    )

    def read(self, reader: OptionReader) -> int:
        """How many runs."""
        return reader.integer("schedules", 0, minimum=0)

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """How many threads took turns."""
        return THREADS.put(result, run.threads) if run.threads > 1 else result

    def follow_up(self, context: RunContext) -> str:
        """What is asked for."""
        return "schedules (--hri-schedules)" if self.settings(context.options) else ""

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """Search, if asked to."""
        runs = self.settings(session.options)
        if session.interrupted or stopped or not runs:
            return results
        from pytest_hricdv.extra.schedules.post_session import search_schedules

        result, problems = search_schedules(session, results, runs)
        session.sections[SCHEDULES.name] = result
        session.interrupted = result.end_reason == "interrupted"
        session.done.update(() if session.interrupted else [self.name])
        session.problems += problems
        return results


FEATURE = SchedulesFeature()
