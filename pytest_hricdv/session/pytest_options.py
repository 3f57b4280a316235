"""How a session with generated tests adapts to pytest's options and disabled plugins, and which options it refuses."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Generator, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

from pytest_hricdv._base.message import MAX_TEXT, cut, visible
from pytest_hricdv.execution.judge import FunctionEnd
from pytest_hricdv.execution.outcome import XFAILED, Judgement, TestOutcome
from pytest_hricdv.session.option import usage_error
from pytest_hricdv.session.options import Options

_RUNNING_NOTHING = ("collectonly", "setuponly", "setupplan", "cacheshow", "showfixtures", "show_fixtures_per_test")


def runs_tests(config: pytest.Config) -> bool:
    """Whether tests are called: not with --collect-only, --cache-show and others, which only show something."""
    return not any(getattr(config.option, name, False) for name in _RUNNING_NOTHING)


def refuse_break(config: pytest.Config, options: Options) -> None:
    """Raise pytest.UsageError where --hri-break-on-violation has no debugger."""
    if options.stop_at and not config.pluginmanager.hasplugin("debugging"):
        raise usage_error("--hri-break-on-violation: pytest's debugger is switched off: leave -p no:debugging out")


def refuse_looponfail(config: pytest.Config, options: Options) -> None:
    """Raise pytest.UsageError where xdist would take each new report for a change, and start again for ever."""
    roots = [Path(root) for root in config.getini("looponfailroots")] or [Path.cwd()]
    report = Path(options.report).resolve()
    for root in roots:
        if not report.is_relative_to(root.resolve()):
            continue
        inside = report.relative_to(root.resolve())
        if not any(name.startswith(".") for name in inside.parts):  # of those, xdist watches none
            raise usage_error(
                f"--looponfail watches {root}, where each run writes its report ({inside}), and would run for ever: "
                "name folders without it in looponfailroots, or let its name begin with a dot: "
                "--hri-report=.hri-report"
            )


def say_without_terminal(config: pytest.Config, problems: Iterable[str]) -> None:
    """Print why a session failed on standard error if pytest's terminal is off: nothing else would say it."""
    if not config.pluginmanager.hasplugin("terminalreporter"):
        for problem in problems:
            print(visible(f"FAILED {problem}"), file=sys.stderr)


class ExpectedFailures:
    """Does for the tests of known violations what pytest's plugin of skips does, where that is switched off.

    Without it, pytest reports as failed what ends with `pytest.xfail`.
    """

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_runtest_makereport(
        self, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Before others see the report."""
        report = yield
        if call.excinfo is not None and isinstance(call.excinfo.value, pytest.xfail.Exception):
            report.outcome, report.wasxfail = "skipped", str(call.excinfo.value.msg)
        return report

    def pytest_report_teststatus(self, report: pytest.TestReport) -> tuple[str, str, str] | None:
        """With the words of that plugin."""
        return ("xfailed", "x", "XFAIL") if report.skipped and hasattr(report, "wasxfail") else None


Raised = TypeVar("Raised", bound=BaseException)

NO_REASON = "xfail without a reason"

MAX_OUTPUT = 10 * MAX_TEXT
"""Characters of a test's failure, and of each of its outputs, that pytest receives."""

_EXPLAINED = "_hricdv_explained"
"""Attribute of an exception whose text is the plugin's, with a first line that stands alone."""


def cut_texts(report: pytest.TestReport) -> None:
    """Cut what the code under test has written: a terminal, JUnit's file and other processes get all of it."""
    report.sections[:] = [(name, cut(text, MAX_OUTPUT)) for name, text in report.sections]
    if not report.passed and not isinstance(report.longrepr, tuple) and report.longrepr is not None:
        text = report.longreprtext
        if len(text) > MAX_OUTPUT:
            report.longrepr = cut(text, MAX_OUTPUT)


def explain_failure(error: Raised) -> Raised:
    """The exception, whose text the plugin wrote, or has added to."""
    with contextlib.suppress(AttributeError):  # a class of the code under test may have slots
        setattr(error, _EXPLAINED, True)
    return error


class FirstLines:
    """Leaves the first line where pytest, services and editors repeat a failure. The rest explains it elsewhere, once.

    Registered where tests run, also where none are generated: custom tests are explained as well.
    """

    NAME = "hricdv-first-lines"

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, call: pytest.CallInfo[None]) -> Iterator[None]:
        """Before the report goes to anybody."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        crash = getattr(report.longrepr, "reprcrash", None)
        if crash is not None and call.excinfo is not None and hasattr(call.excinfo.value, _EXPLAINED):
            crash.message = crash.message.removeprefix("Failed: ").strip().partition("\n")[0]
        return report  # type: ignore[return-value]


def end_of(report: pytest.TestReport) -> FunctionEnd:
    """How pytest saw the test function end."""
    if report.outcome == "passed":
        return "returned"
    return "xfailed" if hasattr(report, "wasxfail") else "raised"


def failure_text(
    report: pytest.TestReport, call: pytest.CallInfo[None], outcome: TestOutcome, ending: Judgement | None
) -> str:
    """The text of a test that did not pass: of the judgement that ended it, or what pytest shows of the author's."""
    if outcome == "passed":
        return ""
    if outcome == "expected-failure":
        reason = report.wasxfail or NO_REASON
        is_call = call.excinfo is not None and call.excinfo.errisinstance(pytest.xfail.Exception)
        return reason if is_call else f"{reason}\n\n{report.longreprtext}"
    return ending.reason if ending is not None and outcome in XFAILED else cut(report.longreprtext)
