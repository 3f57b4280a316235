"""What a report has of checked logs, and how its page shows it: what is unknown, and how logs compare with tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pytest_hricdv._base.record import Names, PlainRecord
from pytest_hricdv.report.view import PageSection, RequirementNote, View
from pytest_hricdv.results.section import Section, TestSection

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report, TestResult


class FleetComparison(PlainRecord, frozen=True, kw_only=True):
    """How logs compare with tests.

    Args:
        against: the report of the tests.
        only_tests: what tests cover and no log shows, a sentence each.
        only_logs: the other way round.
    """

    against: str
    only_tests: Names = ()
    only_logs: Names = ()


UNKNOWN: TestSection[Mapping[str, str]] = TestSection("unknown", Mapping[str, str], {})
"""Of a log: requirement -> why nobody knows whether it holds, as there are no data. It counts as not checked."""

FLEET: Section[FleetComparison | None] = Section("fleet", FleetComparison | None, None)

TEST_SECTIONS = (UNKNOWN,)
SECTIONS = (FLEET,)


class LogsView(View):
    """Gaps of each log, and what only tests or only logs show."""

    name = "logs"

    def section(self, report: Report) -> PageSection | None:
        """All of it, beside the other views."""
        from pytest_hricdv.report.tests_view import anchor

        logs, fleet = [test for test in report.tests if test.suite == "logs"], FLEET.of(report)
        unknown = {test.id: dict(UNKNOWN.of(test)) for test in logs if UNKNOWN.of(test)}
        if not logs or not (unknown or fleet):
            return None
        values = {
            "logs": len(logs),
            "names": {test.id: test.name for test in logs},
            "unknown": unknown,
            "fleet": fleet,
            "anchors": {test.id: anchor(test.nodeid) for test in logs},
        }
        return PageSection("logs", "Logs", "logs/logs.html.jinja", values)

    def facts(self, test: TestResult) -> Mapping[str, str]:
        """What is unknown of a log."""
        return {"Unknown": "; ".join(f"{name}: {why}" for name, why in UNKNOWN.of(test).items())}

    def of_requirement(self, report: Report, name: str) -> RequirementNote | None:
        """In how many logs a requirement is unknown."""
        count = sum(name in UNKNOWN.of(test) for test in report.tests)
        if not count:
            return None
        return RequirementNote("In", f"{count} of {len(report.tests)} logs", "it is unknown: they lack data for it.")


VIEW = LogsView()
