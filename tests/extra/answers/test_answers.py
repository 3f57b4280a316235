"""Answers about a report: small, with stable keys, and located errors."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_hricdv.extra.answers.answers import MAX_ITEMS, ask
from pytest_hricdv.report.__main__ import main
from pytest_hricdv.report.files import write
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report
from tests.report import sample

REPORT = sample.report(tests=4)


def test_the_status_counts_tests_and_verdicts() -> None:
    status = ask(REPORT, "status")
    assert sum(status["tests"].values()) == 4
    assert set(status["requirements"]) == set(REPORT.requirements)
    assert status["failed"] is any(test.fails for test in REPORT.tests)
    assert set(status["percent"]) == {"statements", "branches", "plans"}


def test_a_test_has_its_actions_and_verdicts() -> None:
    first = REPORT.tests[0]
    for name in (first.id, first.nodeid):
        found = ask(REPORT, "test", name)
        assert [action["line"] for action in found["actions"]] == [*first.abstract]
        assert set(found["verdicts"]) == set(first.requirements)


def test_a_requirement_has_the_test_with_the_least_margin() -> None:
    found = ask(REPORT, "requirement", "R4")
    margins = {test.id: test.requirements["R4"].margin for test in REPORT.tests}
    least = found["least_margin"]
    assert least["margin"] == margins[least["test"]] == min(value for value in margins.values() if value is not None)
    assert sum(found["verdicts"].values()) == 4


def test_lists_are_cut_and_say_so() -> None:
    data = sample.data(tests=1)
    gap = {
        "kind": "plans",
        "location": "human",
        "items": ["p"],
        "reason": "",
        "suggestion": "",
        "test": "",
        "beliefs": [],
    }
    data["closure"]["gaps"] = [gap] * (MAX_ITEMS + 1)
    found = ask(sample.typed(data), "open")
    assert (found["total"], len(found["items"])) == (MAX_ITEMS + 1, MAX_ITEMS)


@pytest.mark.parametrize(
    ("what", "name", "says"),
    [
        ("all", "", "no such question: all; expected status, causes, open, changes, test NAME"),
        ("test", "", "test: expected a name"),
        ("test", "x", "no test 'x' in the report, which has rl-"),
        ("requirement", "R99", "which has R1, R2, R3, R4"),
        ("coverage", "x.py", "no file 'x.py'"),
        ("status", "x", "no such question: status x"),
        ("changes", "", "was not compared"),
    ],
)
def test_what_cannot_be_answered_says_what_can(what: str, name: str, says: str) -> None:
    with pytest.raises(ReportError, match=says):
        ask(REPORT, what, name)


def test_the_command_prints_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report: Report = REPORT
    write(report, tmp_path)
    assert main(["query", str(tmp_path), "coverage", report.code_under_test.files[0].file]) == 0
    assert json.loads(capsys.readouterr().out)["file"] == report.code_under_test.files[0].file
    assert main(["query", str(tmp_path), "nothing"]) == 2
