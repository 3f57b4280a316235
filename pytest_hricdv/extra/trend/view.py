"""The trend on the page."""

from __future__ import annotations

from typing import Any

from msgspec import to_builtins

from pytest_hricdv.extra.trend.records import HISTORY, changes
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report


class TrendView(View):
    """How figures went over sessions."""

    name = "trend"
    scripts = ("trend",)

    def section(self, report: Report) -> PageSection | None:
        """What changed since the session before, and plots."""
        history = HISTORY.of(report)
        if not history:
            return None
        values = {"history": history, "changes": changes(history)}
        return PageSection("trend", "Trend", "trend/trend.html.jinja", values, "after suites")

    def data(self, report: Report) -> dict[str, Any]:
        """The sessions, for the plots."""
        return {"history": to_builtins(HISTORY.of(report))}


VIEW = TrendView()
