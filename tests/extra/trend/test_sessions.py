"""The history of sessions: a line each, and the trend that a report makes of it."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests import json_schema
from tests.plugin.project import change, report

SUITE = ("--hri-suite=by-hand", "-p", "no:xdist", "--hri-history=kept/history.jsonl")


def lines(lamps: pytest.Pytester) -> list[dict[str, Any]]:
    text = (lamps.path / "kept" / "history.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.slow
def test_each_session_adds_a_line_and_the_report_has_those_that_can_be_compared(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(*SUITE)
    lamps.runpytest_inprocess(*SUITE, "-k", "hall")
    lamps.runpytest_inprocess(*SUITE, "--hri-seed=3")
    lamps.runpytest_inprocess(*SUITE)
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    kept = lines(lamps)
    assert [each.get("complete", True) for each in kept] == [True, False, True, True]
    assert written["history"] == [kept[0], kept[3]]
    (suite,) = written["suites"]
    tally = suite["requirements"]["R2"]
    assert kept[3]["requirements"]["R2"] == {name: tally[name] for name in ("passed", "failed", "nc", "triggers")}
    assert kept[3]["statements"] == suite["code"]["statements"]["percent_reachable"]
    assert kept[3]["outcomes"] == {"known-violation": 1, "passed": 3}


@pytest.mark.slow
def test_the_page_says_what_changed_since_the_session_before(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(*SUITE)
    page = lamps.path / "hri-report" / "index.html"
    assert "there is none to compare it with" in page.read_text(encoding="utf-8")
    lamps.runpytest_inprocess(*SUITE)
    assert "nothing but times changed" in page.read_text(encoding="utf-8")
    change(lamps.path, "lamps/guide.py", "            bus.publish(Answer())\n", "            pass\n")
    lamps.runpytest_inprocess(*SUITE, "--hri-diagnose=48")
    text = page.read_text(encoding="utf-8")
    assert "Since the session before, 2 tests fail that did not; 4 differences in all." in text
    assert text.count('fails now: <a class="mono" href="#test/') == 2
    assert "R3: failed 0 -&gt; 2, not checked 2 -&gt; 2" in text


@pytest.mark.slow
def test_a_damaged_line_is_named_and_a_torn_one_does_not_take_the_next_along(
    lamps: pytest.Pytester,
) -> None:
    lamps.runpytest_inprocess(*SUITE)
    path = lamps.path / "kept" / "history.jsonl"
    path.write_text("[" * 99_999 + "\n" + path.read_text(encoding="utf-8") + '{"began": "20', encoding="utf-8")
    result = lamps.runpytest_inprocess(*SUITE)
    for number in (1, 3):
        result.stdout.fnmatch_lines([f"*history.jsonl:{number}: not a session of a history, so it was left out"])
    assert len(report(lamps.path)["history"]) == 2


@pytest.mark.slow
def test_one_that_cannot_be_written_fails_the_session(lamps: pytest.Pytester) -> None:
    (lamps.path / "kept").write_text("in the way", encoding="utf-8")
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED --hri-history: *kept/history.jsonl: File exists"])
    assert report(lamps.path)["reported"] == 4


def test_a_file_of_something_else_is_refused_and_stays(lamps: pytest.Pytester) -> None:
    before = (lamps.path / "conftest.py").read_bytes()
    result = lamps.runpytest_inprocess(*SUITE[:-1], "--hri-history=conftest.py")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-history: *conftest.py is not a history file*"])
    assert (lamps.path / "conftest.py").read_bytes() == before
