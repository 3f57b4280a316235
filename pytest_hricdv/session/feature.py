"""`Feature`, the interface of optional features with a session: options, extra suites, steps after the last test.

`features` gives those of the registry. `plugin` lets them generate suites, `Preparation` lets them check and add to the
header, and `SessionReporter` calls them after the last test, with a `FeatureSession`.
"""

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


@dataclass(frozen=True)
class DecidingRun:
    """A test with a schedule by which it passes, while another run of it failed; mutants are tried on it, too.

    Args:
        test: id of the test of the session that it was made from.
        concrete: the test with the schedule.
        places: `file:line` of the statements whose order the schedule changes.
        ended: how its run ended.
    """

    test: str
    concrete: ConcreteTest
    places: frozenset[str]
    record_sha256: str
    ended: str
    outcomes: tuple[str, ...]


@dataclass
class FeatureSession:
    """The session, as features see it in the process that collects all results.

    Args:
        context: what runs are judged and measured with.
        aggregation: the tests that were selected, and their results.
        signals: handles Ctrl-C.
        results: the results of the tests, once the last one has ended.
        is_whole: whether all tests of the suites, or of the shard, were selected and run.
        interrupted: whether Ctrl-C was pressed; then nothing long is begun. A feature that is interrupted sets it.
        problems: what went wrong, a sentence each; they fail the session.
        warnings: what is said without failing it, a sentence each.
        sections: key -> value, of the report that is being made.
        done: names of the features whose follow-up is done.
        deciding_runs: runs of tests with schedules, which pass and may fail with a bug in the code.
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
    deciding_runs: list[DecidingRun] = field(default_factory=list)

    @property
    def options(self) -> Options:
        """The options of the session."""
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
        """Start a progress line for something that may take long; returns the function that updates it."""
        return self.context.collection.wait(what)


class Feature(FeatureOptions[Settings]):
    """A feature's part in a session, its `FEATURE`; by default it has no options, and the methods do nothing.

    Its module is loaded by pytest in every project, used or not: heavy imports belong in methods.
    """

    def header(self, context: RunContext) -> Iterable[str]:
        """Lines for pytest's header in sessions with generated tests."""
        return ()

    def check(self, context: RunContext) -> None:
        """Check, before suites are generated, what would otherwise fail after the last test.

        Raises:
            pytest.UsageError: what is asked for cannot be done.
        """

    def generate(self, context: RunContext, suites: Sequence[GeneratedSuite]) -> Iterable[GeneratedSuite]:
        """Generate additional suites, given the others; in the controlling process only.

        Raises:
            pytest.UsageError: what is asked for cannot be generated.
        """
        return ()

    def after_run(self, context: RunContext, test: ConcreteTest, run: CaseResult) -> CaseResult:
        """After each run, in the process that ran it: its result, with additions of the feature."""
        return run

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """Add to the reported result of a run, before it is judged."""
        return result

    def discrepancies(self, result: TestResult) -> Iterable[Discrepancy]:
        """Differences between the run and the feature's own rerun, for the judge."""
        return ()

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """After each test, in the process that ran it: its result, with additions of the feature."""
        return result

    def after_isolated_test(self, context: RunContext, result: TestResult) -> None:
        """Where tests run, after each one whose run, with all of the above, was in a process of its own."""

    def follow_up(self, context: RunContext) -> str:
        """Name of the work after the last test, for a report that lacks it; empty if there is none."""
        return ""

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """After the last test: the results, with additions of the feature.

        Args:
            stopped: whether the session ended before its last test.
        """
        return results

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """Add to the report of a completed session, before gates judge it."""
        return report

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Add to the report after gates have judged it."""
        return report


def not_done(context: RunContext, done: Collection[str] = ()) -> tuple[str, ...]:
    """Names the follow-up work that was not done, in a sentence; nothing if all is done.

    Args:
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
    """All features that take part in sessions."""
    return offers("feature", "FEATURE")
