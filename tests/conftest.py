"""How many examples property tests make up, few in `make test`, many in `make slow`, and which tests are left out."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec

import pytest

if sys.version_info >= (3, 14):
    os.environ.setdefault("COVERAGE_CORE", "ctrace")  # the default from there on knows no contexts

FEW, MANY = 30, 100

OPTIONAL = ("mujoco", "pybullet", "rclpy")
"""Modules without which tests of an engine, or of ROS 2, are not collected or skipped."""


def pytest_configure(config: pytest.Config) -> None:
    """Sets Hypothesis's profiles; not where a suite is run, which would wait for Hypothesis to load.

    No example has a deadline: how long it takes depends on what else the machine does.
    """
    if config.getoption("hri_suite") or not config.pluginmanager.hasplugin("hypothesispytest"):
        return
    from hypothesis import settings

    for name in ("default", "ci"):
        settings.register_profile(name, settings.get_profile(name), max_examples=FEW, deadline=None)
    settings.register_profile("thorough", settings.get_profile("ci"), max_examples=MANY)


@pytest.fixture
def pytester(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """Runs pytest without the plugins for other reports, which only `tests/plugin/test_attachments.py` needs.

    They take long to load, in each process of each run.
    """
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p no:html -p no:metadata -p no:allure_pytest")
    return pytester


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> Iterator[None]:
    """Says before pytest's last line which tests did not run, and why."""
    try:
        return (yield)
    finally:
        if not config.getoption("hri_suite"):
            reasons = Counter(_reason(report) for report in terminalreporter.stats.get("skipped", ()))
            texts = [f"{reason}: {count}" for reason, count in reasons.most_common()]
            slow = ["slow tests: make slow"] if config.getoption("markexpr") == "not slow" else []
            missing = [f"{name}: not installed" for name in OPTIONAL if find_spec(name) is None]
            if left_out := [*slow, *missing, *texts]:
                terminalreporter.write_line(f"left out: {'; '.join(left_out)}")


def _reason(report: pytest.TestReport) -> str:
    """Why a test was skipped, in one line."""
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext
    return " ".join(text.removeprefix("Skipped: ").split())
