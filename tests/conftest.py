"""How many examples the property tests make up: few in `make test`, many in `make slow`."""

from __future__ import annotations

import os
import sys

import pytest

if sys.version_info >= (3, 14):
    os.environ.setdefault("COVERAGE_CORE", "ctrace")  # the default from there on knows no contexts

FEW, MANY = 30, 200


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
