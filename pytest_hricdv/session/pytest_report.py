"""pytest's report of a test: what it says of the test's end, and its texts, each led by a line that stands alone."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TypeVar

import pytest

from pytest_hricdv._base.message import cut
from pytest_hricdv.execution.judge import FunctionEnd
from pytest_hricdv.execution.outcome import XFAILED, Judgement, TestOutcome

Raised = TypeVar("Raised", bound=BaseException)

NO_REASON = "xfail without a reason"

MAX_OUTPUT = 200_000
"""Characters of a test's failure, and of each of its outputs, that pytest is given (chosen: ten times what a result
keeps)."""

_EXPLAINED = "_hricdv_explained"
"""Attribute of an exception whose text is the plugin's, with a first line that stands alone."""


def cut_texts(report: pytest.TestReport) -> None:
    """Cut what the code under test has written: a terminal, JUnit's file and other processes get all of it."""
    report.sections[:] = [(name, cut(text, MAX_OUTPUT)) for name, text in report.sections]
    if not report.passed and not isinstance(report.longrepr, tuple) and report.longrepr is not None:
        text = report.longreprtext
        if len(text) > MAX_OUTPUT:
            report.longrepr = cut(text, MAX_OUTPUT)


def explained_by_us(error: Raised) -> Raised:
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
