"""Whole campaigns on workers of this machine, as a user runs them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from tests import json_schema
from tests.extra.campaign.conftest import RUN, SUITE, Campaign, Finished, command, environment
from tests.plugin import project

RUNS = 20
FEW_RUNS, RUN_FEW = 8, ("run", *SUITE, "--concretizations=2", "--cluster=local:2", "--state=a.db")
ALL = ("--audit=100",)


def report(lamps: Path, folder: str = "hri-report") -> dict[str, Any]:
    """The report in a folder of the project."""
    loaded: dict[str, Any] = json.loads((lamps / folder / "report.json").read_text(encoding="utf-8"))
    return loaded


def timeless(value: Any) -> Any:
    """A report without times, and without names of files."""
    if isinstance(value, dict):
        return {name: timeless(each) for name, each in value.items() if name not in ("wall_s", "workers", "replay")}
    return [timeless(each) for each in value] if isinstance(value, list) else value


def crash_at(lamps: Path, what: str, where: str) -> None:
    """The code under test does something to the process when it switches a lamp off, in some of the runs."""
    project.change(
        lamps, "lamps/guide.py", "def switched_off():\n", f"def switched_off():\n    import os\n    {what}\n"
    )
    project.change(lamps, "lamps/guide.py", "if wish.level == 0.0:", f"if wish.level == 0.0 and {where}:")


@pytest.mark.slow
def test_its_runs_are_those_of_the_plugin_s_own_concretizations(
    finished: Finished,
) -> None:
    lamps, done = finished
    assert f"expected {RUNS}, stored {RUNS}: 0 failed, 0 lost" in done.stdout, done.stdout + done.stderr
    assert done.returncode == 0
    assert command(lamps, "report", "--state=a.db", "-o", "of-campaign").returncode == 0
    options = ["--hri-suite=bdi-random", "--hri-tests=4", "--hri-concretizations=5", "-p", "no:xdist"]
    subprocess.run([sys.executable, "-m", "pytest", *options, "-q"], cwd=lamps, env=environment(), check=True)
    made, plain = report(lamps, "of-campaign"), report(lamps)
    assert timeless(made["tests"]) == timeless(plain["tests"])
    for part in ("suites", "closure", "requirements", "code_under_test", "cross_products", "rerun_options"):
        without_time = [timeless({part: each[part]}) for each in (made, plain)]
        for each in without_time:
            if part == "suites":
                each[part][0]["generation"].pop("cached")
        assert without_time[0] == without_time[1], part
    json_schema.REPORT.validate(made)


def test_the_sums_are_those_of_all_runs(finished: Finished) -> None:
    lamps, _ = finished
    assert command(lamps, "report", "--state=a.db", "-o", "whole").returncode == 0
    whole = report(lamps, "whole")
    few = command(lamps, "report", "--state=a.db", "--most=5", "-o", "few")
    assert few.returncode == 0, few.stdout
    kept = report(lamps, "few")
    result = whole["campaign"]
    assert (result["expected"], result["stored"], result["is_listed"]) == (RUNS, RUNS, True)
    assert len(whole["tests"]) == RUNS > len(kept["tests"])
    assert {**kept["campaign"], "is_listed": True} == result
    for name in whole["requirements"]:
        verdicts = [test["requirements"][name]["verdict"] for test in whole["tests"]]
        sums = result["requirements"][name]
        assert [sums["passed"], sums["failed"], sums["nc"]] == [verdicts.count(v) for v in ("Passed", "Failed", "NC")]
    listed = {name for test in result["tests"] for name in test["keep"]}
    assert {test["id"] for test in kept["tests"]} == listed
    assert kept["code_under_test"]["files"] == whole["code_under_test"]["files"]
    assert [suite["cross"]["hit"] for suite in kept["suites"]] == [suite["cross"]["hit"] for suite in whole["suites"]]
    assert "only the runs worth keeping are listed as tests" in few.stdout
    assert "Campaign" in (lamps / "whole" / "index.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_another_code_is_refused_by_name(lamps: Path, campaign: Campaign) -> None:
    campaign("run", *SUITE, "--cluster=local:1", "--state=a.db")
    project.change(lamps, "lamps/guide.py", "GLARE = 80.0", "GLARE = 70.0")
    refused = campaign("run", *SUITE, "--cluster=local:1", "--state=a.db")
    assert refused.returncode == 2
    assert "its 4 runs are of another campaign: lamps/guide.py changed" in refused.stderr
    assert "give another --state" in refused.stderr
    other = campaign("run", *SUITE, "--seed=3", "--cluster=local:1", "--state=a.db")
    assert "--hri-seed=0" in other.stderr
    assert "--hri-seed=3" in other.stderr


@pytest.mark.slow
def test_a_run_that_kills_its_process_is_named_and_the_others_go_on(lamps: Path, campaign: Campaign) -> None:
    crash_at(lamps, "os.kill(os.getpid(), 9)", "True")
    done = campaign(*RUN_FEW)
    assert done.returncode == 1
    assert "its process: ended by SIGKILL, 3 times" in done.stdout
    campaign("report", "--state=a.db")
    result = report(lamps)["campaign"]
    assert result["stored"] == FEW_RUNS
    assert 0 < len(result["lost"]) == result["outcomes"]["lost"] < FEW_RUNS
    assert result["outcomes"]["passed"] + result["outcomes"]["lost"] == FEW_RUNS
    again = campaign(*RUN_FEW, "--retry-lost")
    assert f"{FEW_RUNS - len(result['lost'])} are done" in again.stdout


@pytest.mark.slow
def test_a_run_that_kills_its_worker_is_named_and_the_others_go_on(lamps: Path, campaign: Campaign) -> None:
    project.change(lamps, "lamps/guide.py", "GLARE = 80.0", "import os\nPARENT = os.getppid()\nGLARE = 80.0")
    crash_at(lamps, "os.kill(PARENT, 9)", "wish.cellar")
    done = campaign(*RUN_FEW, *ALL)
    assert done.returncode == 1, done.stdout
    assert "4 workers were lost with it, the last of them tls://127.0.0.1:" in done.stdout
    campaign("report", "--state=a.db")
    result = report(lamps)["campaign"]
    assert result["stored"] == FEW_RUNS
    assert 0 < len(result["lost"]) < FEW_RUNS


@pytest.mark.slow
def test_a_run_that_hangs_is_named(lamps: Path, campaign: Campaign) -> None:
    lock = "ctypes.CDLL(None).pthread_mutex_lock(mutex)"
    crash_at(lamps, f"import ctypes; mutex = ctypes.create_string_buffer(64); {lock}; {lock}", "wish.cellar")
    done = campaign("run", *SUITE, "--cluster=local:2", "--state=a.db", "--run-seconds=2")
    assert "its process: no sign of life for 2 s, 3 times" in done.stdout


@pytest.mark.slow
def test_a_run_that_differs_elsewhere_is_reported_with_the_event_at_which_it_parts(
    lamps: Path, campaign: Campaign
) -> None:
    project.change(
        lamps, "conftest.py", "    lamp.set(0.0)\n", "    import os\n    lamp.set(float(os.getpid() % 1000))\n"
    )
    done = campaign("run", *SUITE, "--cluster=local:2", "--state=a.db", *ALL)
    assert done.returncode == 1
    assert "repeated 4, on another worker if there is one; 4 differ" in done.stdout
    assert ": 0 s: lamp_level = " in done.stdout
    failed = campaign("report", "--state=a.db")
    assert "FAILED 4 of 4 repeated runs differ elsewhere" in failed.stdout
    status = campaign("status", "--state=a.db")
    assert status.stdout.count("differs: ") == 4
    assert status.stdout.count("worker tls://127.0.0.1:") == 2


@pytest.mark.slow
def test_a_row_a_run_as_parquet(finished: Finished) -> None:
    lamps, _ = finished
    exported = command(lamps, "export", "--parquet=runs.parquet", "--state=a.db")
    assert exported.stdout == "runs.parquet: 20 runs\n"
    rows = pyarrow.parquet.read_table(lamps / "runs.parquet").to_pylist()
    command(lamps, "report", "--state=a.db", "-o", "exported")
    tests = {test["id"]: test for test in report(lamps, "exported")["tests"]}
    assert {row["run"] for row in rows} == tests.keys()
    for row in rows:
        judged = tests[row["run"]]["requirements"]["R2"]
        assert (row["R2"], row["R2_triggers"], row["R2_margin"]) == (
            judged["verdict"],
            judged["triggers"],
            judged["margin"],
        )
        assert row["sha256"] == tests[row["run"]]["record_sha256"]


@pytest.mark.slow
def test_a_campaign_is_cancelled_from_elsewhere(lamps: Path, campaign: Campaign) -> None:
    campaign("run", *SUITE, "--cluster=local:1", "--state=a.db")
    arguments = [sys.executable, "-m", "pytest_hricdv.campaign", *RUN, "--concretizations=2000"]
    with subprocess.Popen(arguments, cwd=lamps, env=environment(), stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        said = [running.stdout.readline()]
        assert "8,000 runs" in said[0]
        assert "stops within seconds" in campaign("cancel", "--state=a.db").stdout
        said += running.stdout.readlines()
    assert running.returncode == 3
    assert "ended before all was done: cancelled\n" in said
    assert "the same command resumes it\n" in said


@pytest.mark.slow
def test_a_campaign_that_was_killed_gives_the_same_report(lamps: Path, campaign: Campaign) -> None:
    many = (*RUN[:2], "--tests=4", "--concretizations=40", "--cluster=local:2")
    campaign(*many, "--state=whole.db")
    for _ in range(2):
        arguments = [sys.executable, "-m", "pytest_hricdv.campaign", *many, "--state=killed.db"]
        with subprocess.Popen(arguments, cwd=lamps, env=environment(), stdout=subprocess.PIPE, text=True) as running:
            assert running.stdout is not None
            for line in running.stdout:
                if " of 160 runs" in line:
                    break
            os.kill(running.pid, signal.SIGKILL)
    last = campaign(*many, "--state=killed.db")
    assert "expected 160, stored 160" in last.stdout
    for name in ("whole", "killed"):
        campaign("report", f"--state={name}.db", "-o", name)
    assert timeless(report(lamps, "whole")) == timeless(report(lamps, "killed"))
