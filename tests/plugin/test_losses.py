"""Runs that do not come to their end: an exception, a skip, a crash, a stop. The report accounts for every test."""

from __future__ import annotations

from collections import Counter

import pytest

from tests import json_schema
from tests.plugin.project import change, in_each_mode, outcomes, report

SUITE = "--hri-suite=by-hand"  # four tests, of which one wishes for level 10


def write_dimmed(lamps: pytest.Pytester, body: str) -> None:
    """Let the guide do something else when it is to dim the lamp."""
    change(lamps.path, "lamps/guide.py", "return 10.0", body)


@in_each_mode
def test_an_exception_in_the_code_under_test_fails_its_test_only(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    write_dimmed(lamps, 'raise ConnectionError("lamp unplugged")')
    result = lamps.runpytest_inprocess(SUITE, *options)
    assert result.ret == 1
    result.assert_outcomes(passed=2, xfailed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "conftest.py:*: in robot",
            "lamps/guide.py:*: in serve",
            '>       raise ConnectionError("lamp unplugged")',
            "E       ConnectionError: lamp unplugged",
            "E       guide failed at *.* s: ConnectionError: lamp unplugged; nothing was checked",
            "E       what the human did (abstract test by-hand-hall-curt-*",
            "E         set_lamp level = 10",
            "E       run it again:",
            'E         pytest "test_lamps.py::test_lamps[[]by-hand-hall-curt-*[]]" --hri-suite=by-hand --hri-seed=0',
            "lamps/guide.py:40: ConnectionError",
            "tests: 2 passed, 1 known to fail, 1 in error",
        ]
    )
    result.stdout.no_fnmatch_line("*pytest_hricdv/*")
    written = report(lamps.path)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 4, 0)
    (broken,) = [test for test in written["tests"] if test["outcome"] == "error"]
    assert {verdict["verdict"] for verdict in broken["requirements"].values()} == {"NC"}
    assert (broken["plans"], broken["code"]) == ({}, None)
    assert "ConnectionError: lamp unplugged" in broken["failure"]


def test_full_trace_shows_the_frames_of_the_plugin(lamps: pytest.Pytester) -> None:
    write_dimmed(lamps, 'raise ConnectionError("lamp unplugged")')
    result = lamps.runpytest_inprocess(SUITE, "--full-trace", "-k", "curt")
    result.stdout.fnmatch_lines(["*pytest_hricdv/runtime/kernel.py:*"])


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        ("lamps/guide.py", "clock.sleep(SWITCHING_S)", "clock.sleep(-1)", "*cannot wait for -1 s*"),
        ("lamps/guide.py", "bus.publish(Answer())", "bus.publish(3)", "*TypeError: int is not a message of this bus*"),
        ("conftest.py", '"lamp_level", level', '"lamplevel", level', "*signal 'lamplevel' is recorded but not*"),
        ("conftest.py", '"lamp_level", level', '"lamp_level", float("nan")', "*expected a finite number*"),
        ("conftest.py", "    return Outcome(", "    Outcome(", "*run returned None; expected a pytest_hricdv*Outcome*"),
        ("conftest.py", 'outcomes=("released",)', "outcomes=(1,)", "*outcomes is (1,); expected a tuple of texts"),
        (
            "conftest.py",
            'outcomes=("released",)',
            'skipped_s=float("nan")',
            "*Outcome: skipped_s is nan; expected a time in seconds",
        ),
        ("conftest.py", 'levels or ["none"]', '["99"]', "*cross product 'light': ('hall', '99') is no bin*"),
    ],
    ids=[
        "negative sleep",
        "undeclared message",
        "undeclared signal",
        "NaN",
        "no outcome",
        "number as outcome",
        "NaN as time",
        "no bin",
    ],
)
def test_misuse_of_the_runtime_is_told_at_the_users_own_line(
    lamps: pytest.Pytester, name: str, old: str, new: str, told: str
) -> None:
    change(lamps.path, name, old, new)
    result = lamps.runpytest_inprocess(SUITE, "-k", "hall-polite")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([told, "E * run it again:", "*.py:*: *"])
    result.stdout.no_fnmatch_line("*pytest_hricdv/*")
    assert list(outcomes(lamps.path).values()) == ["error"]


@in_each_mode
def test_a_skipped_test_was_not_run(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    write_dimmed(lamps, '__import__("pytest").skip("no lamp today")')
    result = lamps.runpytest_inprocess(SUITE, *options)
    assert result.ret == 0
    result.assert_outcomes(passed=2, xfailed=1, skipped=1)
    written = report(lamps.path)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 3, 1)
    (skipped,) = [test for test in written["tests"] if test["outcome"] == "not-run"]
    assert "no lamp today" in skipped["failure"]


def test_a_test_whose_fixture_fails_was_not_run(lamps: pytest.Pytester) -> None:
    change(
        lamps.path,
        "test_lamps.py",
        "def test_lamps(hri_case):",
        "import pytest\n\n\n@pytest.fixture\ndef power():\n    assert 230 == 0\n\n\ndef test_lamps(hri_case, power):",
    )
    result = lamps.runpytest_inprocess(SUITE)
    result.assert_outcomes(errors=4)
    written = report(lamps.path)
    assert written["not_run"] == len(written["not_run_tests"]) == 4
    assert all("assert 230 == 0" in test["failure"] for test in written["tests"])


def test_a_crashed_worker_loses_its_test_only_and_the_report_says_so(lamps: pytest.Pytester) -> None:
    write_dimmed(lamps, '__import__("os")._exit(3)')
    result = lamps.runpytest_subprocess(SUITE, "-n", "2")
    assert result.ret == 1
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 3, 1)
    assert written["workers"] == 2
    assert Counter(test["outcome"] for test in written["tests"]) == {"passed": 2, "known-violation": 1, "not-run": 1}
    (lost,) = [test for test in written["tests"] if test["outcome"] == "not-run"]
    assert written["not_run_tests"] == [lost["nodeid"]]
    assert "crashed while running" in lost["failure"]
    for tally in written["suites"][0]["requirements"].values():
        assert tally["passed"] + tally["failed"] + tally["nc"] == 4
    told = ["expected 4, reported 3: 1 test not run or lost, totals are lower bounds", "  not run: test_lamps.py::*"]
    result.stdout.fnmatch_lines(told)


@in_each_mode
def test_a_run_stopped_at_the_first_failure_leaves_its_report(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=rl", "--hri-strict", "-x", *options)
    assert result.ret in (1, 2)
    written = report(lamps.path)
    assert written["selected"] == 34
    assert 1 <= written["reported"] < 34
    assert written["reported"] + written["not_run"] == 34
    assert "failed" in outcomes(lamps.path).values()


def test_a_run_that_is_interrupted_leaves_its_report(lamps: pytest.Pytester) -> None:
    write_dimmed(lamps, "raise KeyboardInterrupt")
    result = lamps.runpytest_subprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.INTERRUPTED
    written = report(lamps.path)
    assert written["selected"] == 4
    assert written["not_run"] >= 1


def test_a_test_that_leaves_no_trace_fails_the_session(lamps: pytest.Pytester) -> None:
    hook = '\n\ndef pytest_runtest_protocol(item):\n    return "cellar" in item.name or None\n'
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n{hook}")
    for options in ((), ("-n", "2")):
        result = lamps.runpytest_inprocess(SUITE, *options)
        assert result.ret == 1
        result.stdout.fnmatch_lines(["FAILED 1 of 4 tests left no result: a worker or a plugin lost them"])
        assert report(lamps.path)["not_run"] == 1
