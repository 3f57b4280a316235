"""What a report says of the audit."""

from __future__ import annotations

from pytest_hricdv.extra.audit.records import AUDIT, UNREPEATABLE, sentence
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report, TestResult


class AuditView(View):
    """What ran again, what came otherwise, and why."""

    name = "audit"

    def section(self, report: Report) -> PageSection | None:
        """The tests that came otherwise, with their causes; in a merged report, of all sessions."""
        audit = AUDIT.of(report)
        rows = [(test, UNREPEATABLE.of(test)) for test in report.tests if UNREPEATABLE.of(test) is not None]
        if audit is None and not rows:
            return None
        values = {"audit": audit, "rows": rows}
        headline = f"{plural(len(rows), 'test')} not repeatable" if rows else ""
        return PageSection("repeatability", "Repeatability", "audit/audit.html.jinja", values, headline=headline)

    def facts(self, test: TestResult) -> dict[str, str]:
        """Why it is not repeatable."""
        record = UNREPEATABLE.of(test)
        return {"Repeatability": "" if record is None else sentence(record)}


VIEW = AuditView()
