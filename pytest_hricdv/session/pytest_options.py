"""What pytest's own options, and plugins that are switched off, mean for a session with generated tests."""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterable
from pathlib import Path

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.usage import usage_error

_RUNNING_NOTHING = ("collectonly", "setuponly", "setupplan")


def runs_tests(config: pytest.Config) -> bool:
    """Whether tests are called: not with --collect-only, --setup-only and --setup-plan, which only show something."""
    return not any(getattr(config.option, name, False) for name in _RUNNING_NOTHING)


def refuse_break(config: pytest.Config, options: Options) -> None:
    """Raise pytest.UsageError where --hri-break has no debugger."""
    if options.stop_at and not config.pluginmanager.hasplugin("debugging"):
        raise usage_error("--hri-break: pytest's debugger is switched off: leave -p no:debugging out")


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
    """What failed a session, on standard error, where pytest's terminal is off: nothing else would say it."""
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
