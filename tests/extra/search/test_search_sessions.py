"""The search for violations through the plugin: what it says, what it leaves, and whether it fails the run."""

from __future__ import annotations

import shlex

import pytest

from tests import json_schema
from tests.plugin.project import change, report
from tests.plugin.test_replay import refused

TIGHT = ("eventually[0:2](on(answer))", "eventually[0:0.98](on(answer))")


@pytest.fixture
def tight(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with a requirement that its suite does not violate, but that its ranges allow to be violated."""
    change(lamps.path, "requirements.toml", *TIGHT)
    return lamps


@pytest.mark.slow
def test_a_violation_beside_the_suite_fails_the_run_and_can_be_replayed(tight: pytest.Pytester) -> None:
    assert tight.runpytest_inprocess("--hri-suite=rl").ret == 0
    result = tight.runpytest_inprocess("--hri-suite=rl", "--hri-search=40")
    assert result.ret == 1
    result.assert_outcomes(passed=32, xfailed=2)
    written = report(tight.path)
    json_schema.REPORT.validate(written)
    found = written["search"]["R3"]
    assert found["status"] == "violated"
    assert found["suite_margin"] > 0.0 > found["margin"]
    assert found["runs"] <= 40
    command = f"pytest --hri-replay={found['replay']}"
    result.stdout.fnmatch_lines(
        [
            f"violation of R3 found: a variant of {found['test']}, margin -* (* runs, * s)",
            f"  {command}",
            f"FAILED R3 is violated by a test that a search found: {found['id']}",
        ]
    )
    again = tight.runpytest_inprocess("-v", *shlex.split(command)[1:])
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines(["R3 Failed: *", f"replay of {found['id']}: the same run, bit for bit"])


@pytest.mark.slow
def test_a_search_is_the_same_on_workers_and_another_with_another_seed(lamps: pytest.Pytester) -> None:
    found = []
    for options in ([], ["-n", "2"], ["--hri-seed=1"]):
        lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-search=5", *options)
        found.append({name: each | {"wall_s": 0} for name, each in report(lamps.path)["search"].items()})
    assert found[0] == found[1]
    assert found[0] != found[2]


@pytest.mark.slow
def test_a_known_violation_that_is_found_does_not_fail_the_run_and_is_shrunk(tight: pytest.Pytester) -> None:
    options = ("--hri-suite=rl", "--hri-search=40", "--hri-known=R3")
    result = tight.runpytest_inprocess(*options, "--hri-shrink")
    assert result.ret == 0
    found = report(tight.path)["search"]["R3"]
    assert "greet" in found["shrunk"]["abstract"]
    assert len(found["shrunk"]["abstract"]) <= 2
    result.stdout.fnmatch_lines([f"R3 of {found['id']} shrunk from *"])
    assert tight.runpytest_inprocess(*options, "--hri-strict", "-k", "cellar").ret == 1


@pytest.mark.slow
def test_ctrl_c_in_a_search_keeps_the_report(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", "LIMIT_S = 60.0\nRUNS = 0\n")
    stop = "def run(run):\n    global RUNS\n    RUNS += 1\n    if RUNS > 10:\n        raise KeyboardInterrupt\n"
    change(lamps.path, "conftest.py", "def run(run):\n", stop)
    result = lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-search=40", no_reraise_ctrlc=True)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    written = report(lamps.path)
    assert [test["outcome"] for test in written["tests"]].count("passed") == 3
    assert written["search"]["R1"]["end_reason"] == "interrupted"
    assert list(written["search"]) == ["R1"]


@pytest.mark.parametrize("option", ["--hri-search=0", "--hri-search=many"])
def test_a_number_of_runs_that_makes_no_sense_is_refused(lamps: pytest.Pytester, option: str) -> None:
    assert f"{option}: expected " in refused(lamps, "--hri-suite=by-hand", option)
