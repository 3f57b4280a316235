"""Causes are the same for one test, on any engine, in a process for each test; where there are none, a line says so."""

from __future__ import annotations

import pytest

from tests import json_schema
from tests.extra.diagnosis.test_diagnosis_sessions import SUITE, surging  # noqa: F401 (a fixture)
from tests.extra.engines.test_sessions import two_engines
from tests.plugin.project import A_WORKER, change, report

pytestmark = pytest.mark.slow

SURGE = "passes without the disturbance surge"


def test_one_test_has_its_cause(surging: pytest.Pytester) -> None:  # noqa: F811
    (surging.path / "one.txt").write_text("enter cellar\ndisturb surge\nenter hall\n", encoding="utf-8")
    result = surging.runpytest_inprocess("-vv", "--hri-suite=one.txt", "--hri-strict")
    result.stdout.fnmatch_lines(["*1 test fails for 1 cause*", f"  why    {SURGE}: 1 of 1 test was run without it"])
    result.stdout.fnmatch_lines(["causes: *; no test passed: scores compare with none"])
    (cause,) = report(surging.path)["causes"]
    assert (cause["change"], cause["confirmed"]) == ("surge", 1)


@pytest.mark.parametrize("options", [("-x",), ("--maxfail=1", "-n", "1")])
def test_a_session_that_is_stopped_says_that_it_has_no_causes(
    surging: pytest.Pytester,  # noqa: F811
    options: tuple[str, ...],
) -> None:
    result = surging.runpytest_inprocess("-vv", *SUITE, *options)
    result.stdout.fnmatch_lines(["failure analysis skipped: session stopped early (-x, --maxfail, Ctrl-C)*"])
    assert "causes" not in report(surging.path)
    failed = next(test["replay"] for test in report(surging.path)["tests"] if test["outcome"] == "failed")
    replayed = surging.runpytest_inprocess("-vv", f"--hri-replay={failed}", "--hri-strict", "--hri-report=again")
    replayed.stdout.fnmatch_lines(["*1 test fails for 1 cause*", f"  why    {SURGE}: 1 of 1 test was run without it"])
    quiet = surging.runpytest_inprocess("-vv", *SUITE, "-x", "--hri-diagnose=0")
    assert "failure analysis skipped" not in quiet.stdout.str()


def test_isolated_tests_and_those_of_a_worker_have_the_same_causes(surging: pytest.Pytester) -> None:  # noqa: F811
    made = []
    for options in ((), ("--hri-isolate",), A_WORKER):
        surging.runpytest_inprocess(*SUITE, "--hri-diagnose=11", *options)
        made.append(report(surging.path)["causes"])
    assert made[0] == made[1] == made[2]


def test_what_fails_on_one_of_two_engines_is_no_cause_and_is_called_so(surging: pytest.Pytester) -> None:  # noqa: F811
    two_engines(surging, shift=30.0)
    change(surging.path, "requirements.toml", "lamp_level <= 80", "lamp_level <= 96")
    result = surging.runpytest_inprocess("-vv", *SUITE, "--hri-diagnose=11", "--hri-engine=both")
    json_schema.REPORT.validate(report(surging.path))
    (wish,) = report(surging.path)["causes"]
    assert len(wish["tests"]) == 2
    result.stdout.fnmatch_lines(["3 more tests failed", "  surges-3-actions-*  engine-sensitive  hri-report/*"])
