"""The verdict on a whole report, in a line."""

from __future__ import annotations

from typing import Any

import pytest

from pytest_hricdv.report.verdict import failure_groups, verdict
from tests.report import sample, sample_tests


def _report(*outcomes: str) -> dict[str, Any]:
    report = sample.data(tests=len(outcomes))
    for number, (test, outcome) in enumerate(zip(report["tests"], outcomes, strict=True)):
        test |= {"outcome": outcome, "id": f"rl-{number}", "nodeid": f"tests/a.py::t[rl-{number}]"}
        failed = {"failed": "R2", "known-violation": "R3"}.get(outcome)
        for name in test["requirements"]:
            verdict = "Failed" if name == failed else "Passed"
            test["requirements"][name] = sample_tests.requirement_result(verdict, 0.1)
    return report


@pytest.mark.parametrize(
    ("outcomes", "text", "style"),
    [
        (["passed"] * 3, "passed: 3 tests", "ok"),
        (["passed", "known-violation"], "passed: 1 test; 1 test known to fail", "ok"),
        (["known-violation"] * 2, "no test passed: 2 tests known to fail", "warn"),
        (["failed", "error", "passed"], "failed: 2 tests", "bad"),
        (["failed", "known-violation", "known-violation"], "failed: 1 test; 2 known", "bad"),
        (["not-run", "passed"], "failed: 1 test without a result", "bad"),
        ([], "nothing ran", "warn"),
    ],
)
def test_the_verdict_stands_alone(outcomes: list[str], text: str, style: str) -> None:
    judged = verdict(sample.typed(_report(*outcomes)))
    assert (judged.text, judged.style) == (text, style)


def test_known_and_new_violations_of_one_requirement_are_never_one_finding() -> None:
    report = _report("failed", "known-violation", "known-violation")
    for test in report["tests"]:
        test["requirements"]["R3"] = sample_tests.requirement_result("Failed", 0)
    report["tests"][0]["requirements"]["R3"]["violations"][0]["outside"] = True
    groups = [group for group in failure_groups(sample.typed(report)) if group.requirement == "R3"]
    assert [(group.is_known, [test.id for test in group.tests]) for group in groups] == [
        (False, ["rl-0"]),
        (True, ["rl-1", "rl-2"]),
    ]
    judged = verdict(sample.typed(report))
    assert all(test.outcome == "failed" for group in judged.new for test in group.tests)
