"""Gates: `--hri-fail-under=KIND=PCT`."""

from __future__ import annotations

import pytest

from tests.plugin.project import MODES, change

SUITE = ("--hri-suite=by-hand", "-q")
# The suite by hand reaches 40 of 41 statements, 10 of 10 branches, 7 of 9 plans, 3 of 3 requirements, 4 of 8 bins.
BOUNDS = {"statements": 97.5, "branches": 100, "plans": 77.7, "assertions": 100, "cross": 50}
MISSED = {"statements": 98, "branches": 100, "plans": 78, "assertions": 100, "cross": 51}


def test_every_kind_is_held(lamps: pytest.Pytester) -> None:
    options = [f"--hri-fail-under={kind}={bound}" for kind, bound in BOUNDS.items()]
    assert lamps.runpytest_inprocess(*SUITE, *options).ret == 0


def test_every_missed_kind_is_named_with_what_was_reached(lamps: pytest.Pytester) -> None:
    options = [f"--hri-fail-under={kind}={bound}" for kind, bound in MISSED.items()]
    result = lamps.runpytest_inprocess(*SUITE, *options, "-k", "curt")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "FAILED suite by-hand: statements * %, at least 98 % asked for",
            "FAILED suite by-hand: branches * %, at least 100 % asked for",
            "FAILED suite by-hand: plans * %, at least 78 % asked for",
            "FAILED suite by-hand: assertions 66.67 %, at least 100 % asked for",
            "FAILED suite by-hand: cross * %, at least 51 % asked for",
        ]
    )


@pytest.mark.parametrize("options", MODES.values(), ids=MODES.keys())
def test_gates_of_the_ini_file_hold_for_whole_suites_only(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_under =\n    cross=51\n    plans=50")
    whole = lamps.runpytest_inprocess(*SUITE, *options)
    assert whole.ret == 1
    whole.stdout.fnmatch_lines(["FAILED suite by-hand: cross 50.00 %, at least 51 % asked for"])
    whole.stdout.no_fnmatch_line("FAILED suite by-hand: plans*")
    assert lamps.runpytest_inprocess(*SUITE, *options, "-k", "cellar").ret == 0


def test_a_gate_of_the_command_line_goes_before_the_ini_file_and_holds_always(lamps: pytest.Pytester) -> None:
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_under = cross=51")
    assert lamps.runpytest_inprocess(*SUITE, "--hri-fail-under=cross=50").ret == 0
    assert lamps.runpytest_inprocess(*SUITE, "--hri-fail-under=cross=40", "-k", "cellar").ret == 1


def test_what_is_unmeasured_holds_no_gate(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess(*SUITE, "--hri-no-cov", "--hri-fail-under=statements=0")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED suite by-hand: statements unmeasured, at least 0 % asked for"])


def test_each_suite_is_held_to_the_gates(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=by-hand,rl", "-q", "--hri-fail-under=cross=60")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED suite by-hand: cross*"])
    result.stdout.no_fnmatch_line("FAILED suite rl: cross*")
