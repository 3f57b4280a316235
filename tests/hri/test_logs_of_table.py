"""A trace of the table, checked as a log, has the verdicts and margins of its run, for the tests of a suite."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OPTIONS = (
    "--hri-tests=8",
    "--hri-fidelity=kinematic",
    "--hri-mcap-all",
    "--hri-audit=off",
    "--hri-diagnose=0",
    "--hri-no-cov",
    "-p",
    "no:cacheprovider",
    "-n",
    "2",
)


@pytest.mark.slow
def test_all_traces_of_a_suite_are_judged_as_their_runs_were(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "--hri-suite=rl", f"--hri-report={tmp_path / 'report'}", *OPTIONS]
    subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    report = json.loads((tmp_path / "report" / "report.json").read_text(encoding="utf-8"))
    checking = [sys.executable, "-m", "pytest_hricdv", "check", str(tmp_path / "report" / "traces"), "--json"]
    done = subprocess.run(checking, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    judged = {log["log"]: log["requirements"] for log in map(json.loads, done.stdout.splitlines())}
    assert len(judged) == len(report["tests"]) == 8
    for test in report["tests"]:
        log = judged[test["trace"]["file"]]
        expected = {
            name: (made["verdict"], made["margin"]) for name, made in test["requirements"].items() if name in log
        }
        assert {name: (made["verdict"], made["margin"]) for name, made in log.items()} == expected
        assert test["requirements"].keys() - log.keys() <= {"MODEL"}  # an agent of the model, and no formula
