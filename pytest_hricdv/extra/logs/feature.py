"""`LogsView`: the sections of a report on checked logs: requirements without data, and the comparison with tests.

`hricdv check` puts both into the report (`UNKNOWN`, `FLEET`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pytest_hricdv._base.record import Names, PlainRecord
from pytest_hricdv.report.view import PageSection, RequirementNote, View
from pytest_hricdv.results.section import Section, TestSection

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report, TestResult


class FleetComparison(PlainRecord, frozen=True, kw_only=True):
    """The comparison of logs with tests.

    Args:
        against: the report of the tests.
        only_tests: what tests cover and no log shows, a sentence each.
        only_logs: the reverse.
    """

    against: str
    only_tests: Names = ()
    only_logs: Names = ()


UNKNOWN: TestSection[Mapping[str, str]] = TestSection("unknown", Mapping[str, str], {})
"""Of a log: requirement -> why data for it are missing. It counts as not checked."""

FLEET: Section[FleetComparison | None] = Section("fleet", FleetComparison | None, None)
"""The comparison that `hricdv check --against` makes."""

TEST_SECTIONS = (UNKNOWN,)
SECTIONS = (FLEET,)


class LogsView(View):
    """The requirements that are unknown in each log, and the comparison with tests."""

    name = "logs"

    def section(self, report: Report) -> PageSection | None:
        """A view of its own."""
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
        """The requirements that are unknown in a log."""
        return {"Unknown": "; ".join(f"{name}: {why}" for name, why in UNKNOWN.of(test).items())}

    def of_requirement(self, report: Report, name: str) -> RequirementNote | None:
        """The number of logs in which a requirement is unknown."""
        count = sum(name in UNKNOWN.of(test) for test in report.tests)
        if not count:
            return None
        return RequirementNote("In", f"{count} of {len(report.tests)} logs", "it is unknown: data for it are missing.")


VIEW = LogsView()
