"""What a report says of the graph of ROS 2: each sentence once."""

from __future__ import annotations

import json

from pytest_hricdv.extra.ros2.feature import NOTES, VIEW
from pytest_hricdv.report import html, terminal
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.model import Report
from tests import json_schema
from tests.report import sample
from tests.report.parsed import Page

_NOTE = "/map: no message goes from /mapper to /planner"


def _report(noted: int) -> Report:
    data = sample.data(tests=3)
    for test in data["tests"][:noted]:
        test["ros2_notes"] = [_NOTE]
    return sample.typed(data)


def test_a_note_is_said_once_with_the_number_of_its_tests() -> None:
    report = _report(2)
    assert [line.text for line in terminal.findings(report)].count(f"ROS 2, in 2 tests: {_NOTE}") == 1
    words = " ".join(Page(html.page(report)[0]).words.split())
    assert words.count(f"{_NOTE} ( 2 tests )") + words.count(f"{_NOTE} (2 tests)") == 1
    assert VIEW.facts(report.tests[0]) == {"ROS 2": _NOTE}


def test_a_report_without_notes_has_no_such_key_and_no_section() -> None:
    report = _report(0)
    assert VIEW.section(report) is None
    assert not any("ros2_notes" in test for test in json.loads(encode(report))["tests"])


def test_its_key_is_in_the_schema() -> None:
    written = json.loads(encode(_report(1)))
    json_schema.REPORT.validate(written)
    assert NOTES.of(_report(1).tests[0]) == (_NOTE,)
    assert [test.get("ros2_notes") for test in written["tests"]] == [[_NOTE], None, None]
