"""What follows the tests of a killed session: the session that goes on with it does it, or its report lacks it."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests import json_schema
from tests.extra.audit.test_sessions import audited, marks, problems
from tests.plugin import project, state

__all__ = ["audited"]

RUN = ("--hri-suite=bdi-random", "--hri-tests=3", "-p", "no:cacheprovider")
KILLED = """

_ended = []

def pytest_runtest_logreport(report):
    if report.when == "teardown":
        _ended.append(report.nodeid)

def pytest_runtest_logfinish(nodeid):
    if len(_ended) == 3 and "PYTEST_XDIST_WORKER" not in os.environ and os.path.exists("armed"):
        os.unlink("armed")
        os.kill(os.getpid(), 9)
"""


def kill_after_the_last_test(audited: pytest.Pytester) -> None:
    """Let the next session be killed once its last test has ended."""
    project.change(audited.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n\nimport os{KILLED}")
    (audited.path / "armed").touch()


@pytest.mark.slow
@project.plain_and_slowly_on_a_worker
def test_a_resumed_session_audits_the_tests_of_the_killed_one(audited: pytest.Pytester, options: Sequence[str]) -> None:
    state.leave(audited, "list of a module")
    kill_after_the_last_test(audited)
    assert audited.runpytest_subprocess(*RUN, *options).ret == -9
    result = audited.runpytest_subprocess(*RUN, *options, "--hri-resume")
    assert result.ret == 1
    assert len(problems(result)) == len(marks(audited)) > 0
    assert len(project.report(audited.path)["audit"]["tests"]) == 3
    assert project.command("gate", str(audited.path / "hri-report")).returncode == 1
    again = audited.runpytest_subprocess(*RUN, *options, "--hri-resume")  # of a session that has ended
    assert again.ret == 1
    assert len(problems(again)) == len(marks(audited)) > 0


@pytest.mark.slow
def test_code_that_repeats_passes_when_it_is_resumed(audited: pytest.Pytester) -> None:
    kill_after_the_last_test(audited)
    assert audited.runpytest_subprocess(*RUN).ret == -9
    folder = audited.path / "hri-report"
    said = project.command("rebuild", str(folder))
    assert said.returncode == 1
    rebuilt = project.report(audited.path)
    json_schema.REPORT.validate(rebuilt)
    (problem,) = rebuilt["problems"]
    assert "its report lacks: the audit" in problem
    assert problem in said.stdout
    assert project.command("gate", str(folder)).returncode == 1
    assert audited.runpytest_subprocess(*RUN, "--hri-resume").ret == 0
    written = project.report(audited.path)
    assert (len(written["audit"]["tests"]), written.get("problems", [])) == (3, [])
    assert project.command("gate", str(folder)).returncode == 0


@pytest.mark.slow
def test_a_rebuilt_report_names_all_that_it_lacks(audited: pytest.Pytester) -> None:
    kill_after_the_last_test(audited)
    asked = ("--hri-mutate", "--hri-mutate-faults=1", "--hri-search=1", "--hri-shrink")
    assert audited.runpytest_subprocess(*RUN, *asked).ret == -9
    project.command("rebuild", str(audited.path / "hri-report"))
    (problem,) = project.report(audited.path)["problems"]
    for option in ("--hri-mutate", "--hri-search", "--hri-shrink", "the audit"):
        assert option in problem
    audited.runpytest_subprocess(*RUN, *asked, "--hri-resume")
    written = project.report(audited.path)
    assert written["mutation"]["mutants"]
    assert len(written["audit"]["tests"]) == 3


@pytest.mark.slow
@pytest.mark.parametrize(
    "asked",
    [
        ("--hri-isolate",),
        (
            "--hri-mcap-all",
            "--hri-shard=1/1",
            "--hri-export=exported",
            "--hri-no-cov",
            "--hri-strict",
            "--hri-fail-on-nc",
        ),
        (
            *("--hri-mutate", "--hri-mutate-faults=1", "--hri-fail-under=mutants=1", "--hri-search=1", "--hri-shrink"),
            *("--hri-suggest", "--hri-suggest-faults=0", "--hri-suggest-further=0"),
            *("--hri-baseline=baseline.json", "--hri-update-baseline"),
        ),
    ],
    ids=["isolated", "other files", "further runs"],
)
def test_no_option_disables_the_audit(audited: pytest.Pytester, asked: Sequence[str]) -> None:
    state.leave(audited, "list of a module")
    result = audited.runpytest_subprocess(*RUN, "--hri-audit=1", *asked)
    audit = project.report(audited.path)["audit"]
    assert audit.get("problem", "") == ""
    leaves_something = "--hri-isolate" not in asked
    assert result.ret == int(leaves_something)
    assert bool(audit.get("differing")) == bool(problems(result)) == leaves_something
