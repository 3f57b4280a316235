"""A run: its report, and that it is the same however and wherever it is run."""

from __future__ import annotations

from typing import Any

import pytest

from tests import json_schema
from tests.plugin.conftest import SessionRunner
from tests.plugin.project import (
    A_WORKER,
    MODES,
    change,
    counted_up_to_313,
    report,
)


def timeless(test: dict[str, Any]) -> dict[str, Any]:
    """A test's entry without its wall clock."""
    return {key: value for key, value in test.items() if key != "wall_s"}


@pytest.mark.slow
def test_a_run_is_the_same_in_every_mode_and_for_one_test_alone(lamps: pytest.Pytester) -> None:
    reports = {}
    for mode, options in MODES.items():
        result = lamps.runpytest_subprocess("--hri-suite=rl", *options)
        assert result.ret == 0, mode
        reports[mode] = report(lamps.path)
        json_schema.REPORT.validate(reports[mode])
    plain = reports["plain"]
    assert [reports[mode]["workers"] for mode in MODES] == [1, 2, 1]
    assert plain["selected"] == plain["reported"] == len(plain["tests"]) == 34
    for other in reports.values():
        assert [*map(timeless, other["tests"])] == [*map(timeless, plain["tests"])]
        assert other["code_under_test"] == plain["code_under_test"]
        for key in ("requirements", "code", "plans", "cross", "curve"):
            assert other["suites"][0][key] == plain["suites"][0][key]

    (known,) = [test for test in plain["tests"] if test["id"].startswith("rl-hall-polite-6c")]
    assert lamps.runpytest_inprocess("--hri-suite=rl", known["nodeid"]).ret == 0
    (alone,) = report(lamps.path)["tests"]
    assert timeless(alone) == timeless(known)
    assert alone["record_sha256"] == known["record_sha256"] != ""


@pytest.mark.slow
@counted_up_to_313
def test_the_report_says_what_was_judged_and_covered(finished: SessionRunner) -> None:
    session = finished("--hri-suite=rl")
    session.result.assert_outcomes(passed=32, xfailed=2, deselected=1)
    written = report(session.path)
    (suite,) = written["suites"]
    tallies = suite["requirements"].items()
    assert {name: (t["passed"], t["failed"], t["nc"]) for name, t in suite["requirements"].items()} == {
        "R1": (28, 0, 6),
        "R2": (24, 2, 8),
        "R3": (23, 0, 11),
    }
    assert {agent: (len(plans["covered"]), plans["total"]) for agent, plans in suite["plans"].items()} == {
        "visitor": (7, 7),
        "guide": (2, 2),
    }
    statements, branches = suite["code"]["statements"], suite["code"]["branches"]
    assert (statements["covered"], statements["total"]) == (40, 41)
    assert (branches["covered"], branches["total"]) == (10, 10)
    assert [suite["cross"][key] for key in ("bins", "hit", "impossible", "illegal")] == [8, 8, 0, 0]
    assert suite["cross"]["missing"] == suite["cross"]["products"]["light"]["missing"] == []
    assert {
        name: [t[key] for key in ("triggers", "passes", "failures", "pending", "untriggered")] for name, t in tallies
    } == {
        "R1": [28, 28, 0, 0, 6],
        "R2": [26, 24, 2, 0, 8],
        "R3": [23, 23, 0, 0, 11],
    }
    dark = suite["plans"]["visitor"]["reached"]["v5"]
    assert {"curt", "dark"} < set(dark["shortest"])
    model = written["models"]["visitor"]
    assert model["source"].splitlines()[model["plans"]["v5"] - 1].startswith("@v5 ")
    assert suite["curve"][-1] == {"tests": 34, "statements": 40, "branches": 10, "plans": 9}
    assert suite["generation"]["converged_at"] is not None
    (guide,) = [file for file in written["code_under_test"]["files"] if file["missing_lines"]]
    assert guide["file"] == "lamps/guide.py"
    (line,) = guide["missing_lines"]
    assert (session.path / "lamps/guide.py").read_text().splitlines()[line - 1].strip() == 'return "by hand"'
    assert "<html" in (session.path / "hri-report" / "index.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_an_exported_suite_runs_as_the_original_did(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-export=kept")
    before = report(lamps.path)["tests"]
    assert lamps.runpytest_inprocess("--hri-suite=kept").ret == 0
    assert [*map(timeless, report(lamps.path)["tests"])] == [*map(timeless, before)]


@pytest.mark.slow
def test_a_case_shared_with_other_parameters_and_fixtures_runs_for_each(lamps: pytest.Pytester) -> None:
    change(
        lamps.path,
        "test_lamps.py",
        "def test_lamps(hri_case):",
        "import pytest\n\n\n@pytest.mark.parametrize('shop', ['north-1', 'south'])\ndef test_lamps(shop, hri_case):",
    )
    for options in ((), A_WORKER):
        assert lamps.runpytest_inprocess("--hri-suite=by-hand", *options).ret == 0
        written = report(lamps.path)
        assert written["selected"] == written["reported"] == 8
        assert len({test["nodeid"] for test in written["tests"]}) == 2 * len({test["id"] for test in written["tests"]})


@pytest.mark.slow
def test_workers_import_nothing_that_only_their_controller_uses(lamps: pytest.Pytester) -> None:
    lamps.makepyfile(
        noting="""
        import pathlib, sys

        def pytest_sessionfinish(session):
            worker = hasattr(session.config, "workerinput")
            pathlib.Path("worker" if worker else "controller").write_text("\\n".join(sys.modules))
        """
    )
    result = lamps.runpytest_subprocess("--hri-suite=rl", "--hri-tests=2", "-n", "1", "-p", "noting")
    assert result.ret == 0
    controller, worker = ({*(lamps.path / name).read_text().splitlines()} for name in ("controller", "worker"))
    only = {"pytest_hricdv.session.reporting", "pytest_hricdv.session.aggregation", "pytest_hricdv.bdi"}
    assert only <= controller
    assert not only & worker
