"""Shrinking through the plugin: the summary, the report and a replay file say what is left of a failing test."""

from __future__ import annotations

import shlex

import pytest

from tests import json_schema
from tests.plugin.project import A_WORKER, change, report
from tests.plugin.test_replay import refused

LONG = ["enter hall", "greet", *(f"set_lamp level = {level}" for level in (10, 0, 100, 10)), "leave"]
SUITE = "--hri-suite=long.txt"


@pytest.fixture
def long(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with a suite of its own: a test of seven actions, and one of eight, that fail R2."""
    lines = [*LONG, "", "enter hall", *LONG]
    (lamps.path / "long.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return lamps


@pytest.mark.slow
def test_the_shortest_failing_test_of_a_requirement_is_shrunk_and_can_be_replayed(long: pytest.Pytester) -> None:
    result = long.runpytest_inprocess(SUITE, "--hri-shrink", "--hri-strict")
    assert result.ret == 1
    written = report(long.path)
    json_schema.REPORT.validate(written)
    ((test, shrunk),) = [(each, each["shrunk"]["R2"]) for each in written["tests"] if each.get("shrunk")]
    assert test["abstract"] == LONG
    assert shrunk["abstract"] == ["set_lamp level = 100"]
    assert (shrunk["actions_before"], shrunk["end_reason"], shrunk["reason"]) == (7, "done", ["lamp_level <= 80"])
    assert shrunk["replay"] == f"hri-report/failures/{shrunk['id']}.json"
    command = f"pytest --hri-replay={shrunk['replay']} --hri-strict"
    result.stdout.fnmatch_lines(
        [
            f"hricdv: shrinking {test['id']}, which failed R2 ...",
            f"R2 of {test['id']} shrunk from 7 actions to 1, for lamp_level <= 80 (* runs, * s):",
            "  set_lamp level = 100: pause_s 0.75 s",
            "  run: patience_s 6.5 s",
            f"  {command}",
        ]
    )
    again = long.runpytest_inprocess(*shlex.split(command)[1:])
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines([f"replay of {shrunk['id']}: the same run, bit for bit"])
    (replayed,) = report(long.path)["tests"]
    assert replayed["concrete"] == {
        "actions": [{"command": "set_lamp level = 100", "parameters": {"pause_s": 0.75}}],
        "run": {"patience_s": 6.5},
    }


@pytest.mark.slow
def test_it_is_the_same_on_workers_and_nothing_is_shrunk_unasked(long: pytest.Pytester) -> None:
    found = []
    for options in (["--hri-shrink"], ["--hri-shrink", *A_WORKER], []):
        long.runpytest_inprocess(SUITE, *options)
        shrunk = [test["shrunk"]["R2"] | {"wall_s": 0} for test in report(long.path)["tests"] if test.get("shrunk")]
        found.append(shrunk)
    assert found == [found[0], found[0], []]


COUNTED = """def run(run):
    global RUNS
    RUNS += 1
    if RUNS > {limit}:
        raise KeyboardInterrupt
"""


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "actions"), [(2, 7), (3, 7), (8, 2)])
def test_ctrl_c_keeps_the_best_so_far_and_the_report(long: pytest.Pytester, limit: int, actions: int) -> None:
    change(long.path, "conftest.py", "LIMIT_S = 60.0\n", "LIMIT_S = 60.0\nRUNS = 0\n")
    change(long.path, "conftest.py", "def run(run):\n", COUNTED.format(limit=limit))
    result = long.runpytest_inprocess(SUITE, "--hri-shrink", no_reraise_ctrlc=True)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    (test,) = [test for test in report(long.path)["tests"] if test.get("shrunk")]
    shrunk = test["shrunk"]["R2"]
    assert (shrunk["end_reason"], len(shrunk["abstract"])) == ("interrupted", actions)
    result.stdout.fnmatch_lines(["*; interrupted, a shorter test may exist):"])
    if shrunk["replay"]:
        assert (long.path / shrunk["replay"]).is_file()


@pytest.mark.slow
def test_a_failure_that_its_fixture_made_is_told_from_one_that_can_be_shrunk(lamps: pytest.Pytester) -> None:
    planted = "def test_lamps(hri_case, monkeypatch):\n    monkeypatch.setattr('lamps.guide.SWITCHING_S', 1.5)"
    change(lamps.path, "test_lamps.py", "def test_lamps(hri_case):", planted)
    result = lamps.runpytest_inprocess("--hri-suite=rl", "--hri-shrink", "--hri-known=R1")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["R1 of rl-* was not shrunk: it did not fail again outside of its test function: *"])


@pytest.mark.parametrize("option", ["--hri-shrink-runs=0", "--hri-shrink-seconds=soon"])
def test_a_budget_that_makes_no_sense_is_refused(lamps: pytest.Pytester, option: str) -> None:
    assert f"{option}: expected " in refused(lamps, "--hri-suite=by-hand", "--hri-shrink", option)
