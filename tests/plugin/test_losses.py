"""Runs that do not come to their end: an exception, a skip, a crash, a stop. The report accounts for every test."""

from __future__ import annotations

from collections import Counter

import pytest

from tests import json_schema
from tests.plugin.project import A_WORKER, change, in_each_mode, outcomes, report

SUITE = "--hri-suite=by-hand"  # four tests, of which one wishes for level 10


def write_dimmed(lamps: pytest.Pytester, body: str) -> None:
    """Let the guide do something else when it is to dim the lamp."""
    change(lamps.path, "lamps/guide.py", "return 10.0", body)


@pytest.mark.slow
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
            "E       the code under test raised ConnectionError: lamp unplugged in node guide at *.* s",
            "E       others:  2 not checked, 1 pending at the end",
            "E       what the human did until then (abstract test by-hand-hall-curt-*",
            "E         * s  set_lamp level = 10",
            "E       run it again:",
            'E         pytest "test_lamps.py::test_lamps[[]by-hand-hall-curt-*[]]" --hri-suite=by-hand --hri-seed=0',
            "lamps/guide.py:40: ConnectionError",
            "fault: the code under test raised ConnectionError: lamp unplugged in node guide at *(by-hand-hall-curt-*)",
            "FAILED  2 passed, 1 failed, 1 known to fail *",
        ]
    )
    result.stdout.no_fnmatch_line("*pytest_hricdv/*")
    written = report(lamps.path)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 4, 0)
    (broken,) = [test for test in written["tests"] if test["outcome"] == "failed"]
    (fault,) = broken["errors"]
    assert fault.startswith("the code under test raised ConnectionError: lamp unplugged in node guide at ")
    assert broken["requirements"]["R1"]["pending"] == 1  # its verdicts are there, up to the fault
    assert broken["code"]["statements"] > 20
    assert "ConnectionError: lamp unplugged" in broken["failure"]
    assert (lamps.path / broken["replay"]).is_file()


@pytest.mark.parametrize("raised", ["GreenletExit", "SystemExit"])
def test_code_that_exits_fails_its_test(lamps: pytest.Pytester, raised: str) -> None:
    """Nothing else would tell: a greenlet that exits ends without an exception, and nobody is left to violate."""
    write_dimmed(lamps, f"__import__('greenlet'); from greenlet import GreenletExit; raise {raised}")
    result = lamps.runpytest_inprocess(SUITE, "-k", "curt")
    result.assert_outcomes(failed=1, passed=1)
    result.stdout.fnmatch_lines([f"the code under test raised {raised} in node guide at * s", "run it again:"])


ENDS = {
    "early": 'the code under test returned at * s, and * VirtualTime(allowed_endings=("early",))',
    "limit": 'the run ended at its time limit of 60 s; if it may, declare VirtualTime(allowed_endings=("limit",))',
    "idle": 'the run ended at * s because nothing was left to do; * VirtualTime(allowed_endings=("idle",))',
}


@pytest.mark.slow
@pytest.mark.parametrize("end", ENDS)
def test_a_run_that_nobody_ended_fails_unless_the_testbench_allows_it(lamps: pytest.Pytester, end: str) -> None:
    forever = "        while True:\n            run.kernel.sleep(1.0)\n"
    sleep = '    run.kernel.spawn("clock", lambda: run.kernel.sleep(100.0))\n    ended = run.go'
    if end == "limit":
        change(lamps.path, "conftest.py", '        run.kernel.stop("patience over")\n', forever)
    else:
        change(lamps.path, "conftest.py", '        run.kernel.stop("patience over")\n', "")
    if end == "early":
        change(lamps.path, "conftest.py", "    ended = run.go", sleep)
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == 1
    result.assert_outcomes(failed=4)
    result.stdout.fnmatch_lines([ENDS[end]])
    (verdict, *_) = [test["requirements"]["R1"] for test in report(lamps.path)["tests"]]
    assert verdict["verdict"] == "Passed"
    may_end = '("limit", "early")' if end == "early" else f'("{end}",)'
    change(
        lamps.path,
        "conftest.py",
        "        run=run,\n",
        f"        run=run,\n        time=VirtualTime(allowed_endings={may_end}),\n",
    )
    allowed = lamps.runpytest_inprocess(SUITE)
    assert allowed.ret == 0
    assert "errors" not in report(lamps.path)["tests"][0]


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        ("lamps/guide.py", "clock.sleep(SWITCHING_S)", "clock.sleep(-1)", "*cannot wait for -1 s*"),
        ("lamps/guide.py", "bus.publish(Answer())", "bus.publish(3)", "*TypeError: int is not a message of this bus*"),
        ("conftest.py", '"lamp_level", level', '"lamplevel", level', "*signal 'lamplevel' is recorded but not*"),
        ("conftest.py", '"lamp_level", level', '"lamp_level", float("nan")', "*expected a finite number*"),
        ("conftest.py", "    return Outcome(", "    Outcome(", "*run returned None; expected a pytest_hricdv*Outcome*"),
        ("conftest.py", 'outcomes=("released",)', "outcomes=(1,)", "*outcomes is (1,); expected a tuple of strings"),
        (
            "conftest.py",
            'outcomes=("released",)',
            'skipped_s=float("nan")',
            "*Outcome: skipped_s is nan; expected a time in seconds",
        ),
    ],
    ids=[
        "negative sleep",
        "undeclared message",
        "undeclared signal",
        "NaN",
        "no outcome",
        "number as outcome",
        "NaN as time",
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
    assert list(outcomes(lamps.path).values()) == ["failed" if name == "lamps/guide.py" else "error"]


@pytest.mark.slow
@in_each_mode
def test_a_skipped_test_was_not_run(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    own = "    if 'curt' in repr(hri_case):\n        __import__('pytest').skip('no lamp today')\n"
    change(lamps.path, "test_lamps.py", "def test_lamps(hri_case):\n", f"def test_lamps(hri_case):\n{own}")
    result = lamps.runpytest_inprocess(SUITE, *options)
    assert result.ret == 0
    result.assert_outcomes(passed=1, xfailed=1, skipped=2)
    written = report(lamps.path)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 2, 2)
    assert all("no lamp today" in test["failure"] for test in written["tests"] if test["outcome"] == "not-run")


@pytest.mark.slow
def test_a_crashed_worker_loses_its_test_only_and_the_report_says_so(lamps: pytest.Pytester) -> None:
    write_dimmed(lamps, '__import__("os").kill(__import__("os").getpid(), 9)')
    result = lamps.runpytest_subprocess(SUITE, *A_WORKER)
    assert result.ret == 1
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    assert (written["selected"], written["reported"], written["not_run"]) == (4, 3, 1)
    assert written["workers"] == 1
    assert Counter(test["outcome"] for test in written["tests"]) == {"passed": 2, "known-violation": 1, "not-run": 1}
    (lost,) = [test for test in written["tests"] if test["outcome"] == "not-run"]
    assert written["not_run_tests"] == [lost["nodeid"]]
    assert "crashed while running" in lost["failure"]
    for tally in written["suites"][0]["requirements"].values():
        assert tally["passed"] + tally["failed"] + tally["nc"] == 3  # a test that was not run is not NC
    assert lost["requirements"] == {}
    told = ["3/4 tests reported: 1 test not run or lost, totals are lower bounds", "  not run: test_lamps.py::*"]
    result.stdout.fnmatch_lines(told)


@pytest.mark.slow
@in_each_mode
def test_a_run_stopped_at_the_first_failure_leaves_its_report(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl", "--hri-strict", "-x", *options)
    assert result.ret in (1, 2)
    written = report(lamps.path)
    assert written["selected"] == 34
    assert 1 <= written["reported"] < 34
    assert written["reported"] + written["not_run"] == 34
    assert "failed" in outcomes(lamps.path).values()
    (suite,) = written["suites"]
    for tally in suite["requirements"].values():
        assert tally["passed"] + tally["failed"] + tally["nc"] == written["reported"]
    result.stdout.fnmatch_lines([f"suite rl, seed 0: 34 tests, {written['not_run']} not run"])


@pytest.mark.slow
def test_a_test_that_leaves_no_trace_fails_the_session(lamps: pytest.Pytester) -> None:
    hook = '\n\ndef pytest_runtest_protocol(item):\n    return "cellar" in item.name or None\n'
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n{hook}")
    for options in ((), A_WORKER):
        result = lamps.runpytest_inprocess(SUITE, *options)
        assert result.ret == 1
        result.stdout.fnmatch_lines(["FAILED 1 of 4 tests left no result: a worker, a plugin or an exit lost them"])
        assert report(lamps.path)["not_run"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), A_WORKER, ("--hri-isolate",)], ids=["plain", "on a worker", "isolated"])
def test_an_error_of_a_task_that_nobody_awaited_fails_its_test(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    change(lamps.path, "conftest.py", 'name="lamps",', 'name="lamps", time=VirtualTime(apis=("asyncio",)),')
    change(
        lamps.path,
        "lamps/guide.py",
        "        lamp.set(level)\n",
        "        lamp.set(level)\n        asyncio.run(blink())\n",
    )
    change(lamps.path, "lamps/guide.py", "GLARE = 80.0\n", BLINK)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "cellar", *options)
    assert result.ret == 1
    lost = (
        "fault: a task of asyncio, short, raised OSError: no bulb, from KeyError: 'bulb' at *guide.py:*, and nothing *"
    )
    result.stdout.fnmatch_lines([lost])


BLINK = """import asyncio

GLARE = 80.0


async def short():
    try:
        {}["bulb"]
    except KeyError as error:
        raise OSError("no bulb") from error


async def blink():
    task = asyncio.create_task(short())
    await asyncio.sleep(0.1)
"""
