"""Selecting with pytest's own means: -k, -m, --lf, node ids, paths."""

from __future__ import annotations

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change, in_each_mode, outcomes, report

BRIGHT = "rl-hall-polite-6c5fa14f"
NODE = f"test_lamps.py::test_lamps[{BRIGHT}]"


@pytest.mark.slow
@in_each_mode
def test_one_node_id(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    lamps.runpytest_inprocess("--hri-suite=rl", NODE, *options).assert_outcomes(xfailed=1)
    written = report(lamps.path)
    assert (written["selected"], written["reported"]) == (1, 1)
    assert outcomes(lamps.path) == {BRIGHT: "known-violation"}


@pytest.mark.slow
def test_keywords_and_marks(lamps: pytest.Pytester) -> None:
    change(
        lamps.path,
        "test_lamps.py",
        "def test_lamps(",
        "import pytest\n\n\n@pytest.mark.lit\ndef test_lamps(",
    )
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nmarkers = lit: with light")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "cellar", "-m", "lit")
    assert result.ret == 0
    assert list(outcomes(lamps.path).values()) == ["passed"]
    assert all("cellar" in name for name in outcomes(lamps.path))


@pytest.mark.slow
def test_a_selection_without_tests_leaves_the_last_report_alone(lamps: pytest.Pytester, after: SessionRunner) -> None:
    after("--hri-suite=by-hand")
    before = report(lamps.path)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "-k", "nobody")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.no_fnmatch_line("*human-robot interaction*")
    assert report(lamps.path) == before


@pytest.mark.slow
def test_last_failed(lamps: pytest.Pytester) -> None:
    strict = ("--hri-suite=rl", "--hri-strict")
    lamps.runpytest_inprocess(*strict).assert_outcomes(failed=2, passed=32)
    failed = {name for name, outcome in outcomes(lamps.path).items() if outcome == "failed"}
    lamps.runpytest_inprocess(*strict, "--lf").assert_outcomes(failed=2)
    assert set(outcomes(lamps.path)) == failed
    assert report(lamps.path)["suites"][0]["tests"] == 2


@pytest.mark.slow
def test_corners_are_other_tests_with_names_of_their_own(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-sampling=corners", "--hri-concretizations=2")
    assert result.ret == 0
    written = report(lamps.path)
    assert (written["selected"], written["reported"]) == (8, 8)
    ids = [test["id"] for test in written["tests"]]
    assert [name.endswith("-corners") for name in ids].count(True) == 4
    assert [name.endswith("-corners-k1") for name in ids].count(True) == 4
    pauses = [
        action["parameters"]["pause_s"]
        for test in written["tests"]
        for action in test["concrete"]["actions"]
        if action["parameters"]
    ]
    assert 0 < sum(pause in (0.5, 1.0) for pause in pauses) < len(pauses)
    assert written["rerun_options"]["options"] == ["--hri-concretizations=2", "--hri-sampling=corners"]
