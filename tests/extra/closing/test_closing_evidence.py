"""What a closing loop has shown, through the plugin: in the report, in the summary, and from the cache."""

from __future__ import annotations

import pytest

from tests.json_schema import REPORT
from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change, counted_up_to_313, report

SUITE = ("--hri-suite=closure", "--hri-close-runs=40")


@pytest.mark.slow
@counted_up_to_313
def test_each_point_is_hit_by_a_test_or_impossible_or_open_with_what_is_known_of_it(finished: SessionRunner) -> None:
    session = finished(*SUITE, "-v")
    whole = report(session.path)
    REPORT.validate(whole)
    closing, tests = whole["closing"], {test["id"]: test for test in whole["tests"]}
    assert closing["kinds"]["statement"] == {"hit": 40, "impossible": 0, "open": 1}
    assert {each["test"] for each in closing["hit"]} == set(tests)
    for each in closing["hit"]:
        kind, *names = each["point"]
        if kind == "plan":
            assert names[1] in tests[each["test"]]["plans"][names[0]]
        if kind == "bin":
            assert names[1:] in tests[each["test"]]["cross"][names[0]]
    (nobody_calls,) = closing["open"]
    assert nobody_calls["point"][0] == "statement"
    tries = nobody_calls["tries"]
    assert nobody_calls.get("bound") == (min(1.0, 3.0 / tries) if tries else None)
    assert nobody_calls["test"] in tests
    assert nobody_calls["waiver"].endswith(": # unreachable: why")
    (glare,) = closing["violations"]
    assert (glare["requirement"], glare["part"], glare["known"]) == ("R2", "lamp_level <= 80", True)
    assert tests[glare["test"]]["outcome"] == "known-violation"
    assert sum(sum(step["new"].values()) for step in closing["growth"]) == len(closing["hit"])
    session.result.stdout.fnmatch_lines(
        [
            "closing: * runs, * simulated; ended: the budget of runs is used up",
            "  statements *  40 *  0 *  1",
            "  open: lamps/guide.py:*: executed up to line 43*",
        ]
    )


def test_a_session_without_a_loop_has_none(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert "closing" not in report(lamps.path)


@pytest.mark.slow
def test_transitions_of_the_state_are_covered_like_other_points(lamps: pytest.Pytester) -> None:
    messages, guide = lamps.path / "lamps" / "messages.py", "lamps/guide.py"
    messages.write_text(messages.read_text(encoding="utf-8").rstrip() + "\n    name: str\n", encoding="utf-8")
    change(lamps.path, guide, "        clock.sleep(", '        bus.publish(Switched(level, "busy")); clock.sleep(')
    change(lamps.path, guide, "Switched(level))", 'Switched(level, "on" if level else "off"))')
    wanted = 'transitions=(("busy", "on"), ("busy", "off"), ("off", "gone"))'
    change(
        lamps.path, "conftest.py", 'code=("lamps",),', f'code=("lamps",), state=StateField("switched.name", {wanted}),'
    )
    result = lamps.runpytest_inprocess(*SUITE)
    closing = report(lamps.path)["closing"]
    assert closing["kinds"]["transition"] == {"hit": 2, "impossible": 0, "open": 1}
    (never,) = [each for each in closing["open"] if each["point"][0] == "transition"]
    assert never["point"] == ["transition", "off", "gone"]
    result.stdout.fnmatch_lines(["  open: off -> gone: *"])


@pytest.mark.slow
def test_each_conjunct_of_an_antecedent_is_to_be_true_and_false(lamps: pytest.Pytester) -> None:
    change(lamps.path, "requirements.toml", "always(lamp_level > 0 ->", "always(lamp_level > 0 & lamp_level < 1000 ->")
    result = lamps.runpytest_inprocess(*SUITE)
    closing = report(lamps.path)["closing"]
    (never,) = [each for each in closing["open"] if each["point"][0] == "condition" and each["point"][1] == "R2"]
    assert never["point"] == ["condition", "R2", "lamp_level < 1000", "false"]
    assert never["lacking"] == "it was always true: the antecedent may do without it"
    hit = [each["point"] for each in closing["hit"]]
    assert ["condition", "R2", "lamp_level > 0", "false"] in hit
    result.stdout.fnmatch_lines(["  open: R2: lamp_level < 1000 false: *"])
