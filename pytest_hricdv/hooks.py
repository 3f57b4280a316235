"""The hook that a project implements: it returns the testbench."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pytest_hricdv.testbench import Testbench

__all__ = ["pytest_hricdv_testbench"]

HOOK = "pytest_hricdv_testbench"
"""The name of the hook."""


@pytest.hookspec(firstresult=True)
def pytest_hricdv_testbench(config: pytest.Config) -> Testbench | None:
    """Return the project's testbench: models, belief space, ranges, requirements, code under test, and how to run it.

    Implement it in a conftest.py. It is called once per process, and only when a suite is active. Keep imports of the
    simulator and of the code under test inside the testbench's `run`, so that generating tests stays light and import
    lines are measured.
    """
