"""`hri_run`: a user's own test functions run abstract tests and look at what came of them."""

from __future__ import annotations

import pytest

from tests.plugin.project import change

OWN = '''
import pytest

BRIGHT = """
    enter hall
    set_lamp level = 100
"""


def test_glare(hri_run):
    result = hri_run(BRIGHT, patience_s=6.0)
    assert result.failed == ("R2",)
    assert result.verdict("R1").verdict == "Passed"
    assert result.record.signals["lamp_level"][-1][1] == 100.0
    assert result.outcome.outcomes == ("released",)


def test_no_glare_in_the_cellar(hri_run):
    hri_run.check(hri_run(["enter cellar", "set_lamp level=100", "leave"]))


@pytest.mark.parametrize("patience_s", [2.0, 20.0])
def test_parameters_hold(hri_run, patience_s):
    result = hri_run(BRIGHT, patience_s=patience_s, pause_s=0.25)
    assert result.sim_s == pytest.approx(0.25 * 2 + 0.3 + patience_s)
    assert {action.parameters["pause_s"] for action in result.test.actions} == {0.25}


def test_the_seed_decides_on_the_rest(hri_run):
    first, again, other = (hri_run(BRIGHT, seed=seed) for seed in (1, 1, 2))
    assert first.record.sha256 == again.record.sha256 != other.record.sha256


def test_a_concrete_test_is_run_as_it_is(hri_run):
    first = hri_run(BRIGHT)
    assert hri_run(first.test).record.sha256 == first.record.sha256
'''


@pytest.fixture
def own(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project with test functions of its user."""
    (lamps.path / "test_own.py").write_text(OWN, encoding="utf-8")
    return lamps


def test_own_functions_run_what_they_say_with_and_without_a_suite(own: pytest.Pytester) -> None:
    own.runpytest_inprocess("test_own.py").assert_outcomes(passed=6)
    assert not (own.path / "hri-report").exists()
    beside = own.runpytest_inprocess("-o", "hri_suite=by-hand", "-o", "hri_tests=1")
    beside.assert_outcomes(passed=7, xfailed=1)  # its own function beside `hri_case`, too
    beside.stdout.fnmatch_lines(["NO TEST PASSED  1 known to fail *"])


FAILING = """
def test_of_mine(hri_run):
    hri_run.check(hri_run("enter hall\\nset_lamp level = 100", seed=3))
"""


def test_check_fails_with_the_explanation_and_how_to_run_it_again(lamps: pytest.Pytester) -> None:
    (lamps.path / "test_mine.py").write_text(FAILING, encoding="utf-8")
    lamps.runpytest_inprocess("test_mine.py").assert_outcomes(xfailed=1)
    result = lamps.runpytest_inprocess("-v", "test_mine.py", "--hri-strict")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "R2 Failed: The lamp shall never glare",
            "  triggered at * lamp_level = 100 % (margin -20 %)",
            "what the human did*:",
            "*s  set_lamp level = 100",
            "run it again:",
            '  pytest "test_mine.py::test_of_mine"',
        ]
    )


def test_a_failed_assertion_is_shown_with_what_happened(lamps: pytest.Pytester) -> None:
    (lamps.path / "test_mine.py").write_text(
        "def test_mine(hri_run):\n    assert hri_run('enter hall').outcome.outcomes == ()\n", encoding="utf-8"
    )
    result = lamps.runpytest_inprocess("test_mine.py")
    result.stdout.fnmatch_lines(
        ["*assert ('released',) == ()*", "*- Captured hri_run call -*", "R1 NC (0 triggers*", "  enter hall"]
    )
    result.stdout.no_fnmatch_line("*custom_tests.py*")


def test_what_cannot_be_run_is_said_at_the_users_own_line(lamps: pytest.Pytester) -> None:
    told = {
        "'enter hal'": "hri_run:1:1: unknown command 'enter hal'; nearest: enter hall*",
        "'enter hall\\n\\nleave'": "hri_run: 2 tests in the text; expected one*",
        "''": "hri_run: 0 tests in the text; expected one*",
        "'enter hall', paus_s=1": "hri_run: parameter 'paus_s': the testbench declares none such; nearest: pause_s*",
        "'leave', pause_s=1": "hri_run: parameter 'pause_s': none of these commands has it*patience_s*",
        "'enter hall', pause_s=float('nan')": "hri_run: parameter 'pause_s' is nan; expected a finite number",
        "'# values 1: pause_s 9\\nenter hall'": "test handmade-*command 1 (enter hall): pause_s 9.0 is out of its ran*",
        "'enter hall', pause_s='long'": "hri_run: parameter 'pause_s' is 'long'; expected a finite number",
    }
    tests = [f"def test_{number}(hri_run):\n    hri_run({call})\n" for number, call in enumerate(told)]
    (lamps.path / "test_mine.py").write_text("\n\n".join(tests), encoding="utf-8")
    result = lamps.runpytest_inprocess("test_mine.py")
    result.assert_outcomes(failed=len(told))
    for call, message in told.items():
        result.stdout.fnmatch_lines([f">   *hri_run({call})".replace("[", "[[]"), f"E *{message}"])
    result.stdout.no_fnmatch_line("*custom_tests.py*")


def test_a_missing_or_wrong_testbench_is_said_in_one_message(pytester: pytest.Pytester, lamps: pytest.Pytester) -> None:
    (lamps.path / "test_mine.py").write_text("def test_mine(hri_run):\n    hri_run('enter hall')\n", encoding="utf-8")
    change(lamps.path, "requirements.toml", "lamp_level > 0", "lamp_levl > 0")
    result = lamps.runpytest_inprocess("test_mine.py")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["hri_run: *requirements.toml*lamp_levl*"])
    (lamps.path / "conftest.py").write_text("", encoding="utf-8")
    result = lamps.runpytest_inprocess("test_mine.py")
    result.stdout.fnmatch_lines(["hri_run: no testbench: implement pytest_hricdv_testbench(config) in *conftest.py*"])
