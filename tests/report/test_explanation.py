"""The text of a failing test."""

import random
from collections.abc import Sequence

import pytest
from msgspec import convert
from msgspec.structs import replace

from pytest_hricdv.monitor import NearMiss, RequirementResult
from pytest_hricdv.report.explanation import failure, generate_command, near_miss
from pytest_hricdv.report.violations import headline
from pytest_hricdv.results.model import TestResult
from tests.report import sample, sample_tests

REQUIREMENTS = sample.report(tests=0).requirements


def _failing(*names: str, unchecked: Sequence[str] = ()) -> TestResult:
    """A test that failed these requirements, and did not check others."""
    test = sample_tests.test(random.Random(1), "rl")
    test["requirements"] = sample_tests.requirement_results(*names, unchecked=unchecked)
    return convert(test, TestResult)


def test_failure_says_what_when_by_how_much_and_how_to_run_it_again() -> None:
    test = _failing("R1")
    text = failure(test, REQUIREMENTS, seed=7, units={"hand_distance": "m"})
    assert text.startswith(
        "R1 failed at 51.5 s by 0.02 s\n\nR1 Failed: If gaze, pressure and location sense the human ready"
    )
    assert "checked as  always(rise(gpl_ready) -> eventually[0:10](leg_released))" in text
    assert "triggered at 41.2 s, violated at 51.5 s: hand_distance = 0.03 m (margin -0.02 s)" in text
    assert "2 triggers: 1 passed, 1 failed; worst margin -0.02 s at 51.5 s" in text
    assert "others:  R2 Passed, R3 Passed, R4 Passed" in text
    assert f"outcome: {', '.join(test.outcomes)}" in text
    assert f"abstract test {test.id}, own seed {test.seed}" in text
    assert "  tell leg\n  receivesignal\n" in text
    assert text.endswith(f'run it again:\n  pytest "{test.nodeid}" --hri-suite=rl --hri-seed=7')


def test_actions_are_listed_up_to_the_violation_with_their_times() -> None:
    test = _failing("R1")  # violated at 51.5 s
    actions = tuple(f"set_param gaze = {n}" for n in range(30))
    test = replace(test, abstract=actions, action_times_s=tuple(3.0 * n for n in range(28)))
    lines = failure(test, REQUIREMENTS, seed=0).splitlines()
    start = lines.index(f"what the human did around then (abstract test {test.id}, own seed {test.seed}):")
    assert lines[start + 1 : start + 4] == [
        "  8 actions before, and",
        "      24.0 s  set_param gaze = 8",
        "      27.0 s  set_param gaze = 9",
    ]
    assert lines[start + 11 : start + 20] == [
        "      51.0 s  set_param gaze = 17",
        "      51.5 s  --> R1 is violated",
        "      54.0 s  set_param gaze = 18",
        "      57.0 s  set_param gaze = 19",
        "      60.0 s  set_param gaze = 20",
        "      63.0 s  set_param gaze = 21",
        "  and 6 more actions later",
        "  and 2 more actions that had not begun when the run ended",
        "",
    ]


def test_a_known_violation_is_listed_after_the_cause() -> None:
    text = failure(_failing("R1", "R3"), REQUIREMENTS, seed=0, known_violations={"R1": "slow release"})
    assert text.startswith("R3 failed at 51.5 s by 0.02\n\nR3 Failed")
    assert "a known violation (slow release), which does not fail the run" in text[text.index("R1 Failed") :]


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
    miss = NearMiss(time_s=5.0, missing=tuple(missing), distance=distance)
    assert near_miss(miss) == shown


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
    assert generate_command(nodeid, suite, 0) == shown


def test_the_first_line_stands_alone_and_goes_by_time() -> None:
    test = _failing("R1", "R3")
    earlier = convert(sample_tests.requirement_result("Failed", 1.0), RequirementResult)
    earlier = replace(earlier, violations=tuple(replace(v, time_s=44.0, margin_s=50.5) for v in earlier.violations))
    test = replace(test, requirements={**test.requirements, "R3": earlier}, action_times_s=(1.0, 43.0, 45.0))
    lines = failure(test, REQUIREMENTS, seed=0, units={"hand_distance": "m"}).splitlines()
    assert lines[0] == "R3 failed at 44.0 s, by 0.02 m at 50.5 s, then R1"
    assert [line[:9] for line in lines if " Failed: " in line] == ["R3 Failed", "R1 Failed"]
    assert "      44.0 s  --> R3 is violated" in lines
    test = replace(test, requirements={"R3": earlier})
    text = headline(test, {}, {}, {"R3": "no crush prevention"})
    assert text == "R3 failed at 44.0 s, by 0.02 at 50.5 s (known)"


def test_a_brief_text_has_no_formulas_and_counts_what_else_was_checked() -> None:
    text = failure(_failing("R3", unchecked=["R1"]), REQUIREMENTS, seed=0, brief=True)
    assert "checked as" not in text
    assert "nearest at" not in text
    assert "\nothers:  2 passed, 1 not checked\n" in text
    test = _failing("R3", unchecked=["R1"])
    pending = replace(test.requirements["R1"], triggers=1, pending=1)
    test = replace(test, requirements={**test.requirements, "R1": pending})
    assert "\nothers:  2 passed, 1 pending at the end\n" in failure(test, REQUIREMENTS, seed=0, brief=True)
