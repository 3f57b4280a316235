"""The terminal summary: why tests fail, one example in full, and the section of results.

pytest alone shows each failure in full, some fifty lines, and again in its short summary. `ShownFailures` shows causes
first, with a line for each test, and only examples of violations in full, unless `-v` asks for all; `SummarySection`
prints the results. `plugin` registers both in the controlling process. JUnit XML and editors still get full reports.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import terminal, totals
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.formatting import Line, Style, fit, plural, width, wrap
from pytest_hricdv.results.model import Report
from pytest_hricdv.session.aggregation import Aggregation
from pytest_hricdv.session.reporting import SessionReporter

ALL_FROM_VERBOSITY = 2
"""pytest's verbosity from which each failing test is shown with its traceback (`-vv`)."""

_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_VIOLATED = re.compile(r"^(?:E +)?(?P<name>\S+) Failed(?=[:\n]|$)", re.MULTILINE)
VIOLATION = re.compile(r"^\S+ failed at ")
"""The first line of the text of a test that violated a requirement."""

Key = tuple[object, ...]
"""Failures with the same key have the same error, and are shown once."""


class RepeatedErrors:
    """Folds what the terminal shows of failures."""

    def __init__(self, aggregation: Aggregation) -> None:
        self._aggregation = aggregation

    def fold(self, terminalreporter: pytest.TerminalReporter, kind: str) -> None:
        """Leave out what repeats an error, of the reports of a kind that are to be shown."""
        if terminalreporter.config.get_verbosity() >= ALL_FROM_VERBOSITY:
            return
        reports = terminalreporter.stats.get(kind, [])
        shown: list[Any] = []
        repeats: dict[Key, tuple[Any, list[str]]] = {}
        for report in reports:
            key = self._key(report)
            if key is None or key not in repeats:
                shown.append(report)
            else:
                repeats[key][1].append(report.nodeid)
            if key is not None:
                repeats.setdefault(key, (report, []))
        if len(shown) == len(reports):
            return
        terminalreporter.stats[kind] = shown
        for report, others in repeats.values():
            if others:
                _add(report, others)

    def _key(self, report: Any) -> Key | None:
        """A key that is the same for the same error, up to numbers; None for reports that are always shown."""
        crash = getattr(getattr(report, "longrepr", None), "reprcrash", None)
        if getattr(report, "nodeid", None) not in self._aggregation.chosen or crash is None:
            return None
        first = crash.message.partition("\n")[0]
        if VIOLATION.match(first):
            return None
        violated = tuple(match["name"] for match in _VIOLATED.finditer(report.longreprtext))
        return report.when, crash.path, crash.lineno, _NUMBER.sub("#", first), violated


def _add(report: Any, others: list[str]) -> None:
    title = f"the same in {plural(len(others), 'more test')}"
    named = [visible(nodeid) for nodeid in others[:20]]  # -rf lists all
    if rest := len(others) - len(named):
        named.append(f"and {rest} more")
    report.longrepr.addsection(title, "\n".join(named))


MARKUP: dict[Style, dict[str, bool]] = {
    "title": {"bold": True},
    "ok": {"green": True},
    "bad": {"red": True, "bold": True},
    "warn": {"yellow": True},
    "dim": {"light": True},
    "plain": {},
}

_HEAD = re.compile(r"\S+ Failed(:|$)")

_KINDS = ("failed", "error")


class ShownFailures:
    """Shows causes first and examples in full. Registered in the controlling process only.

    Args:
        aggregation: the tests that were selected.
        report: the session's, once it is made.
    """

    def __init__(self, aggregation: Aggregation, report: Callable[[], Report | None]) -> None:
        self._aggregation = aggregation
        self._report = report
        self._repeated = RepeatedErrors(aggregation)
        self._all: dict[str, list[Any]] = {}
        """Kind -> all reports of that kind, while some of them are not to be shown."""
        self._texts: list[tuple[Any, Any]] = []
        """Reports that are shown as examples, and their own texts."""
        self._failed: list[Any] = []
        """All failed reports, once those to be shown in full have been shown."""
        self._failing: FailingTests | None = None

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter, config: pytest.Config
    ) -> Iterator[None]:
        """Before pytest shows the failures."""
        self._all = {kind: terminalreporter.stats[kind] for kind in _KINDS if kind in terminalreporter.stats}
        report = self._report()
        if report is not None:
            self._show_causes(terminalreporter, report, is_verbose=config.get_verbosity() > 0)
        if config.getoption("tbstyle", "auto") == "line":
            self._leave_first_lines()
        if config.getoption("tbstyle", "auto") not in ("no", "line"):
            if config.get_verbosity() <= 0:
                self._leave_out(terminalreporter)
            for kind in _KINDS:
                self._repeated.fold(terminalreporter, kind)
        try:
            return (yield)
        finally:
            self.list_all(terminalreporter)
            if self._failed:
                terminalreporter.stats["failed"] = self._failed  # for its counts

    def _show_causes(self, reporter: pytest.TerminalReporter, report: Report, *, is_verbose: bool) -> None:
        columns = _columns()
        failing = self._failing = FailingTests.of(report, columns)
        if failing.tests and (failing.causes is not None or len(failing.tests) > 1):
            reporter.write_sep("=", failing.headline)
            write_lines(reporter, failing.lines(columns, all_rows=is_verbose))

    def _leave_out(self, reporter: pytest.TerminalReporter) -> None:
        """Hide violations that a cause above explains, and all but the first of the others."""
        failing = self._failing
        reports = {report.nodeid: report for report in self._all.get("failed", ()) if self._is_violation(report)}
        if failing is None or not reports:
            return
        explained = {nodeid for cause, nodeids in failing.groups if cause is not None for nodeid in nodeids}
        shown = [nodeid for nodeid in failing.examples if nodeid in reports and nodeid not in explained][:1]
        for nodeid in shown:
            report = reports[nodeid]
            self._texts.append((report, report.longrepr))
            report.longrepr = _Example(report.longrepr)
        reporter.stats["failed"] = [
            report for report in self._all["failed"] if report.nodeid in shown or report.nodeid not in reports
        ]

    def _leave_first_lines(self) -> None:
        """With --tb=line, pytest shows the text of a violation as well: it has no traceback to leave out."""
        for report in self._all.get("failed", ()):
            if self._is_violation(report):
                self._texts.append((report, report.longrepr))
                report.longrepr = _Example(report.longrepr, is_shown=False)

    def _is_violation(self, report: Any) -> bool:
        crash = getattr(getattr(report, "longrepr", None), "reprcrash", None)
        is_listed = self._failing is not None and getattr(report, "nodeid", None) in self._failing.tests
        return is_listed and crash is not None and VIOLATION.match(crash.message) is not None

    def list_all(self, reporter: pytest.TerminalReporter) -> None:
        """Let the terminal have all reports again, for its list of failures and its counts, with their causes."""
        if not self._all:
            return
        for report, longrepr in self._texts:
            report.longrepr = longrepr
        self._texts.clear()
        reporter.stats.update(self._all)
        labels = self._failing.labels() if self._failing is not None else {}
        for report in self._all.get("failed", ()):
            if self._is_violation(report) and report.nodeid in labels:
                crash = report.longrepr.reprcrash
                label = f" ({labels[report.nodeid]})"
                crash.message = f"{crash.message.removesuffix(label)}{label}"
        self._failed = self._all.get("failed", [])
        if _may_be_short(reporter.config):
            reporter.stats["failed"] = [
                report for report in self._failed if report.nodeid not in labels or not self._is_violation(report)
            ]
        self._all = {}


class SummarySection:
    """Writes the results of a session: verdicts, coverage, problems."""

    def __init__(self, reporting: SessionReporter, failures: ShownFailures) -> None:
        self._reporting = reporting
        self._failures = failures

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Writes one section at the end."""
        reporting = self._reporting
        self._failures.list_all(terminalreporter)
        if reporting.reason_for_missing_tests:
            terminalreporter.write_line(visible(f"hricdv: {reporting.reason_for_missing_tests.strip()}"), red=True)
        report, session = reporting.report, reporting.session
        if report is None and not session.problems:
            return
        is_brief = terminalreporter.verbosity <= 0
        if not is_brief or report is None or totals.has_failed(report):
            terminalreporter.write_sep("=", "human-robot interaction")
        if report is None:
            write_lines(terminalreporter, (Line(visible(f"FAILED {problem}"), "bad") for problem in session.problems))
            return
        journal = reporting.aggregation.journaling.lines(had_header=terminalreporter.verbosity >= 0)
        columns, folder = shutil.get_terminal_size().columns, reporting.options.report
        improved = report.gates.improved if report.gates else ()
        notes = [
            *(Line(fit(visible(text), columns) if is_brief else visible(text), "ok") for text in improved),
            *(Line(visible(text), "warn") for text in (*session.warnings, *journal)),
        ]
        lines = terminal.summary(report, folder, columns, brief=is_brief, notes=notes, problems=session.problems)
        write_lines(terminalreporter, lines)


class _Example:
    """The text of a failure in lines that fit, except commands, and in colours, where there is a terminal."""

    def __init__(self, longrepr: Any, *, is_shown: bool = True) -> None:
        self._text = str(longrepr)
        self._is_shown = is_shown
        self.reprcrash = longrepr.reprcrash

    def __str__(self) -> str:
        return self._text

    def toterminal(self, writer: Any) -> None:
        """pytest calls it with its `TerminalWriter`."""
        texts = self._text.splitlines() if self._is_shown else []
        for line in example_lines(texts, _columns()):
            writer.line(line.text, **MARKUP[line.style])


def example_lines(texts: Iterable[str], columns: int | None) -> Iterator[Line]:
    """The lines of a failure's text with their styles; what is too long continues below, but for commands."""
    for number, text in enumerate(texts):
        is_command = text.startswith("  pytest ")
        is_bad = number == 0 or _HEAD.match(text) is not None or "  --> " in text
        style: Style = "dim" if is_command else "bad" if is_bad else "plain"
        if columns is None or is_command or width(text) <= columns:
            yield Line(text, style)
            continue
        indent = text[: len(text) - len(text.lstrip())]
        lines = wrap(text.split(), columns - len(indent) - 4)
        yield from (Line(f"{indent}{'    ' if later else ''}{line}", style) for later, line in enumerate(lines))


def write_lines(reporter: pytest.TerminalReporter, lines: Iterable[Line]) -> None:
    """Write lines in the colours of their styles, where the terminal has any."""
    for line in lines:
        reporter.write_line(line.text, **MARKUP[line.style])


def _may_be_short(config: pytest.Config) -> bool:
    """Whether nobody asked for a list of failures: who reads one on a CI service has no other."""
    asked = config.getoption("reportchars", "") not in ("", "fE")  # pytest's own default
    return not (asked or config.get_verbosity() > 0 or os.environ.get("CI") or os.environ.get("BUILD_NUMBER"))


def _columns() -> int | None:
    """The width of the terminal; None without one: a log has lines of any width."""
    is_terminal = sys.stdout.isatty() or "COLUMNS" in os.environ
    return shutil.get_terminal_size().columns if is_terminal else None
