"""Browser pages for tests of lanes."""

from __future__ import annotations

from tests.report.conftest import browser, watched

__all__ = ["browser", "watched"]
