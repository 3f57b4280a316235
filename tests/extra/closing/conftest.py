"""The browser of the page's tests, for the closing loop's plots."""

from __future__ import annotations

from tests.report.conftest import browser, watched

__all__ = ["browser", "watched"]
