"""What a report says of the ROS 2 systems of its runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.ros2.records import NOTES
from pytest_hricdv.report.formatting import Line, plural
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report, TestResult


class Ros2View(View):
    """What is to be known of the graphs of the runs, each sentence once."""

    name = "ros2"

    def findings(self, report: Report) -> Iterator[Line]:
        """The sentences, with the number of tests that they are of."""
        for sentence, tests in _notes(report).items():
            yield Line(visible(f"ROS 2, in {plural(tests, 'test')}: {sentence}"), "warn")

    def section(self, report: Report) -> PageSection | None:
        """The same, on the page."""
        notes = _notes(report)
        if not notes:
            return None
        values = {"notes": [{"text": sentence, "tests": tests} for sentence, tests in notes.items()]}
        return PageSection("ros2", "ROS 2", "ros2/ros2.html.jinja", values)

    def facts(self, test: TestResult) -> dict[str, str]:
        """Those of a test."""
        return {"ROS 2": "; ".join(NOTES.of(test))}


VIEW = Ros2View()


def _notes(report: Report) -> Counter[str]:
    """Sentence -> of how many tests it is, in the order of the tests."""
    return Counter(sentence for test in report.tests for sentence in NOTES.of(test))
