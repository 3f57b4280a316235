"""The text of a failing test."""

import random
from typing import Any

import pytest

from pytest_hricdv.report import failure
from pytest_hricdv.report.explanation import nearest_miss
from pytest_hricdv.report.rerun import command
from tests.report import sample

REQUIREMENTS = sample.report(tests=0)["requirements"]


def _failing(*names: str) -> dict[str, Any]:
    test = sample.test(random.Random(1), "rl")
    test["requirements"] = {
        name: sample.judged("Failed" if name in names else "Passed", 8.25) for name in ("R1", "R2", "R3", "R4")
    }
    return test


def test_failure_tells_what_when_by_how_much_and_how_to_run_it_again() -> None:
    test = _failing("R1")
    text = failure(test, REQUIREMENTS, seed=7, units={"hand_distance": "m"})
    assert text.startswith("R1 Failed: If gaze, pressure and location sense the human ready, then a leg")
    assert "checked as  always(rise(gpl_ready) -> eventually[0:10](leg_released))" in text
    assert "triggered at 41.2 s, violated at 51.5 s: hand_distance = 0.03 m (margin -0.02)" in text
    assert "2 triggers: 1 passed, 1 failed; worst margin -0.02 at 51.5 s" in text
    assert "others:  R2 Passed, R3 Passed, R4 Passed" in text
    assert f"turns:   {', '.join(test['legs'])}" in text
    assert f"abstract test {test['id']}, own seed {test['seed']}" in text
    assert "  tell leg\n  receivesignal\n" in text
    assert text.endswith(f'run it again:\n  pytest "{test["nodeid"]}" --hri-suite=rl --hri-seed=7')


def test_actions_are_told_up_to_the_violation_with_their_times() -> None:
    test = _failing("R1")  # violated at 51.5 s
    test["abstract"] = [f"set_param gaze = {n}" for n in range(30)]
    test["acted_s"] = [3.0 * n for n in range(28)]
    told = failure(test, REQUIREMENTS, seed=0).splitlines()
    start = told.index(f"what the human did until then (abstract test {test['id']}, own seed {test['seed']}):")
    assert told[start + 1 : start + 4] == [
        "  5 actions before, and",
        "      15.0 s  set_param gaze = 5",
        "      18.0 s  set_param gaze = 6",
    ]
    assert told[start + 14 : start + 17] == ["      51.0 s  set_param gaze = 17", "  and 12 more actions later", ""]


def test_a_violation_before_anything_was_done_says_so() -> None:
    test = _failing("R1")
    test["acted_s"] = [60.0]
    assert "own seed" in (text := failure(test, REQUIREMENTS, seed=0))
    assert f"):\n  nothing\n  and {len(test['abstract'])} more actions later\n" in text


def test_a_known_violation_is_told_after_the_cause() -> None:
    text = failure(_failing("R1", "R3"), REQUIREMENTS, seed=0, known={"R1": "slow release"})
    assert text.startswith("R3 Failed")
    assert "a known violation (slow release): it does not fail the run" in text[text.index("R1 Failed") :]


def test_the_line_to_run_again_takes_the_suite_as_it_was_asked_for() -> None:
    text = failure(_failing("R1"), REQUIREMENTS, seed=0, suite="tests/abstract")
    assert text.endswith("--hri-suite=tests/abstract --hri-seed=0")


def test_a_test_that_is_still_running_has_a_text() -> None:
    test = _failing("R1")
    for key in ("outcome", "wall_s", "failure"):
        del test[key]
    assert failure(test, {}, seed=0).startswith("R1 Failed\n  triggered at")


def test_an_unchecked_requirement_is_explained() -> None:
    test = _failing("R3")
    test["requirements"]["R1"] = sample.judged("NC", 0)
    text = failure(test, REQUIREMENTS, seed=0)
    assert "R1 NC, R2 Passed, R4 Passed (NC: not checked, nothing triggered it)" in text
    assert "         R1 nearest at 41.2 s: only reading.pressure was missing\nturns:" in text


@pytest.mark.parametrize(
    ("missing", "distance", "shown"),
    [
        (["leg_offset < 0.15"], 0.03, "nearest at 5.00 s: only leg_offset < 0.15 was missing, by 0.03"),
        (["p", "x < 1"], None, "nearest at 5.00 s: p, x < 1 were missing"),
        (list("abcdefgh"), None, "nearest at 5.00 s: a, b, c, d, e, f and 2 more were missing"),
    ],
)
def test_a_nearest_miss_says_what_was_missing_and_by_how_much(
    missing: list[str], distance: float | None, shown: str
) -> None:
    assert nearest_miss({"time_s": 5.0, "missing": missing, "distance": distance}) == shown


def test_an_error_shows_its_own_text() -> None:
    test = _failing()
    test.update(outcome="error", failure="RuntimeError: the world was torn down\n  by the test", requirements={})
    text = failure(test, {}, seed=0)
    assert text.startswith("RuntimeError: the world was torn down\n  by the test\n\nturns:")


def test_many_violations_and_actions_are_cut_with_their_number() -> None:
    test = _failing("R3")
    test["requirements"]["R3"]["violations"] *= 9
    test["abstract"] = [f"set_param gaze = {n}" for n in range(40)]
    text = failure(test, REQUIREMENTS, seed=0)
    assert "and 6 more violations" in text
    assert "... and 27 more actions" in text


def test_a_test_that_never_ran_still_has_a_text() -> None:
    test = _failing()
    test.update(outcome="not-run", requirements={}, legs=[], abstract=[], sim_s=None, seed=None)
    text = failure(test, {}, seed=0)
    assert "turns:" not in text
    assert "  nothing" in text


@pytest.mark.parametrize(
    ("nodeid", "suite", "shown"),
    [
        ("t.py::t[rl-1]", "rl", 'pytest "t.py::t[rl-1]" --hri-suite=rl --hri-seed=0'),
        ("t.py::t[$HOME]", "my suite", "pytest 't.py::t[$HOME]' '--hri-suite=my suite' --hri-seed=0"),
        ('t.py::t["]', "tests/abstract/", "pytest 't.py::t[\"]' --hri-suite=tests/abstract/ --hri-seed=0"),
        ("t.py::t[a b]", "a;b", "pytest \"t.py::t[a b]\" '--hri-suite=a;b' --hri-seed=0"),
    ],
)
def test_command_is_safe_to_paste_into_a_shell(nodeid: str, suite: str, shown: str) -> None:
    assert command({"nodeid": nodeid}, suite, 0) == shown
