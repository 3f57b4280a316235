"""Systems that cannot fork, such as Windows: the same suites come of the same seeds, and what needs forks says so."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.plugin.project import report

LIKE_WINDOWS = '''
"""What Windows has not."""

import os
import signal
import sys

del os.fork, os.killpg, signal.SIGALRM, signal.SIGVTALRM, signal.setitimer, signal.getitimer
sys.modules["resource"] = sys.modules["fcntl"] = None
'''


@pytest.fixture
def forkless(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """The lamps, on a system that is like Windows as soon as `like_windows` is called."""
    folder = lamps.path / "like-windows"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(LIKE_WINDOWS, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]))
    return lamps


def exported(lamps: pytest.Pytester, name: str) -> str:
    """The suite closure, as a file."""
    options = ("--hri-suite=closure", "--hri-close-runs=24", "-p", "no:cacheprovider", f"--hri-export={name}")
    result = lamps.runpytest_subprocess(*options)
    assert result.ret == 0
    return Path(lamps.path, name, "closure.txt").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_closing_loop_without_forks_leads_to_the_same_suite(
    lamps: pytest.Pytester, request: pytest.FixtureRequest
) -> None:
    forked = exported(lamps, "forked")
    request.getfixturevalue("forkless")
    assert exported(lamps, "not-forked") == forked
    assert forked.count("# id: closure-") > 4


@pytest.mark.slow
def test_a_suite_runs_without_forks(forkless: pytest.Pytester) -> None:
    assert forkless.runpytest_subprocess("--hri-suite=rl", "--hri-shrink").ret == 0
    assert report(forkless.path)["reported"] == 34


def test_tests_cannot_be_isolated_without_forks(forkless: pytest.Pytester) -> None:
    result = forkless.runpytest_subprocess("--hri-suite=rl", "--hri-isolate")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-isolate: this system cannot fork processes; use Linux or macOS"])


def test_faults_cannot_be_tried_without_forks(forkless: pytest.Pytester) -> None:
    result = forkless.runpytest_subprocess("--hri-suite=rl", "--hri-mutate")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-mutate: this system cannot fork processes; use Linux or macOS"])
