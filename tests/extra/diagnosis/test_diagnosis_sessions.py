"""Causes through the plugin: what failing tests fail for, in the terminal, in `report.json` and on the page."""

from __future__ import annotations

import re

import pytest

from tests import json_schema
from tests.plugin.project import change, command, report

IMPORT = "\n    from pytest_hricdv.testbench import Disturbance"
SURGE = """code=("lamps",),
        disturbances={
            "surge": Disturbance({"level": Uniform(90.0, 95.0, "%")}, lambda lamp, given: lamp.set(given["level"])),
            "flicker": Disturbance({}, lambda lamp, given: lamp.set(0.0)),
        },"""

TESTS = [
    ["enter cellar", "disturb flicker", "enter hall", "disturb surge", "enter cellar"],
    ["enter cellar", "disturb surge", "enter hall"],
    ["enter cellar", "disturb surge", "enter cellar", "disturb flicker", "leave"],
    ["enter hall", "set_lamp level = 100"],
    ["enter hall", "enter hall", "set_lamp level = 100"],
    *(["enter cellar", *["disturb flicker"] * number, "leave"] for number in range(1, 5)),
    *(["enter hall"] * number for number in range(1, 5)),
]


@pytest.fixture
def surging(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project, which looks for causes: a surge makes the lamp too bright, and so does a wish in the hall."""
    change(lamps.path, "pytest.ini", "hri_diagnose = 0\n", "")
    change(lamps.path, "conftest.py", 'code=("lamps",),', SURGE)
    change(
        lamps.path,
        "conftest.py",
        "Model, Testbench, Uniform",
        "Model, Testbench, Uniform\n    from pytest_hricdv.testbench import Disturbance",
    )
    target = "    lamp.set(0.0)\n    run.set_disturbance_target(lamp)\n"
    change(lamps.path, "conftest.py", "    lamp.set(0.0)\n", target)
    (lamps.path / "surges.txt").write_text("\n\n".join("\n".join(test) for test in TESTS) + "\n", encoding="utf-8")
    return lamps


SUITE = ("--hri-suite=surges.txt", "--hri-strict")
BUDGET = "--hri-diagnose=22"
"""Runs of experiments: too few to try the third test of a surge."""


@pytest.mark.slow
def test_causes_come_before_failures_and_are_confirmed_by_runs(surging: pytest.Pytester) -> None:
    result = surging.runpytest_inprocess("-vv", *SUITE, BUDGET)
    assert result.ret == 1
    written = report(surging.path)
    json_schema.REPORT.validate(written)
    lines = [test["executed_lines"] for test in written["tests"] if test["outcome"] == "failed"]
    assert len(lines) == 5
    assert all(traced["files"] and traced["nodes"] and "note" not in traced for traced in lines)
    assert not any("executed_lines" in test for test in written["tests"] if test["outcome"] == "passed")
    surge, wish = written["causes"]
    assert (surge["change"], surge["requirements"], len(surge["tests"]), surge["confirmed"]) == ("surge", ["R2"], 3, 2)
    assert (wish.get("change"), wish["requirements"], len(wish["tests"])) == (None, ["R2"], 2)
    assert (written["diagnosis"]["budget"], written["diagnosis"]["end_reason"]) == (22, "runs")
    assert surge["minimal_pair"]["kind"] == "disturbance"
    assert surge["minimal_pair"]["failing"][0]["text"] == "R2 is violated"
    assert wish["minimal_pair"]["neighbour"]["abstract"][0] == "enter hall"
    assert "\tvisitor\twish\t" in wish["minimal_pair"]["neighbour"]["timeline"]["messages"][0]
    assert surge["minimal_pair"]["neighbour"]["lines"]["nodes"]
    assert wish["deciding_change"] == "passes with set_lamp level = 10 instead of set_lamp level = 100"
    texts = [event["text"] for event in wish["minimal_pair"]["failing"]]
    assert texts[0] == "R2 is violated"
    assert [place["text"] for place in wish["locations"] if place.get("experiment")]
    result.stdout.fnmatch_lines(
        [
            "*5 tests fail for 2 causes*",
            "cause 1 (????????): R2 in 3 tests*",
            "  why    passes without the disturbance surge: 2 of 3 tests were run without it",
            "cause 2 (????????): R2 in 2 tests*",
        ]
    )
    page = (surging.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert "passes without the disturbance surge" in page
    assert "The same test passes with set_lamp level = 10 instead of set_lamp level = 100" in page
    violated = next(event for event in wish["minimal_pair"]["failing"] if event["text"] == "R2 is violated")
    assert re.search(rf'href="#test/[^"]+@{violated["time_s"]:.3f}">{violated["time_s"]:.3f} s</a>', page)


@pytest.mark.slow
def test_a_merged_report_has_the_causes_of_all_shards(surging: pytest.Pytester) -> None:
    surging.runpytest_inprocess(*SUITE, BUDGET)
    whole = report(surging.path)["causes"]
    for shard in ("1", "2"):
        surging.runpytest_inprocess(*SUITE, BUDGET, f"--hri-shard={shard}/2", f"--hri-report=part{shard}")
    command("merge", "part1", "part2", "-o", "hri-report")
    merged = report(surging.path)
    json_schema.REPORT.validate(merged)
    parts, once = (
        [[cause.get(key) for key in ("id", "tests", "minimal_pair")] for cause in causes]
        for causes in (merged["causes"], whole)
    )
    assert [part[:2] for part in parts] == [part[:2] for part in once]
    assert parts[0][2]["words"] == once[0][2]["words"]
    assert "R2 is then never triggered" in parts[1][2]["words"]  # a shard of few tests finds no better change
    assert merged["causes"][0]["confirmed"] == 3  # each shard had as many runs as the whole
    assert "R2 is then never triggered" in (surging.path / "hri-report" / "index.html").read_text(encoding="utf-8")


KILLED = """    lamp.set(0.0)
    run.set_disturbance_target(lamp)
    if "-experiment-" in run.test.id:
        with (HERE / "experiments").open("a") as log:
            log.write(f"{run.test.id}\\n")
        if len((HERE / "experiments").read_text().splitlines()) == 6:
            import os
            import signal
            os.kill(os.getppid(), signal.SIGKILL)
"""


@pytest.mark.slow
def test_a_diagnosis_that_is_killed_goes_on_and_is_in_a_rebuilt_report(surging: pytest.Pytester) -> None:
    change(surging.path, "conftest.py", "    lamp.set(0.0)\n    run.set_disturbance_target(lamp)\n", KILLED)
    arguments = (*SUITE, BUDGET)
    killed = surging.runpytest_subprocess(*arguments)
    assert killed.ret == -9
    command("rebuild", "hri-report")
    surge, wish = report(surging.path)["causes"]
    assert (surge["change"], surge["confirmed"], wish.get("deciding_change")) == ("surge", 2, None)
    surging.runpytest_subprocess(*arguments, "--hri-resume")
    written = report(surging.path)
    surge, wish = written["causes"]
    assert surge["confirmed"] == 2
    assert wish["deciding_change"] == "passes with set_lamp level = 10 instead of set_lamp level = 100"
    made = (surging.path / "experiments").read_text(encoding="utf-8").splitlines()
    assert len(made) == len({*made}) + 1  # the one at which it was killed


@pytest.mark.slow
def test_a_test_is_reduced_to_what_it_needs_and_kept(surging: pytest.Pytester) -> None:
    surging.runpytest_inprocess(*SUITE, "--hri-diagnose=60")
    wish = report(surging.path)["causes"][1]
    assert (wish["minimal"], wish["is_shrunk"]) == (["set_lamp level = 100"], True)
    assert wish["minimal_of"] in wish["tests"]
    again = surging.runpytest_inprocess(f"--hri-replay={wish['replay']}", "--hri-strict", "--hri-report=again")
    again.assert_outcomes(failed=1, deselected=1)


@pytest.mark.slow
def test_a_new_violation_among_known_ones_is_the_one_that_is_shown_and_reduced(surging: pytest.Pytester) -> None:
    bright, dim = ["enter hall", "set_lamp level = 100"], ["greet", "set_lamp level = 10"]
    tests = [bright, ["greet", "greet", *bright], dim, ["greet", *dim]]
    (surging.path / "greets.txt").write_text("\n\n".join(map("\n".join, tests)) + "\n", encoding="utf-8")
    known = "--hri-known=R2 when count(on(greeting)) < 1: without a greeting it may be bright"
    surging.runpytest_inprocess("--hri-suite=greets.txt", known, "--hri-diagnose=200")
    cause, unanswered = report(surging.path)["causes"]
    assert (len(cause["tests"]), cause["minimal"]) == (2, ["greet", "set_lamp level = 100"])
    assert (unanswered["requirements"], unanswered["minimal"]) == (["R3"], ["greet"])  # of the same test
    again = surging.runpytest_inprocess(f"--hri-replay={cause['replay']}", known, "--hri-report=again")
    again.assert_outcomes(failed=1, deselected=1)


@pytest.mark.slow
def test_the_budget_and_zero(surging: pytest.Pytester) -> None:
    surging.runpytest_inprocess(*SUITE)
    diagnosis = report(surging.path)["diagnosis"]
    assert (diagnosis["budget"], diagnosis["end_reason"]) == (48, "done")
    assert 11 < diagnosis["runs"] <= 48
    surging.runpytest_inprocess(*SUITE, "--hri-diagnose=0")
    assert "causes" not in report(surging.path)


SPIN = """    while True:
        try:
            while True:
                pass
        except BaseException:
            pass
"""


@pytest.mark.slow
def test_a_test_whose_code_works_for_ever_is_in_no_experiment(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", 'code=("lamps",),', 'code=("lamps",), time=VirtualTime(stall_timeout_s=0.5),')
    change(lamps.path, "conftest.py", "Testbench, Uniform", "Testbench, Uniform, VirtualTime")
    change(lamps.path, "lamps/guide.py", "    if wish.level == 0.0:\n", SPIN + "    if wish.level == 0.0:\n")
    change(lamps.path, "pytest.ini", "hri_diagnose = 0\n", "")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == 1
    written = report(lamps.path)
    assert written["diagnosis"]["runs"] == 0
    assert {name for cause in written["causes"] for name in cause["tests"]}.issuperset(
        test["id"] for test in written["tests"] if test["outcome"] != "passed"
    )
    result.stdout.fnmatch_lines(
        ["*catches whatever is raised in it: no time has passed for 0.5 s of work, at *guide.py:*"]
    )


@pytest.mark.slow
def test_causes_that_are_new_or_gone_since_the_session_before_are_named(surging: pytest.Pytester) -> None:
    surging.runpytest_inprocess(*SUITE, BUDGET)
    causes = [cause["id"] for cause in report(surging.path)["causes"]]
    change(surging.path, "conftest.py", "Uniform(90.0, 95.0", "Uniform(20.0, 25.0")
    without = surging.runpytest_inprocess(*SUITE, BUDGET)
    left = [cause["id"] for cause in report(surging.path).get("causes", [])]
    gone = [name for name in causes if name not in left]
    assert gone
    without.stdout.fnmatch_lines([f"  cause {gone[0]} is gone: *"])
    change(surging.path, "conftest.py", "Uniform(20.0, 25.0", "Uniform(90.0, 95.0")
    again = surging.runpytest_inprocess(*SUITE, BUDGET)
    again.stdout.fnmatch_lines([f"  new cause {gone[0]}: *"])
