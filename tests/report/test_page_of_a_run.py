"""The run of one test on its page: lanes and signals over time, and a cursor."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report.tests_view import anchor
from tests.report import sample
from tests.report.watched import Watched

pytestmark = pytest.mark.slow

LANES = "#test .timeline svg[aria-label^=Messages] [aria-label='y-axis tick label'] text"


def _failing(tests: int = 60) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """A report whose R3 has a limit, and its tests that fail R3, at 51.5 s."""
    report = sample.data(tests=tests)
    report["requirements"]["R3"] |= {
        "reads": ["arm_speed", "reading.gaze"],
        "limits": [{"name": "arm_speed", "relation": "<", "value": 0.25}],
    }
    return report, [test for test in report["tests"] if _fails(test["requirements"]["R3"])]


def _fails(verdict: dict[str, Any]) -> bool:
    return bool(verdict["verdict"] == "Failed")


def _address(test: dict[str, Any]) -> str:
    return f"test/{anchor(test['nodeid'])}"


def _cursor(page: Any) -> float:
    return float(page.get_by_role("slider").get_attribute("aria-valuenow"))


def test_a_failing_test_opens_at_its_violation_with_the_lanes_of_what_failed(watched: Watched, tmp_path: Path) -> None:
    report, (test, *_) = _failing()
    page = watched.open_test(report, tmp_path, _address(test))
    first = page.locator("#test .card").first.inner_text()
    assert first.startswith("R3 failed known at 51.5 s")
    assert "The robot shall not close its hand" in first
    assert _cursor(page) == 51.5
    assert "R3 failed" in (page.get_by_role("slider").get_attribute("aria-valuetext") or "")
    assert page.locator("#test .tools output").inner_text() == "40.0 s to 60.0 s of 60.0 s"
    assert set(page.locator(LANES).all_text_contents()) == {"state", "reading", "R3"}
    speed = page.locator("#test .timeline svg[aria-label^=arm_speed]")
    assert "R3: < 0.25" in speed.locator("text").all_text_contents()
    page.get_by_role("button", name="more lanes").click()
    assert {"request", "leg_held", "R4"} < set(page.locator(LANES).all_text_contents())
    page.get_by_role("button", name="Only lanes of failed requirements").click()
    assert set(page.locator(LANES).all_text_contents()) == {"state", "reading", "R3"}
    watched.assert_quiet()


def test_a_failing_test_names_its_cause_and_can_be_copied_as_an_issue(watched: Watched, tmp_path: Path) -> None:
    report, (test, *_) = _failing()
    test["outcome"] = "failed"
    report["causes"] = [{"id": "0a", "requirements": ["R3"], "tests": [test["id"]], "minimal": test["abstract"]}]
    page = watched.open_test(report, tmp_path, _address(test))
    page.evaluate(
        "() => { navigator.clipboard.writeText = (text) => { window.copied = text; return Promise.resolve(); }; }"
    )
    card = page.locator("#test .failed")
    assert "pytest " in card.locator(".command pre").inner_text()
    card.get_by_role("button", name="Copy as issue").click()
    card.get_by_role("button", name="Copied").wait_for()
    issue = page.evaluate("() => window.copied")
    for text in (f"## R3 fails in {test['id']}", "### Steps", "### Expected", "### Seen", "### Cause", "### Repeat"):
        assert text in issue
    assert test["abstract"][0] in issue
    card.locator("a", has_text="cause 1").click()
    page.wait_for_selector("#causes:not([hidden])")
    watched.assert_quiet()


def test_the_code_is_shown_where_it_stands_at_the_cursor(watched: Watched, tmp_path: Path) -> None:
    report, (test, *_) = _failing()
    test["executed_lines"] = {
        "files": ["controller/states.py", "controller/journal.py"],
        "bursts": ["0:40 41 42 1:9", "0:90"],
        "nodes": ["0 0 3 1 4 0"],
        "from_s": 0.0,
        "until_s": 20.0,
    }
    page = watched.open_test(report, tmp_path, f"{_address(test)}@3.5")
    code = page.locator("#test .code-at")
    assert "controller/states.py:90" in code.inner_text()
    assert code.locator("[aria-current=true]").inner_text() == "state(90)"
    page.keyboard.press("ArrowLeft")
    assert _cursor(page) == 3.0
    page.keyboard.press("ArrowLeft")
    assert code.locator("[aria-current=true]").inner_text() == "line(9)"
    page.keyboard.press("v")
    assert "its lines were kept from 0.00 s to 20.0 s only" in code.inner_text()
    watched.assert_quiet()


def test_the_nearest_passing_run_is_beside_it_and_what_differs_is_marked(watched: Watched, tmp_path: Path) -> None:
    report, (test, other, *_) = _failing()
    for failing in (test, other):
        failing["outcome"] = "failed"
    timeline = deepcopy(test["timeline"])
    timeline["messages"][3] = '3\trobot\tstate\t{"name":"Give up"}'
    timeline["triggers"]["R3"] = "1-2 41.25-51.5"
    neighbour = {"timeline": timeline, "abstract": test["abstract"], "begun": [[0.5, 0]]}
    decision = {
        "words": "without the action 2",
        "kind": "action",
        "test": test["id"],
        "runs": 3,
        "neighbour": neighbour,
    }
    report["causes"] = [
        {"id": "0a", "requirements": ["R3"], "tests": [test["id"], other["id"]], "minimal_pair": decision}
    ]
    page = watched.open_test(report, tmp_path, _address(test))
    beside = page.locator("#test .other").inner_text()
    assert "The nearest passing run: passes without the action 2" in beside
    assert "here state Done (3.00 s), there state Give up (3.00 s)" in beside
    assert page.locator("#test .values .differs th").all_inner_texts() == ["state", "R3"]
    page.get_by_role("button", name="at 3.00 s").click()
    assert _cursor(page) == 3.0
    watched.show(_address(other))
    page.get_by_text("The deciding change was searched for in").get_by_role("link").click()
    page.wait_for_function("id => document.querySelector('#test h2').textContent.includes(id)", arg=test["id"])
    watched.assert_quiet()
