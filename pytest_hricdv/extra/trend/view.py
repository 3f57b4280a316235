"""The trend on the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec import to_builtins

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.trend.records import HISTORY, changed_causes, changes
from pytest_hricdv.report.formatting import Line
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report


class TrendView(View):
    """How figures went over sessions."""

    name = "trend"
    scripts = ("trend",)

    def findings(self, report: Report) -> Iterator[Line]:
        """Causes that are new, that were there before, and that are gone."""
        for text in changed_causes(HISTORY.of(report)):
            yield Line(visible(f"trend: {text}"), "ok" if text.startswith("gone") else "warn")

    def section(self, report: Report) -> PageSection | None:
        """What changed since the session before, and plots."""
        history = HISTORY.of(report)
        if not history:
            return None
        values = {"history": history, "changes": changes(history)}
        return PageSection("trend", "Trend", "trend/trend.html.jinja", values)

    def data(self, report: Report) -> dict[str, Any]:
        """The sessions, for the plots."""
        return {"history": to_builtins(HISTORY.of(report))}


VIEW = TrendView()
