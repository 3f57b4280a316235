"""The trend on the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import to_builtins

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.trend.records import HISTORY, HistoryEntry, changed_causes, changes
from pytest_hricdv.report.formatting import Line, plural
from pytest_hricdv.report.tests_view import anchor
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
        texts = changes(history)
        values = {
            "history": history,
            "meaning": meaning(history, len(texts)),
            "changes": [_named(text) for text in texts],
            "anchors": {test.id: anchor(test.nodeid) for test in report.tests},
        }
        return PageSection("trend", "Trend", "trend/trend.html.jinja", values)

    def data(self, report: Report) -> dict[str, Any]:
        """The sessions, for the plots."""
        return {"history": to_builtins(HISTORY.of(report))}


VIEW = TrendView()


def meaning(history: Sequence[HistoryEntry], changed: int) -> str:
    """`Since the session before, 2 tests fail that did not; 3 differences in all.`.

    Args:
        history: the sessions, this one last.
        changed: so many differences since the session before are listed.
    """
    if len(history) < 2:
        return "This is the first session of these suites and options: there is none to compare it with."
    if not changed:
        return "Since the session before, nothing but times changed."
    before, now = (set(entry.failing) for entry in history[-2:])
    counts = [(len(now - before), "that did not"), (len(before - now), "no longer")]
    parts = [f"{plural(count, 'test')} {'fails' if count == 1 else 'fail'} {words}" for count, words in counts if count]
    failing = ", ".join(parts) or "no test came to fail"
    return f"Since the session before, {failing}; {plural(changed, 'difference')} in all."


def _named(text: str) -> tuple[str, str]:
    """A sentence of `changes` without the test that it ends with, and this; empty where it is of none."""
    what, separator, name = text.partition(": ")
    return (f"{what}: ", name) if separator and what in ("fails now", "fails no longer") else (text, "")
