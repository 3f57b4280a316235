"""Coverage of the code under test, alone and beside the user's own `--cov`. Each run is a process of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.plugin.project import MODES, change, report

SUITE = "--hri-suite=by-hand"


def own(folder: Path) -> dict[str, tuple[list[int], list[list[int]]]]:
    """The lines and branches that the user's own coverage misses, by file."""
    found = json.loads((folder / "coverage.json").read_text(encoding="utf-8"))
    return {name: (file["missing_lines"], file["missing_branches"]) for name, file in found["files"].items()}


def ours(folder: Path) -> dict[str, Any]:
    """All that the report says of the code under test."""
    written = report(folder)
    return {
        "code": written["suites"][0]["code"],
        "files": written["code_under_test"]["files"],
        "tests": {test["id"]: test["code"] for test in written["tests"]},
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        pytest.param(MODES["on two workers"], id="on two workers"),
        pytest.param(("--cov-config=greenlets",), id="told of greenlets"),
        pytest.param(("--hri-no-cov",), id="without ours"),
    ],
)
def test_beside_the_users_own_measurement_both_are_right(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    (lamps.path / "greenlets").write_text("[run]\nconcurrency = greenlet\n", encoding="utf-8")
    lamps.runpytest_inprocess(SUITE)
    alone = ours(lamps.path)
    result = lamps.runpytest_subprocess(SUITE, "--cov=lamps", "--cov-branch", "--cov-report=json", *options)
    assert result.ret == 0
    missing = {file["file"]: (file["missing_lines"], file["missing_branches"]) for file in alone["files"]}
    assert own(lamps.path) == missing
    assert missing["lamps/guide.py"] == ([44], [])
    if "--hri-no-cov" not in options:
        assert ours(lamps.path) == alone


def test_switched_off_it_is_unmeasured_and_never_zero_percent(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("-v", SUITE, "--hri-no-cov")
    written = report(lamps.path)
    assert written["suites"][0]["code"] == {"statements": None, "branches": None}
    assert written["code_under_test"]["measured"] is False
    assert written["code_under_test"]["files"] == []
    assert all(test["code"] is None for test in written["tests"])
    result.stdout.fnmatch_lines(["  statements * unmeasured: switched off*"])
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert '<span class="big">unmeasured</span>code under test: switched off' in page


def test_a_node_that_fails_before_its_first_line_is_named_where_warnings_are_errors(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "guide.serve(", "guide.serves(")
    result = lamps.runpytest_inprocess(SUITE, "-W", "error")
    result.stdout.fnmatch_lines(["E * module 'lamps.guide' has no attribute 'serves'*"])
    result.stdout.no_fnmatch_line("*No data was collected*")


@pytest.mark.slow
def test_a_waived_line_that_runs_fails_the_session_and_leaves_a_report(lamps: pytest.Pytester) -> None:
    guide = lamps.path / "lamps" / "guide.py"
    text = guide.read_text(encoding="utf-8").replace("return 10.0", "return 10.0  # unreachable: nobody dims")
    guide.write_text(text, encoding="utf-8")
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED lamps/guide.py:40: ran, though it is waived as unreachable (nobody dims)*"])
    written = report(lamps.path)
    assert written["reported"] == 4
    assert written["suites"][0]["code"] == {"statements": None, "branches": None}


def test_a_node_that_is_not_wrapped_is_not_measured_and_the_report_says_what_to_do(lamps: pytest.Pytester) -> None:
    change(
        lamps.path, "conftest.py", 'run.kernel.spawn("guide", run.measured(robot))', 'run.kernel.spawn("guide", robot)'
    )
    result = lamps.runpytest_inprocess("-v", "--hri-suite=by-hand", "-p", "no:xdist", "-p", "no:cacheprovider")
    why = "unmeasured: the testbench's run wraps no node with run.measured: spawn the node of the code"
    assert why in " ".join(result.stdout.str().split())
    found = report(lamps.path)
    assert found["suites"][0]["code"]["statements"] is None
    assert all("run.measured" in test["unmeasured"] for test in found["tests"])
