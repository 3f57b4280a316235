"""`--hri-resume`: skips tests that an earlier session has finished, and reports their earlier results.

`plugin` registers `ResumeFilter`, which skips them, in every process; `Preparation` uses `ResultRestorer`, which puts
the earlier results into their reports, in the controlling process.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from zlib import decompress  # as now: the code under test may replace them

import pytest
from _pytest._code.code import ReprExceptionInfo, ReprFileLocation, ReprTracebackNative

from pytest_hricdv._base.message import visible
from pytest_hricdv.execution.outcome import XFAILED
from pytest_hricdv.report import junit
from pytest_hricdv.results.codec import decode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.collection import Collection

DONE = "hricdv_done"
"""Name of the attribute that marks a `TestReport` whose test did not run again."""


class ResumeFilter:
    """Passes over the tests that are done. Registered where tests run: in workers, or without xdist."""

    def __init__(self, collection: Collection) -> None:
        self._collection = collection

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        """Reports a test that is done without running it: its items stay selected, as in a session without a break."""
        if item.nodeid not in self._collection.done:
            return None
        hook = item.ihook
        hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for when in ("setup", "call"):
            report = pytest.TestReport(
                item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "passed", None, when
            )
            setattr(report, DONE, True)
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logreport(report=self._tear_down(item, nextitem))
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def _tear_down(self, item: pytest.Item, nextitem: pytest.Item | None) -> pytest.TestReport:
        """Tears fixtures down that earlier tests left for this one; the hook for it presumes that it was set up."""
        ends = (pytest.exit.Exception, KeyboardInterrupt)
        call = pytest.CallInfo.from_call(
            lambda: item.session._setupstate.teardown_exact(nextitem), when="teardown", reraise=ends
        )
        report: pytest.TestReport = item.ihook.pytest_runtest_makereport(item=item, call=call)
        if report.passed:
            setattr(report, DONE, True)
        return report


class ResultRestorer:
    """Makes the reports of tests that are done say how they ended. Registered in the controlling process only.

    So exit status, `-x`, JUnit XML and everything else that reads pytest's reports are as if the tests had run again.

    Args:
        results: node id -> result as JSON, compressed.
    """

    def __init__(self, collection: Collection, results: Mapping[str, bytes]) -> None:
        self._collection = collection
        self._results = results

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> Iterator[None]:
        """Completes a report before any other plugin sees it."""
        if hasattr(report, DONE):
            self._restore(report, decode(decompress(self._results[report.nodeid])))
        return (yield)

    def _restore(self, report: pytest.TestReport, result: TestResult) -> None:
        report.user_properties = [*junit.junit_properties(result, self._collection.testbench.outcome_label)]
        if report.when != "call":
            return
        report.duration = result.wall_s or 0.0
        failure = visible(result.failure, keep="\n\t")  # whoever wrote the journal
        if result.outcome in XFAILED:
            report.outcome = "skipped"
            report.wasxfail, _, report.longrepr = failure.partition("\n\n")
        elif result.outcome != "passed":
            report.outcome = "failed"
            report.longrepr = _failure_repr(failure, report.location)

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_teststatus(self, report: pytest.TestReport) -> tuple[str, str, str] | None:
        """Says, with -v, that a test did not run again."""
        if not hasattr(report, DONE) or report.when != "call":
            return None
        if report.outcome == "skipped":
            return "xfailed", "x", "XFAIL (done before)"
        letter = "." if report.passed else "F"
        return report.outcome, letter, f"{report.outcome.upper()} (done before)"


def _failure_repr(text: str, location: tuple[str, int | None, str]) -> ReprExceptionInfo:
    """A failure as pytest shows it; its `reprcrash` has the message that the summary, JUnit XML and CI services repeat.

    Args:
        text: the text of the failure.
        location: the location of the test function.
    """
    raised = [line.removeprefix("E").strip() for line in text.splitlines() if line.startswith("E  ")]
    message = (raised or text.strip().splitlines() or [""])[0]
    file, line, _ = location
    return ReprExceptionInfo(ReprTracebackNative([text]), ReprFileLocation(file, (line or 0) + 1, message))
