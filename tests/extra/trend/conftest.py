"""Browser pages for tests of the trend."""

from __future__ import annotations

from tests.report.conftest import browser, watched

__all__ = ["browser", "watched"]
