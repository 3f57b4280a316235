"""The user's project that the plugin is tested on, written into a fresh folder for each test."""

from __future__ import annotations

import pytest

# What a suite loads is loaded here once: runs in this process then find it, instead of loading it once each.
import pytest_hricdv.generate.explorer
import pytest_hricdv.monitor.elaborate
import pytest_hricdv.monitor.parser
import pytest_hricdv.report.html
import pytest_hricdv.reporting  # noqa: F401
from tests.plugin import project


@pytest.fixture
def lamps(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A `pytester` in whose folder the lamps project lies; its runs see nothing of the run they are part of."""
    for name in ("PY_COLORS", "FORCE_COLOR", "NO_COLOR", "COLUMNS", "PYTEST_ADDOPTS", "PYTEST_XDIST_WORKER"):
        monkeypatch.delenv(name, raising=False)
    project.write(pytester.path)
    return pytester
