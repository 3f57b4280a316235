"""Two people through the plugin: reports, shrinking, replay, several workers."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests import json_schema
from tests.plugin.project import report

pytestmark = pytest.mark.slow

CONFTEST = """
from tests.actors.corridor.bench import ward

def pytest_hricdv_testbench(config):
    return ward()
"""
SUITE = ("--hri-suite=pseudorandom,rl", "--hri-tests=12")


@pytest.fixture
def project(project: pytest.Pytester) -> pytest.Pytester:
    """A project with the corridor."""
    project.makeconftest(CONFTEST)
    return project


def failures_of(written: dict[str, Any], requirement: str) -> list[dict[str, Any]]:
    return [test for test in written["tests"] if test["requirements"][requirement]["verdict"] == "Failed"]


def test_a_fault_of_two_people_is_found_shrunk_explained_and_replayed(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("-vv", *SUITE, "--hri-shrink")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "*what nurse and child did around then*",
            "*s  child: step_in",
            "*--> R1 is violated*",
            "*shrunk from * actions to 2*",
            "*needs * and *: without the actions of any one of them, it does not fail this way",
            "*s child: step_in*; * s R1 is violated",
        ]
    )
    written = report(project.path)
    json_schema.REPORT.validate(written)
    failed = failures_of(written, "R1")
    assert failed
    for test in failed:
        assert sorted(test["action_indices"]) == sorted(set(test["action_indices"]))
        assert len(test["action_indices"]) == len(test["action_times_s"])
    ((shrunk,),) = [[test["shrunk"]["R1"]] for test in failed if test.get("shrunk")]
    assert sorted(shrunk["abstract"]) == ["child: step_in", "nurse: send_on"]
    assert sorted(line.partition(" s ")[2] for line in shrunk["course"]) == [
        "R1 is violated",
        "child: step_in",
        "nurse: send_on",
    ]
    again = project.runpytest_inprocess("-vv", f"--hri-replay={shrunk['replay']}")
    again.stdout.fnmatch_lines(["*the same run, bit for bit*"])


def test_any_number_of_workers_gives_the_same(project: pytest.Pytester) -> None:
    hashes, shrunk = {}, {}
    for workers in ("0", "2"):
        project.runpytest_inprocess(*SUITE, "--hri-shrink", f"-n{workers}", f"--hri-report=r{workers}")
        written = json.loads((project.path / f"r{workers}" / "report.json").read_text(encoding="utf-8"))
        hashes[workers] = [(test["id"], test["action_indices"], test["record_sha256"]) for test in written["tests"]]
        shrunk[workers] = [
            (name, made["concrete"], made["course"], (project.path / made["replay"]).read_bytes())
            for test in written["tests"]
            for name, made in test.get("shrunk", {}).items()
        ]
    assert len(hashes["0"]) == 24
    assert hashes["0"] == hashes["2"]
    assert len(shrunk["0"]) > 0
    assert shrunk["0"] == shrunk["2"]
    exported = project.runpytest_inprocess(*SUITE, "--hri-export=texts", "--collect-only", "-q")
    read = project.runpytest_inprocess("--hri-suite=texts/rl.txt", "--hri-report=read")
    written = json.loads((project.path / "read" / "report.json").read_text(encoding="utf-8"))
    assert {(test["id"], test["record_sha256"]) for test in written["tests"]} <= {
        (name, sha256) for name, _, sha256 in hashes["0"]
    }
    assert exported.ret == 0
    assert read.ret in (0, 1)
