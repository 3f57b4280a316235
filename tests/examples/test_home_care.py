"""The project in examples/home_care: run from its folder with the installed plugin, as its reader would."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PROJECT = Path(__file__).parents[2] / "examples" / "home_care"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """One cache for all sessions: what one has learned, the others need not learn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME_CARE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def run(*options: str, faults: str = "", timeout_s: float = 900.0) -> subprocess.CompletedProcess[str]:
    """Run pytest in the project's folder; nothing is audited unless asked for."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "CAREBOT_"))}
    return subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-o",
            f"cache_dir={os.environ['HOME_CARE_CACHE']}",
            "--hri-audit=off",
            *options,
        ],
        cwd=PROJECT,
        env={**variables, "CAREBOT_FAULTS": faults},
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )


def report(folder: Path) -> dict[str, Any]:
    """What a session reported."""
    read: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return read


def test_it_imports_nothing_of_the_repository_around_it() -> None:
    for file in PROJECT.rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        for name in ("controller", "sim", "tests.hri"):
            assert f"from {name}" not in text, file
            assert f"import {name}" not in text, file


def test_its_own_tests_pass() -> None:
    done = run("-q", "-n", "2")
    assert done.returncode == 0, done.stdout


def test_one_command_learns_a_hundred_tests_which_run(tmp_path: Path) -> None:
    learned = run("--hri-suite=rl", "--collect-only", "-q")
    assert learned.stdout.count("test_home_care[rl-") >= 100
    done = run("--hri-suite=rl", "--hri-tests=4", "-n", "2", "--hri-audit=1", f"--hri-report={tmp_path}", "-q")
    assert done.returncode == 0, done.stdout[-4000:]
    assert len(report(tmp_path)["tests"]) == 4


def test_what_was_found_stays_mended(tmp_path: Path) -> None:
    done = run("--hri-suite=tests/regressions.txt", f"--hri-report={tmp_path}", "-q")
    assert done.returncode == 0, done.stdout[-4000:]
    written = (PROJECT / "tests" / "regressions.txt").read_text(encoding="utf-8").count("# name: ")
    outcomes = [test["outcome"] for test in report(tmp_path)["tests"]]
    assert len(outcomes) == written
    assert set(outcomes) <= {"passed", "known-violation"}


def test_workers_change_nothing(tmp_path: Path) -> None:
    hashes = []
    for workers in ("0", "2"):
        folder = tmp_path / workers
        done = run("--hri-suite=bdi-random", "--hri-tests=2", "-n", workers, f"--hri-report={folder}", "-q")
        assert done.returncode == 0, done.stdout[-4000:]
        hashes.append({test["id"]: test["record_sha256"] for test in report(folder)["tests"]})
    assert hashes[0] == hashes[1]
    assert len(hashes[0]) == 2


@pytest.mark.parametrize(
    ("fault", "requirements"),
    [
        ("stop-on-either", {"N6", "N8", "S6"}),
        ("lost-when-busy", {"N1"}),
        ("never-idle-first", {"N5"}),
        ("waits-for-ever", {"N4"}),
    ],
)
def test_each_published_fault_is_found(fault: str, requirements: set[str], tmp_path: Path) -> None:
    done = run(
        "--hri-suite=rl", "--hri-tests=40", "-x", "-q", "--hri-diagnose=0", f"--hri-report={tmp_path}", faults=fault
    )
    assert done.returncode == 1, done.stdout[-4000:]
    failed = {
        name
        for test in report(tmp_path)["tests"]
        for name, requirement in test["requirements"].items()
        if test["outcome"] == "failed" and requirement["verdict"] == "Failed"
    }
    assert failed & requirements


def test_a_gripper_that_nobody_looks_at_is_found_where_it_jams(tmp_path: Path) -> None:
    options = ("--hri-suite=tests/regressions.txt", "-k", "jams-before-it-closes", "--hri-diagnose=0", "-q")
    done = run(*options, f"--hri-report={tmp_path}", faults="trusts-gripper")
    assert done.returncode == 1, done.stdout[-4000:]
    (test,) = report(tmp_path)["tests"]
    assert test["requirements"]["N8"]["verdict"] == "Failed"
