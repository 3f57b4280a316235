"""What tests fail for, and a line for each of them."""

from __future__ import annotations

import random

import pytest
from msgspec import convert
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.records import CAUSES, Cause, SuspiciousPlace
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.formatting import width
from pytest_hricdv.results.model import Report, TestResult
from tests.report import sample, sample_tests

PLACE = SuspiciousPlace(
    file="controller/states.py", line=58, function="discard", score=0.873, likely=True, text="self.hand.open()"
)


def failing(number: int, *names: str) -> TestResult:
    """A test that fails requirements."""
    made = sample_tests.test(random.Random(number), "rl")
    made["requirements"] = sample_tests.requirement_results(*names)
    result = convert({**made, "outcome": "failed"}, TestResult)
    return replace(result, replay=f"hri-report/failures/{result.id}.json")


def report_of(*tests: TestResult) -> Report:
    report = replace(sample.report(tests=0), tests=tests, known_violations={}, strict=False)
    first, *others = tests
    causes = (
        Cause(
            id="3f2a91bc",
            requirements=("R2", "R3"),
            tests=tuple(test.id for test in others),
            state="releasing",
            minimal=("tell leg", "disturb hand_held_shut", "receivesignal", "tell humanReady"),
            replay=others[0].replay,
            locations=(PLACE, PLACE),
            deciding_change="passes without the disturbance hand_held_shut: 2 of 2 tests were run without it",
        ),
        Cause(id="00000001", requirements=("R1",), tests=(first.id,), replay=first.replay),
    )
    return CAUSES.put(report, causes)


TESTS = (failing(1, "R1"), *(failing(number, "R2", "R3") for number in range(2, 20)))


def texts(report: Report, columns: int | None, *, all_rows: bool = False) -> list[str]:
    return [line.text for line in FailingTests.of(report, columns).lines(columns, all_rows=all_rows)]


def test_all_causes_come_with_a_line_for_each_test() -> None:
    lines = texts(report_of(*TESTS), None, all_rows=True)
    assert lines[0] == "cause 1 (3f2a91bc): R2, R3 in 18 tests, first in the state releasing"
    second = lines.index("cause 2 (00000001): R1 in 1 test")
    rows = [line for line in lines if line.endswith(".json") and "pytest" not in line]
    assert len(rows) == 19
    assert f"  {TESTS[3].id}  R2 R3  {TESTS[3].replay}" in rows
    assert f"  {TESTS[0].id}  R1  {TESTS[0].replay}" in lines[second:]


@pytest.mark.parametrize("columns", [40, 60, 80, 120, None])
def test_a_cause_says_where_why_what_and_how_to_repeat_it_in_lines_that_fit(columns: int | None) -> None:
    lines = texts(report_of(*TESTS), columns)
    second = next(number for number, line in enumerate(lines) if line.startswith("cause 2"))
    assert second <= 9
    assert len(lines) - second <= 6
    assert all(width(line) <= (columns or 999) for line in lines if "--hri-replay" not in line)
    labels = [line.split()[0] for line in lines[1:second] if line.startswith("  ") and line[2] != " "]
    assert list(dict.fromkeys(labels)) == ["where", "why", "what", "seen", "again", "also"]
    assert f"  again  pytest --hri-replay={TESTS[1].replay}" in lines


def test_a_test_is_listed_at_its_first_cause_and_named_with_all() -> None:
    report = report_of(*TESTS)
    first, second = CAUSES.of(report)
    report = CAUSES.put(report, (first, replace(second, tests=(TESTS[0].id, TESTS[1].id))))
    failing_tests = FailingTests.of(report)
    assert failing_tests.labels()[TESTS[1].nodeid] == "causes 1, 2"
    assert failing_tests.labels()[TESTS[0].nodeid] == "cause 2"
    assert sum(line.text.startswith(f"  {TESTS[1].id} ") for line in failing_tests.lines(None, all_rows=True)) == 1
    assert failing_tests.examples == [TESTS[1].nodeid, TESTS[0].nodeid]


def test_of_thousands_of_tests_some_are_named_unless_all_are_asked_for() -> None:
    tests = [failing(number, "R2") for number in range(100, 300)]
    report = report_of(*tests)
    assert "  also   " in "".join(texts(report, 80))
    assert any(line.endswith(" more") for line in texts(report, 80))
    assert sum(line.endswith(".json") and "pytest" not in line for line in texts(report, None, all_rows=True)) == 200
