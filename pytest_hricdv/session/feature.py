"""The interface of optional features with a session: options, extra suites, steps after the last test."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pytest

from pytest_hricdv.registry import offers
from pytest_hricdv.session.option import FeatureOptions, Settings

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.execution.hri_case import HriCase
    from pytest_hricdv.execution.judge import Discrepancy
    from pytest_hricdv.generate.concrete import ConcreteTest
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.results.report_builder import GeneratedSuite
    from pytest_hricdv.session.aggregation import Aggregation
    from pytest_hricdv.session.options import Options
    from pytest_hricdv.session.replaying import TestRerunner
    from pytest_hricdv.session.run_context import RunContext
    from pytest_hricdv.session.signals import Signals


@dataclass
class FeatureSession:
    """A session, as features see it where all results meet.

    Args:
        context: what runs are judged and measured with.
        aggregation: the tests that were selected, and their results.
        signals: handles Ctrl-C.
        results: of the tests, once the last one has ended.
        is_whole: all tests of the suites, or of the shard, were selected and run.
        interrupted: at Ctrl-C: nothing long is begun any more. An interrupted feature sets it.
        problems: what went wrong, a sentence each; they fail the session.
        warnings: what is said without failing it, a sentence each.
        sections: key -> value, of the report that is being made.
        done: names of the features whose follow-up is done.
    """

    context: RunContext
    aggregation: Aggregation
    signals: Signals
    results: list[TestResult] = field(default_factory=list)
    is_whole: bool = False
    interrupted: bool = False
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    sections: dict[str, Any] = field(default_factory=dict)
    done: set[str] = field(default_factory=set)

    @property
    def options(self) -> Options:
        """Of the session."""
        return self.context.options

    @property
    def rerunner(self) -> TestRerunner:
        """Runs tests again, outside of their pytest items."""
        from pytest_hricdv.session.replaying import TestRerunner  # needed by few sessions

        context = self.context
        return TestRerunner(
            context.run_settings,
            context.provenance,
            context.failures,
            self.aggregation.seeds,
            self.signals.let_through,
        )

    def say(self, text: str) -> None:
        """Report progress."""
        self.context.collection.say(text)

    def wait(self, what: str) -> Callable[[str], None]:
        """What is told how far something is that may take long."""
        return self.context.collection.wait(what)


class Feature(FeatureOptions[Settings]):
    """What a feature does in a session, its `FEATURE`; by default it has no options and does nothing.

    Its module is loaded with pytest itself, also in projects that do not use the plugin: what is heavy is imported by
    the methods.
    """

    def header(self, context: RunContext) -> Iterable[str]:
        """Lines of pytest's header, where tests are generated."""
        return ()

    def check(self, context: RunContext) -> None:
        """Before the first test, and before suites are generated: find what would fail after the last one.

        Raises:
            pytest.UsageError: what is asked for cannot be done.
        """

    def generate(self, context: RunContext, suites: Sequence[GeneratedSuite]) -> Iterable[GeneratedSuite]:
        """Further suites, given the others; in the controlling process only.

        Raises:
            pytest.UsageError: what is asked for cannot be generated.
        """
        return ()

    def after_run(self, context: RunContext, test: ConcreteTest, run: CaseResult) -> CaseResult:
        """Where tests run, after each run: what it gave, with what the feature adds."""
        return run

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """The result that a report has of a run, before this is judged, with what the feature adds."""
        return result

    def discrepancies(self, result: TestResult) -> Iterable[Discrepancy]:
        """What came out otherwise when the feature ran the test again, for the judge."""
        return ()

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """Where tests run, after each one: its result, with what the feature adds."""
        return result

    def after_isolated_test(self, context: RunContext, result: TestResult) -> None:
        """Where tests run, after each one whose run, with all of the above, was in a process of its own."""

    def follow_up(self, context: RunContext) -> str:
        """What it does after the last test, as a report names it that lacks it; empty where it does nothing then."""
        return ""

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """After the last test: the results, with what the feature adds.

        Args:
            stopped: the session ended before its last test.
        """
        return results

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """The report of a session that came to its end, before it is judged by its gates."""
        return report

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """The report, after it was judged."""
        return report


def not_done(context: RunContext, done: Collection[str] = ()) -> tuple[str, ...]:
    """A sentence on what follows the tests and is not done; none where all is.

    Args:
        context: of the session.
        done: names of features.
    """
    names = [name for feature in features() if feature.name not in done and (name := feature.follow_up(context))]
    if not names:
        return ()
    return (
        f"the session did not come to its end, so its report lacks: {', '.join(names)}; the same command with "
        "--hri-resume adds what is missing",
    )


def features() -> tuple[Feature[Any], ...]:
    """All that take part in sessions."""
    return offers("feature", "FEATURE")
