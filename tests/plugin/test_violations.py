"""Violations: known ones do not fail the run; others fail their test with a text that says all one needs."""

from __future__ import annotations

import shlex

import pytest

from tests.plugin.project import change, outcomes, report

BRIGHT = "rl-hall-polite-6c5fa14f"


@pytest.mark.slow
def test_a_known_violation_is_reported_and_does_not_fail_the_run(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl", "-rx")
    assert result.ret == 0
    result.assert_outcomes(passed=32, xfailed=2)
    result.stdout.fnmatch_lines(
        [
            "  R2 The lamp shall never glare * 0      2 *",
            "  R2 is known to fail: the hall has no dimmer",
            "XFAIL test_lamps.py::*[[]rl-hall-polite-*[]] - known violation of R2 (the hall has no dimmer)",
        ]
    )
    written = report(lamps.path)
    assert written["known_violations"] == {"R2": "the hall has no dimmer"}
    (known,) = [test for test in written["tests"] if test["id"] == BRIGHT]
    assert known["outcome"] == "known-violation"
    assert known["requirements"]["R2"]["verdict"] == "Failed"


@pytest.mark.slow
def test_a_known_violation_does_not_hide_another(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 1.5")
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl", f"test_lamps.py::test_lamps[{BRIGHT}]")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "R1 Failed: A wish shall be fulfilled within a second",
            "  triggered at * violated at *",
            "R2 Failed: The lamp shall never glare",
            "  a known violation (the hall has no dimmer), which does not fail the run",
        ]
    )


@pytest.mark.slow
def test_a_failure_says_when_by_how_much_and_how_to_run_it_again(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl", "--hri-tests=12", "--hri-strict", "--tb=short")
    assert result.ret == 1
    failed = [name for name, outcome in outcomes(lamps.path).items() if outcome == "failed"]
    assert failed
    result.stdout.fnmatch_lines(
        [
            f"*test_lamps[[]{failed[0]}[]]*",
            "R2 Failed: The lamp shall never glare",
            "  triggered at * s, violated at * s: lamp_level = 100 % (margin -20 %)",
            "what the human did around then (abstract test rl-hall-polite-*",
            "    * s  set_lamp level = 100",
            "run it again:",
        ]
    )
    result.stdout.no_fnmatch_line("*pytest_hricdv*.py*")
    lines = result.outlines
    command = lines[lines.index("run it again:") + 1]
    program, *arguments = shlex.split(command)
    assert program == "pytest"
    again = lamps.runpytest_inprocess("-v", *arguments, "--tb=short")
    assert again.ret == 1
    assert failure(again.outlines) == failure(lines)


def failure(lines: list[str]) -> list[str]:
    """The text of the first failing test."""
    start = lines.index("R2 Failed: The lamp shall never glare")
    return lines[start : lines.index("run it again:", start) + 2]


@pytest.mark.slow
def test_a_run_that_is_not_checked_by_its_test_is_checked_when_the_test_is_over(lamps: pytest.Pytester) -> None:
    change(lamps.path, "test_lamps.py", "hri_case.check(hri_case.run())", "hri_case.run()")
    lamps.runpytest_inprocess("--hri-suite=by-hand").assert_outcomes(passed=3, xfailed=1)
    strict = lamps.runpytest_inprocess("-v", "--hri-suite=by-hand", "--hri-strict")
    strict.assert_outcomes(passed=3, failed=1)
    strict.stdout.fnmatch_lines(["R2 Failed: The lamp shall never glare"])


def test_a_test_that_never_runs_its_case_fails(lamps: pytest.Pytester) -> None:
    change(lamps.path, "test_lamps.py", "hri_case.check(hri_case.run())", "assert str(hri_case)")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    result.assert_outcomes(failed=4)
    result.stdout.fnmatch_lines(
        ["the test ended without a run: call hri_case.check(hri_case.run())", "FAILED  4 in error *"]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "catching",
    ["with contextlib.suppress(BaseException):", "with pytest.raises(BaseException):"],
    ids=["all", "raises"],
)
def test_a_function_that_catches_its_failure_fails(lamps: pytest.Pytester, catching: str) -> None:
    change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 1.3")
    test = (
        f"import contextlib\nimport pytest\n\n\ndef test_lamps(hri_case):\n    {catching}\n"
        "        hri_case.check(hri_case.run())\n"
    )
    lamps.makepyfile(test_lamps=test)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == 1
    assert {test["outcome"] for test in report(lamps.path)["tests"]} == {"failed"}


@pytest.mark.parametrize(
    "test",
    [
        "def lamps_test(hri_case):\n    pass\n",
        "import unittest\n\n\nclass TestIt(unittest.TestCase):\n    def test_it(self, hri_case=0):\n        pass\n",
    ],
    ids=["called otherwise", "a TestCase"],
)
def test_a_suite_that_no_test_function_asks_for_says_so(lamps: pytest.Pytester, test: str) -> None:
    lamps.makepyfile(test_lamps=test)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.fnmatch_lines(
        ["*no test function has hri_case as an argument, so the 4 tests of by-hand are not run*"]
    )
