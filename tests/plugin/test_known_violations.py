"""Known violations with a condition: a violation under it is known, any other fails its test."""

from __future__ import annotations

import json
import re

import pytest

from tests.plugin.project import change, command, outcomes, report

SUITE = "--hri-suite=by-hand"
KNOWN = "R2: the hall has no dimmer"
GLARE = "        return GLARE\n"


def known(lamps: pytest.Pytester, line: str) -> None:
    """Write another line for the known violation of R2."""
    change(lamps.path, "pytest.ini", KNOWN, line)


def glare_in_the_cellar(lamps: pytest.Pytester) -> None:
    """A fault: more light than wished for in the cellar, where R2 held before."""
    change(lamps.path, "lamps/guide.py", GLARE, "        return 95.0\n")


@pytest.mark.slow
def test_a_violation_where_it_is_known_does_not_fail_and_says_where_it_is_known(lamps: pytest.Pytester) -> None:
    known(lamps, "R2 when once[0:10](on(wish) & !wish.cellar) until 2999-12-31: the hall: no dimmer")
    result = lamps.runpytest_inprocess("-v", SUITE, "-rx")
    assert result.ret == 0
    result.assert_outcomes(passed=3, xfailed=1)
    condition = "when once[[]0:10[]](on(wish) & !wish.cellar): the hall: no dimmer"
    result.stdout.fnmatch_lines(
        [
            "  R2 The lamp shall never glare * 0      1 *",
            "  R2 is known to fail: when once[[]0:10[]](on(wish) & !wish.cellar): the hall: no",
            "  dimmer",
            f"XFAIL *- known violation of R2 ({condition})",
        ]
    )
    written = report(lamps.path)
    assert written["known_violations"] == {"R2": "the hall: no dimmer"}
    assert written["known_when"] == {"R2": "once[0:10](on(wish) & !wish.cellar)"}
    assert written["known_until"] == {"R2": "2999-12-31"}
    assert "outside" not in written["suites"][0]["requirements"]["R2"]


@pytest.mark.slow
def test_a_violation_elsewhere_fails_its_test_though_the_requirement_is_known_to_fail(lamps: pytest.Pytester) -> None:
    glare_in_the_cellar(lamps)
    assert lamps.runpytest_inprocess(SUITE).ret == 0  # this is what a condition is for
    known(lamps, "R2 when !wish.cellar: the hall has no dimmer")
    result = lamps.runpytest_inprocess(SUITE, "-v")
    assert result.ret == 1
    result.assert_outcomes(passed=2, xfailed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "R2 Failed: The lamp shall never glare",
            "  known only when !wish.cellar: the hall has no dimmer",
            "  triggered at *: lamp_level = 95 % (margin -15 %); not known under this condition",
            "  R2 is known to fail: when !wish.cellar: the hall has no dimmer; 1 test",
            "  violated it outside of this condition",
            "*ED  2 passed, 1 failed, 1 known to fail *",
        ]
    )
    by_place = {name.split("-")[2]: outcome for name, outcome in outcomes(lamps.path).items() if "polite" in name}
    assert by_place == {"cellar": "failed", "hall": "known-violation"}
    written = report(lamps.path)
    assert written["suites"][0]["requirements"]["R2"]["outside"] == 1
    violations = {test["id"]: test["requirements"]["R2"]["violations"] for test in written["tests"]}
    assert [each["outside"] for name, found in violations.items() for each in found if "cellar" in name] == [True]
    assert not any("outside" in each for name, found in violations.items() for each in found if "hall" in name)


def test_one_violation_elsewhere_is_enough_and_is_told_first(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "        lamp.set(level)\n", "        lamp.set(level)\n        lamp.set(0)\n")
    change(lamps.path, "lamps/guide.py", "        lamp.set(0)\n", "        clock.sleep(0.1)\n        lamp.set(0)\n")
    again = "        clock.sleep(SWITCHING_S)\n        lamp.set(95.0)\n        clock.sleep(0.1)\n        lamp.set(0)\n"
    change(lamps.path, "lamps/guide.py", "        clock.sleep(SWITCHING_S)\n", again)
    known(lamps, "R2 when lamp_level >= 99: the hall has no dimmer")
    result = lamps.runpytest_inprocess(SUITE, "-v", "-k", "hall-polite")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["  *lamp_level = 95 % (margin -15 %); not known under this condition", "  *lamp_level = 100 % (margin -20 %)"]
    )


FORM = (
    "expected 'REQUIREMENT: reason' or "
    "'REQUIREMENT [[]of CAUSE,...[]] [[]when CONDITION[]] [[]until YYYY-MM-DD[]]: reason'"
)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "R2 when wish.celar: dark",
            "known violation of R2: *, column 1: unknown name 'wish.celar'; nearest: *",
        ),
        ("R2 when lamp_level >: dark", "known violation of R2: condition, column 13: the condition ends too early"),
        ("R2 when lamp_level: dark", "known violation of R2: condition, column 1: *"),
        ("R2 when always(on(wish) -> on(switched)): dark", "known violation of R2: condition, column 1*"),
        ("R2 when : dark", f"hri_known_violations: 'R2 when : dark': {FORM}"),
        (
            "R2 while lamp_level > 3: dark",
            "hri_known_violations: * expected 'when CONDITION' in place of 'while CONDITION'",
        ),
        ("R2 when once[0:10](on(wish))", f"hri_known_violations: * {FORM}"),
        ("R2 when lamp_level > 3 until 2020-02-30: dark", "hri_known_violations: * '2020-02-30' is not a date*"),
    ],
)
def test_a_condition_that_cannot_be_is_refused_before_anything_runs(
    lamps: pytest.Pytester, line: str, told: str
) -> None:
    known(lamps, line)
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: {told}"])


@pytest.mark.slow
def test_a_merged_report_keeps_the_conditions_and_what_was_outside(lamps: pytest.Pytester) -> None:
    change(lamps.path, "pytest.ini", "hri_diagnose = 0\n", "")
    glare_in_the_cellar(lamps)
    known(lamps, "R2 when !wish.cellar: the hall has no dimmer")
    for shard in ("1/2", "2/2"):
        lamps.runpytest_inprocess(SUITE, f"--hri-shard={shard}", f"--hri-report=shard{shard[0]}")
    merge = command("merge", "shard1", "shard2")
    assert merge.returncode == 1
    assert "R2 in 2 tests: The lamp shall never glare" in merge.stdout
    assert re.search(r"^FAILED  2 passed, 1 failed, 1 known to fail  ", merge.stdout, re.MULTILINE)
    merged = json.loads((lamps.path / "hri-merged" / "report.json").read_text(encoding="utf-8"))
    assert merged["known_when"] == {"R2": "!wish.cellar"}
    assert merged["suites"][0]["requirements"]["R2"]["outside"] == 1
