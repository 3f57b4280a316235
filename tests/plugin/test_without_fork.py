"""Systems that cannot fork, such as Windows: the same suites come of the same seeds, and what needs forks says so."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from tests.plugin import state
from tests.plugin.project import A_WORKER, report

RUN = ("--hri-suite=bdi-random", "--hri-tests=2", "-p", "no:cacheprovider")

LIKE_WINDOWS = '''
"""What Windows has not."""

import os
import signal
import sys

del os.fork, os.killpg, signal.SIGALRM, signal.SIGVTALRM, signal.setitimer, signal.getitimer
sys.modules["resource"] = sys.modules["fcntl"] = sys.modules["termios"] = None
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


def isolated(lamps: pytest.Pytester, *options: str) -> list[dict[str, Any]]:
    """The tests of the report of an isolated session, without how long they took."""
    lamps.runpytest_subprocess(*RUN, "--hri-isolate", *options)
    return [{**test, "wall_s": 0.0} for test in report(lamps.path)["tests"]]


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), pytest.param(A_WORKER)], ids=["plain", "on a worker"])
def test_a_process_for_each_test_is_started_where_there_are_no_forks(
    lamps: pytest.Pytester, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "0")
    state.leave(lamps, "list of a module")
    forked = isolated(lamps, *options)
    request.getfixturevalue("forkless")
    assert isolated(lamps, *options) == forked
    assert len({test["record_sha256"] for test in forked}) == len(forked) == 2
    together = lamps.runpytest_subprocess(*RUN, *options)
    assert [test["record_sha256"] for test in report(lamps.path)["tests"]] != [test["record_sha256"] for test in forked]
    assert together.ret == 0


@pytest.mark.slow
def test_what_a_started_process_ends_with_is_the_end_of_its_test(forkless: pytest.Pytester) -> None:
    test = (
        "import os, warnings\nimport pytest\n\n\n@pytest.fixture\ndef rig():\n    yield os.getpid()\n\n\n"
        "def test_lamps(hri_case, rig, record_property):\n    assert rig == os.getpid()\n    print('said it')\n"
        "    warnings.warn('mind the lamp')\n    record_property('light', 'dim')\n"
        "    hri_case.check(hri_case.run())\n    if 'curt' in hri_case.abstract.id:\n        os._exit(3)\n"
        "    assert False, 'so that it is shown'\n"
    )
    forkless.makepyfile(test_lamps=test)
    result = forkless.runpytest_subprocess(*RUN, "--hri-isolate", "--junitxml=junit.xml")
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines(["*- Captured stdout call -*", "said it", "*UserWarning: mind the lamp"])
    result.stdout.fnmatch_lines(["test_lamps.py::test_lamps*: its process gave no result: it ended with status 3"])
    junit = Path(forkless.path, "junit.xml").read_text(encoding="utf-8")
    assert junit.count('name="light"') == 1
    assert sorted(test["outcome"] for test in report(forkless.path)["tests"]) == ["error", "failed"]
