"""Diagnosis in a session (`--hri-diagnose`): its option, and its experiments after the last test if tests failed.

`DiagnosisFeature` is the `FEATURE` of this folder (see `registry`): `extend_report` calls `diagnose` for the causes,
`after_test` traces failing tests. `COMMANDS` has the command `hricdv report triage`, which works on the results.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.extra.diagnosis.options import DiagnosisOptions
from pytest_hricdv.report.view import ReportCommand
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.execution.hri_case import HriCase
    from pytest_hricdv.extra.diagnosis.executed_lines import LineTracer
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

OK, FAILED = 0, 1  # exit codes of `hricdv report triage`


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("report", type=Path, metavar="REPORT", help="a report folder or its report.json")


def _triage(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.diagnosis.records import DIAGNOSIS
    from pytest_hricdv.extra.diagnosis.triage import lines, proposals
    from pytest_hricdv.results.codec import ReportError, load

    report = load(options.report)
    diagnosis = DIAGNOSIS.of(report)
    if diagnosis is None:
        if any(test.fails for test in report.tests):
            raise ReportError(f"{options.report}: no causes in it; run the suite again without --hri-diagnose=0")
        print("no test fails: nothing to tolerate")
        return OK
    made = proposals(report, diagnosis)
    for line in lines(report, made):
        print(harmless_line(line))
    return OK if all(entry.line for proposal in made for entry in proposal.entries) else FAILED


COMMANDS = (
    ReportCommand(
        "triage",
        "propose an entry of hri_known_violations for each cause; exit 1 where no condition separates one",
        _add_arguments,
        _triage,
    ),
)


_TRACING: pytest.StashKey[LineTracer] = pytest.StashKey()


STOPPED = "failure analysis skipped: session stopped early (-x, --maxfail, Ctrl-C); replay what failed for its causes"
"""The warning of a session with failed tests."""


class DiagnosisFeature(Feature[DiagnosisOptions]):
    """Finds the causes of failing tests."""

    name = "diagnosis"
    options = (
        Value(
            "diagnose",
            "N",
            "if tests fail, group their failures by cause, and confirm the causes in at most N runs of failing tests "
            "without what they are suspected to fail for; 0: no causes (default: one per twenty runs of the session, "
            "at least 48)",
        ),
    )

    def read(self, reader: OptionReader) -> DiagnosisOptions:
        """The number of runs that a diagnosis may take."""
        return DiagnosisOptions(reader.integer("diagnose", None, minimum=0))

    def after_tests(self, session: FeatureSession, results: list[TestResult], *, stopped: bool) -> list[TestResult]:
        """Warn that a session that ended before its last test was not diagnosed."""
        if stopped and self.settings(session.options).runs != 0 and any(test.fails for test in results):
            session.warnings.append(STOPPED)
        return results

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """The result with the lines that its run executed, if it failed: its duration is taken already."""
        if not self._traces(context) or case.result is None or not result.fails:
            return result
        from pytest_hricdv.coverage.own_coverage import debugger
        from pytest_hricdv.extra.diagnosis.records import LINES
        from pytest_hricdv.runtime.supervision import took_long

        return (
            result
            if took_long(result.errors) or debugger()
            else LINES.put(result, self._trace(context).trace(case.result))
        )

    def after_isolated_test(self, context: RunContext, result: TestResult) -> None:
        """Counts its traced run among those of this process."""
        if not self._traces(context) or not result.fails:
            return
        from pytest_hricdv.extra.diagnosis.records import LINES

        lines = LINES.of(result)
        if lines is not None and lines.files:
            self._trace(context).count([name for name in result.requirements if result.violates(name)] or [""])

    def _traces(self, context: RunContext) -> bool:
        """Whether lines of failing runs are looked for: the page has to have the texts that they are of."""
        return self.settings(context.options).runs != 0 and bool(context.code.files)

    def _trace(self, context: RunContext) -> LineTracer:
        from pytest_hricdv.extra.diagnosis.executed_lines import LineTracer

        if _TRACING not in context.stash:
            context.stash[_TRACING] = LineTracer(context.run_settings, context.code)
        return context.stash[_TRACING]

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """The report with the causes of its failures."""
        settings = self.settings(session.options)
        if session.interrupted or settings.runs == 0 or not any(test.fails for test in report.tests):
            return report
        from pytest_hricdv.extra.diagnosis.causes import diagnose  # of failing sessions only

        return diagnose(session, report, settings)

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Report causes that are new or gone among known violations whose entry names causes. It takes no run."""
        entries = session.options.known_violations
        is_whole = session.is_whole and session.options.shard is None
        if is_whole and not session.options.strict and any(entry.causes for entry in entries.values()):
            from pytest_hricdv.extra.diagnosis.triage import compare_with_entries  # where somebody has named causes

            for is_new, text in compare_with_entries(report, entries):
                (session.problems if is_new else session.warnings).append(text)
        return report


FEATURE = DiagnosisFeature()
