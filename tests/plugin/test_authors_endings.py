"""How a test function ends is its author's: an xfail of its own makes no violation a known one."""

from __future__ import annotations

from typing import Any

import pytest

from tests.plugin.project import change, command, in_each_mode, report

SUITE = "--hri-suite=by-hand"
TEST = "def test_lamps(hri_case):\n    hri_case.check(hri_case.run())\n"
DECLARED = "hri_known_violations =\n    R2: the hall has no dimmer\n"
WORDS = "xfailed by the test function"


def write_test(lamps: pytest.Pytester, mark: str = "", after: str = "pass") -> None:
    """Mark the host test, and let it do something after its check."""
    head = f"import pytest\n\n\n@pytest.mark.xfail({mark})\n" if mark else "import pytest\n\n\n"
    change(lamps.path, "test_lamps.py", TEST, f"{head}{TEST}    {after}\n")


def declare_nothing(lamps: pytest.Pytester) -> None:
    """Take back that the violation of R2 is known."""
    change(lamps.path, "pytest.ini", DECLARED, "")


def by_outcome(lamps: pytest.Pytester) -> dict[str, list[dict[str, Any]]]:
    """The tests of the report by outcome."""
    sorted_out: dict[str, list[dict[str, Any]]] = {}
    for test in report(lamps.path)["tests"]:
        sorted_out.setdefault(test["outcome"], []).append(test)
    return sorted_out


@pytest.mark.slow
@in_each_mode
def test_a_violation_that_nobody_declared_is_none_that_is_known(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    declare_nothing(lamps)
    write_test(lamps, 'reason="flaky rig"')
    result = lamps.runpytest_inprocess(SUITE, "-rx", *options)
    assert result.ret == 0
    result.assert_outcomes(xpassed=3, xfailed=1)
    result.stdout.fnmatch_lines([f"*ED  3 passed, 1 {WORDS} *", "XFAIL *- flaky rig"])
    result.stdout.no_fnmatch_line("*known to fail*")
    result.stdout.no_fnmatch_line("*1 known*")
    tests = by_outcome(lamps)
    assert {outcome: len(group) for outcome, group in tests.items()} == {"passed": 3, "expected-failure": 1}
    (violating,) = tests["expected-failure"]
    assert violating["requirements"]["R2"]["verdict"] == "Failed"
    assert violating["failure"].startswith("flaky rig\n\nR2 failed at ")
    assert violating["replay"].endswith(f"{violating['id']}.json")  # there is something to see in it
    assert not report(lamps.path)["known_violations"]


def test_no_view_calls_it_known(lamps: pytest.Pytester) -> None:
    declare_nothing(lamps)
    write_test(lamps, 'reason="flaky rig"')
    lamps.runpytest_inprocess(SUITE)
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert WORDS in page
    merged = command("merge", "hri-report", "hri-report", "--output=merged")
    assert f"1 {WORDS}" in merged.stdout
    assert "known to fail" not in merged.stdout
    assert not [line for line in merged.stdout.splitlines() if line.startswith("FAILED")]


AGAIN = """
RUNS = []


def run_until_it_passes(hri_case):
    RUNS.clear()
    for _ in range(3):
        try:
            result = hri_case.run()
            RUNS.append(result)
            {check}
        except BaseException:
            RUNS.append(None)


def test_lamps(hri_case):
    run_until_it_passes(hri_case)
    hri_case.check(hri_case.run())
"""


@pytest.mark.parametrize("check", ["hri_case.check(result)", "pass"])
@pytest.mark.parametrize("fails", ["raise ValueError('once')", "clock.sleep(70.0)"])
def test_a_later_run_makes_no_failed_run_good(lamps: pytest.Pytester, check: str, fails: str) -> None:
    (lamps.path / "test_lamps.py").write_text(AGAIN.format(check=check), encoding="utf-8")
    serving = "    greetings, wishes = "
    once = f"    import test_lamps\n    if not test_lamps.RUNS:\n        {fails}\n{serving}"
    change(lamps.path, "lamps/guide.py", serving, once)
    result = lamps.runpytest_inprocess(SUITE, "-k", "cellar-polite", "--hri-audit=off", "--hri-diagnose=0")
    result.assert_outcomes(failed=1)
    (test,) = report(lamps.path)["tests"]
    assert test["outcome"] == "failed"


ENDINGS = """
import pytest


@pytest.fixture
def broken_rig():
    raise OSError("no rig")


@pytest.fixture
def rig_that_jams():
    yield
    raise OSError("jammed")


def check_testbench(case):
    case.check(case.run())


def test_plain(hri_case):
    check_testbench(hri_case)


@pytest.mark.xfail(reason="flaky rig")
def test_xfail(hri_case):
    check_testbench(hri_case)


@pytest.mark.xfail(reason="flaky rig", strict=True)
def test_strict_xfail(hri_case):
    check_testbench(hri_case)


@pytest.mark.xfail(reason="flaky rig", run=False)
def test_xfail_that_does_not_run(hri_case):
    check_testbench(hri_case)


def test_xfail_before(hri_case):
    pytest.xfail("not yet")


def test_xfail_after(hri_case):
    check_testbench(hri_case)
    pytest.xfail("not yet")


def test_skip_before(hri_case):
    pytest.skip("rig is busy")


def test_skip_after(hri_case):
    check_testbench(hri_case)
    pytest.skip("rig is busy")


def test_fail_before(hri_case):
    pytest.fail("my own")


def test_fail_after(hri_case):
    check_testbench(hri_case)
    pytest.fail("my own")


def test_assertion_between(hri_case):
    result = hri_case.run()
    assert result.sim_s < 0.0, "my own"
    hri_case.check(result)


def test_fixture_before(hri_case, broken_rig):
    check_testbench(hri_case)


def test_fixture_after(hri_case, rig_that_jams):
    check_testbench(hri_case)


def test_caught(hri_case):
    with pytest.raises(pytest.fail.Exception):
        check_testbench(hri_case)
    assert hri_case.result.failed == ("R2",)


def test_another_run_that_nobody_checks(hri_case):
    try:
        check_testbench(hri_case)
    except pytest.fail.Exception:
        pass
    hri_case.run()
"""

HALL_AND_CELLAR = {
    "plain": ("failed", "passed"),
    "xfail": ("expected-failure", "passed"),
    "strict_xfail": ("expected-failure", "failed"),
    "xfail_that_does_not_run": ("not-run", "not-run"),
    "xfail_before": ("expected-failure", "expected-failure"),
    "xfail_after": ("failed", "expected-failure"),
    "skip_before": ("not-run", "not-run"),
    "skip_after": ("failed", "not-run"),
    "fail_before": ("error", "error"),
    "fail_after": ("failed", "failed"),
    "assertion_between": ("failed", "failed"),
    "fixture_before": ("not-run", "not-run"),
    "fixture_after": ("failed", "passed"),
    "caught": ("failed", "failed"),
    "another_run_that_nobody_checks": ("failed", "passed"),
}
"""Test function -> what comes of it where R2 is violated, which nobody declared, and where all passes."""


TEXTS = {
    "xfail": "flaky rig\n\nR2 failed at ",
    "xfail_before": "not yet",
    "skip_before": "Skipped: rig is busy",
    "fail_before": "my own",
    "fixture_before": "OSError: no rig",
}
"""What is shown of a test of the hall: its author's text."""


@pytest.mark.slow
@in_each_mode
def test_the_report_shows_what_the_author_of_a_test_made_of_it(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    declare_nothing(lamps)
    (lamps.path / "test_lamps.py").write_text(ENDINGS, encoding="utf-8")
    result = lamps.runpytest_inprocess(SUITE, "-k", "polite", *options)
    assert result.ret == 1
    result.assert_outcomes(failed=14, passed=3, skipped=3, xfailed=7, xpassed=1, errors=4)
    written = report(lamps.path)
    tests = {(test["nodeid"].split("test_")[-1].split("[")[0], test["beliefs"][0]): test for test in written["tests"]}
    seen = {name: (tests[name, "hall"]["outcome"], tests[name, "cellar"]["outcome"]) for name in HALL_AND_CELLAR}
    assert seen == HALL_AND_CELLAR
    assert not [name for name, text in TEXTS.items() if text not in tests[name, "hall"]["failure"]]
    late = [problem for problem in written["problems"] if "an error after its result" in problem]
    assert len(late) == 2
    assert all("test_fixture_after" in problem and "OSError: jammed" in problem for problem in late)
    assert "known" not in result.stdout.str()
