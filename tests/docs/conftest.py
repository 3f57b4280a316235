"""The browser of the tests of the report's page, for the documentation's search."""

from tests.report.conftest import browser

__all__ = ["browser"]
