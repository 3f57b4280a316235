"""The section at the end of a session in the terminal. Registered in the controlling process only."""

from __future__ import annotations

import shutil

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import terminal, totals
from pytest_hricdv.report.formatting import Line
from pytest_hricdv.session.reporting import Reporting
from pytest_hricdv.session.shown_failures import ShownFailures, write_lines


class SummarySection:
    """Writes what came of a session: verdicts, coverage, problems."""

    def __init__(self, reporting: Reporting, failures: ShownFailures) -> None:
        self._reporting = reporting
        self._failures = failures

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Writes one section at the end."""
        reporting = self._reporting
        self._failures.list_all(terminalreporter)
        if reporting.missing:
            terminalreporter.write_line(visible(f"hricdv: {reporting.missing.strip()}"), red=True)
        report, session = reporting.report, reporting.session
        if report is None and not session.problems:
            return
        terminalreporter.write_sep("=", "human-robot interaction")
        if report is not None:
            columns, is_brief = shutil.get_terminal_size().columns, terminalreporter.verbosity <= 0
            brief = is_brief and totals.has_failed(report)
            write_lines(terminalreporter, terminal.summary(report, reporting.options.report, columns, brief=brief))
            write_lines(terminalreporter, terminal.findings(report))
        improved = report.gates.improved if report and report.gates else ()
        journal = reporting.aggregation.journaling.lines(had_header=terminalreporter.verbosity >= 0)
        write_lines(terminalreporter, (Line(visible(text), "ok") for text in improved))
        write_lines(terminalreporter, (Line(visible(text), "warn") for text in (*session.warnings, *journal)))
        write_lines(terminalreporter, (Line(visible(f"FAILED {problem}"), "bad") for problem in session.problems))
