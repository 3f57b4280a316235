"""The suite `closure` through the plugin: what it reaches, what it depends on, and what is wrong input."""

from __future__ import annotations

import pytest

from tests.plugin.project import in_each_mode, outcomes, report

SUITE = "--hri-suite=closure"


@in_each_mode
def test_the_loop_reaches_all_that_the_model_can_reach(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    result = lamps.runpytest_inprocess(SUITE, "--hri-close-runs=60", *options)
    assert result.ret == 0
    (suite,) = report(lamps.path)["suites"]
    assert (suite["name"], suite["plans"]["visitor"]["missing"], suite["cross"]["missing"]) == ("closure", [], [])
    assert suite["code"]["statements"]["covered"] == 40  # all but the function that nobody calls
    assert sorted(outcomes(lamps.path).values()) == ["known-violation", *["passed"] * 7]
    result.stdout.fnmatch_lines(
        [
            "hricdv: closing 41 statements, 10 branches, 9 plans, 3 verdicts, 8 bins, at most 60 runs (seed 0) ...",
            "hricdv: closing ended (runs) after 60 runs, * open: 1 statement; 8 tests",
        ]
    )
