"""Physics engines: one is chosen, and with `--hri-engine=both` two check each other."""

from __future__ import annotations

from typing import Any

import pytest

from tests import json_schema
from tests.plugin.project import change, report

BY_HAND = "--hri-suite=by-hand"


def two_engines(lamps: pytest.Pytester, *, shift: float = 0.0, tolerance: float = 1.0, ends: str = "released") -> None:
    """Lamps that are simulated with incandescent bulbs, or with LEDs that are brighter by `shift`.

    Args:
        lamps: the project.
        shift: of each level that is not 0, in percent.
        tolerance: of R2's margins.
        ends: how an interaction ends with LEDs.
    """
    (lamps.path / "bulb.py").write_text("SHIFT, ENDS = 0.0, 'released'\n", encoding="utf-8")
    (lamps.path / "led.py").write_text(f"SHIFT, ENDS = {shift}, {ends!r}\n", encoding="utf-8")
    engines = f'engines={{"bulb": "bulb", "led": "led"}}, engine_tolerances={{"R2": {tolerance}}}'
    engines = f"simulation=Simulation({engines})"
    change(lamps.path, "conftest.py", "        run=run,\n", f"        run=run,\n        {engines},\n")
    change(
        lamps.path,
        "conftest.py",
        "    class Lamp:\n",
        "    import importlib\n\n    engine = importlib.import_module(run.engine)\n\n    class Lamp:\n",
    )
    level = '"lamp_level", level'
    change(lamps.path, "conftest.py", level, f"{level} + (engine.SHIFT if level else 0.0)")
    change(lamps.path, "conftest.py", 'outcomes=("released",)', "outcomes=(engine.ENDS,)")


def outcomes(lamps: pytest.Pytester) -> dict[str, list[dict[str, Any]]]:
    """Outcome -> tests of the report."""
    found: dict[str, list[dict[str, Any]]] = {}
    for test in report(lamps.path)["tests"]:
        found.setdefault(test["outcome"], []).append(test)
    return found


@pytest.mark.slow
def test_the_first_engine_is_used_unless_another_one_is_asked_for(lamps: pytest.Pytester) -> None:
    two_engines(lamps, shift=0.5)
    lamps.runpytest_inprocess(BY_HAND)
    assert {test["engine"] for test in report(lamps.path)["tests"]} == {"bulb"}
    hashes = {test["record_sha256"] for test in report(lamps.path)["tests"]}
    result = lamps.runpytest_inprocess("-v", BY_HAND, "--hri-engine=led", "--hri-strict")
    result.stdout.fnmatch_lines(
        [
            "hri: physics by led",
            "  pytest --hri-replay=* --hri-engine=led --hri-strict",
            "suite by-hand, seed 0: 4 tests on led",
        ]
    )
    assert {test["engine"] for test in report(lamps.path)["tests"]} == {"led"}
    assert hashes != {test["record_sha256"] for test in report(lamps.path)["tests"]}


@pytest.mark.slow
def test_an_engine_that_is_not_installed_is_passed_over_and_the_header_says_so(lamps: pytest.Pytester) -> None:
    two_engines(lamps)
    (lamps.path / "bulb.py").unlink()
    result = lamps.runpytest_inprocess(BY_HAND)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["hri: physics by led (bulb is not installed)"])


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("lde", "ERROR: engine 'lde': testbench 'lamps' has bulb, led, both"),
        ("bulb", "ERROR: engine 'bulb': No module named 'bulb'; or choose another one with --hri-engine: led"),
        ("both", "ERROR: engine 'bulb': No module named 'bulb'; or choose another one with --hri-engine: led"),
    ],
)
def test_an_engine_that_is_not_there_is_refused(lamps: pytest.Pytester, option: str, message: str) -> None:
    two_engines(lamps)
    (lamps.path / "bulb.py").unlink()
    result = lamps.runpytest_inprocess(BY_HAND, f"--hri-engine={option}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([message])
    assert not (lamps.path / "hri-report").exists()


def test_a_testbench_without_engines_says_so(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess(BY_HAND, "--hri-engine=led")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: engine 'led': testbench 'lamps' has none: give it *Simulation(engines=*"])


@pytest.mark.slow
def test_engines_that_agree_change_nothing(lamps: pytest.Pytester) -> None:
    two_engines(lamps, shift=-1e-9)
    lamps.runpytest_inprocess(BY_HAND)
    alone = report(lamps.path)
    result = lamps.runpytest_inprocess("-v", BY_HAND, "--hri-engine=both")
    assert result.ret == 0
    result.stdout.fnmatch_lines(
        [
            "hri: each test on bulb and on led",
            "suite by-hand, seed 0: 4 tests on bulb and led",
            "engines: 4 tests on bulb and led",
            "  interactions: 4 of 4 end alike (100.0 %)",
            "  verdicts: 12 of 12 agree (100.0 %)",
        ]
    )
    both = report(lamps.path)
    json_schema.REPORT.validate(both)
    for one, two in zip(alone["tests"], both["tests"], strict=True):
        assert two["cross_check"]["differences"] == []
        assert {k: v for k, v in two.items() if k not in ("cross_check", "wall_s")} == {
            key: value for key, value in one.items() if key != "wall_s"
        }


@pytest.mark.slow
def test_a_verdict_that_depends_on_the_engine_is_no_pass(lamps: pytest.Pytester) -> None:
    two_engines(lamps, shift=0.5)
    result = lamps.runpytest_inprocess("-v", "--hri-suite=rl", "--hri-engine=both", "--hri-strict", "-rx")
    found = outcomes(lamps)
    json_schema.REPORT.validate(report(lamps.path))
    text = "R2: passed on bulb by +0, failed on led by -0.5: within engine tolerance"
    assert {test["failure"] for test in found["engine-sensitive"]} == {f"engine-sensitive: {text}"}
    assert all("cellar" in test["id"] for test in found["engine-sensitive"])
    result.stdout.fnmatch_lines(
        [
            "  R2: * agree, * within tolerance; margins differ by at most 0.5 %",
            "  rl-cellar-*",
            "    R2: passed on bulb by +0, failed on led by -0.5: within engine tolerance",
        ]
    )
    for test in found["passed"]:
        assert test["cross_check"]["differences"] == []
    for test in found["failed"]:  # a hall that glares does so on both
        assert test["requirements"]["R2"]["verdict"] == test["cross_check"]["requirements"]["R2"]["verdict"] == "Failed"


@pytest.mark.slow
def test_a_difference_that_no_margin_explains_fails_the_test(lamps: pytest.Pytester) -> None:
    two_engines(lamps, shift=0.5, tolerance=0.1)
    lamps.runpytest_inprocess("--hri-suite=rl", "--hri-engine=both", "--hri-strict")
    texts = {test["failure"] for test in outcomes(lamps)["failed"] if "cellar" in test["id"]}
    assert texts == {"engine-sensitive: R2: passed on bulb by +0, failed on led by -0.5: outcome differs: investigate"}


def test_another_course_of_the_run_fails_the_test(lamps: pytest.Pytester) -> None:
    two_engines(lamps, ends="broken")
    result = lamps.runpytest_inprocess(BY_HAND, "--hri-engine=both")
    assert result.ret == 1
    assert "passed" not in outcomes(lamps)
    (text,) = {test["failure"] for test in outcomes(lamps)["failed"]}
    assert text == "engine-sensitive: interactions: released on bulb, broken on led: outcome differs: investigate"


@pytest.mark.slow
def test_what_fails_on_one_engine_outside_of_the_known_condition_is_not_known(lamps: pytest.Pytester) -> None:
    two_engines(lamps, shift=-2.0)
    known = "--hri-known=R2 when lamp_level > 99: the hall has no dimmer"
    lamps.runpytest_inprocess("--hri-suite=rl", known)
    glaring = {test["id"] for test in outcomes(lamps)["known-violation"]}
    assert "failed" not in outcomes(lamps)
    assert lamps.runpytest_inprocess("--hri-suite=rl", "--hri-engine=both", known).ret == 1
    assert {test["id"] for test in outcomes(lamps)["failed"]} == glaring
