"""Shows notes on the ROS graph of a run, such as QoS profiles that do not match. Notes fail no test.

`Ros2Feature` (`FEATURE` of the registry) adds the notes of each run to its test's result, and `Ros2View` shows all of
them in the terminal and on the page.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import visible
from pytest_hricdv._base.record import Names
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.section import TestSection
from pytest_hricdv.session.feature import Feature

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult
    from pytest_hricdv.report.formatting import Line
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

NOTES: TestSection[Names] = TestSection("ros2_notes", Names, ())
"""The notes of a test, a sentence each, such as on a publisher and a subscription whose QoS does not match."""

TEST_SECTIONS = (NOTES,)


class Ros2Feature(Feature[None]):
    """Keeps the notes of each run with its result; has no options."""

    name = "ros2"

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """Add the notes of the run."""
        return NOTES.put(result, run.notes) if run.notes else result


FEATURE = Ros2Feature()


class Ros2View(View):
    """The notes of all runs."""

    name = "ros2"

    def findings(self, report: Report) -> Iterator[Line]:
        """Each note once, with the number of tests that have it."""
        from pytest_hricdv.report.formatting import Line, plural

        for sentence, tests in _notes(report).items():
            yield Line(visible(f"ROS 2, in {plural(tests, 'test')}: {sentence}"), "warn")

    def section(self, report: Report) -> PageSection | None:
        """The notes on the page."""
        notes = _notes(report)
        if not notes:
            return None
        values = {"notes": [{"text": sentence, "tests": tests} for sentence, tests in notes.items()]}
        return PageSection("ros2", "ROS 2", "ros2/ros2.html.jinja", values)

    def facts(self, test: TestResult) -> dict[str, str]:
        """The notes of a test."""
        return {"ROS 2": "; ".join(NOTES.of(test))}


VIEW = Ros2View()


def _notes(report: Report) -> Counter[str]:
    """Sentence -> of how many tests it is, in the order of the tests."""
    return Counter(sentence for test in report.tests for sentence in NOTES.of(test))
