"""Replay: a failing test leaves a file that gives the very same run again, or says what keeps it from doing so."""

from __future__ import annotations

import json
import shlex
from typing import Any

import pytest

from tests import json_schema
from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change, outcomes, plain_and_slowly_on_a_worker, report

BRIGHT = "rl-hall-polite-6c5fa14f"
FILE = f"hri-report/failures/{BRIGHT}.json"
REPLAY = f"--hri-replay={FILE}"


def left(lamps: pytest.Pytester) -> list[str]:
    """The files that failing tests left."""
    return sorted(path.name for path in (lamps.path / "hri-report" / "failures").iterdir())


def edit(lamps: pytest.Pytester, **changed: Any) -> None:
    """Change top-level entries of the replay file."""
    path = lamps.path / FILE
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | changed), encoding="utf-8")


@pytest.fixture
def failed(lamps: pytest.Pytester, after: SessionRunner) -> pytest.Pytester:
    """The project, after a run in which one test has failed."""
    after("--hri-suite=rl", "--hri-strict", "--hri-diagnose=0", "-k", BRIGHT)
    return lamps


@pytest.mark.slow
@plain_and_slowly_on_a_worker
def test_every_failing_test_leaves_a_file_and_is_the_same_run_again(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    usual = "--hri-suite=rl", "--hri-strict", "--hri-diagnose=0", "--tb=short"
    result = lamps.runpytest_inprocess("-vv", *usual, *options)
    bad = [name for name, outcome in outcomes(lamps.path).items() if outcome == "failed"]
    assert BRIGHT in bad
    assert left(lamps) == sorted(f"{name}.json" for name in bad)
    (before,) = [test for test in report(lamps.path)["tests"] if test["id"] == BRIGHT]
    assert before["replay"] == FILE
    command = f"pytest {REPLAY} --hri-strict"
    result.stdout.fnmatch_lines(["or the very same run, from its file:", f"  {command}"])
    again = lamps.runpytest_inprocess("-vv", *shlex.split(command)[1:], "--tb=short", *options)
    assert again.ret == 1
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines(
        ["hri: lamps, replay of 1 test", "run it again:", f"  {command}", f"replay of {BRIGHT}: the same run, bit *"]
    )
    again.stdout.no_fnmatch_line("*--hri-suite=*")
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    (after,) = written["tests"]
    for key in ("nodeid", "id", "suite", "beliefs", "abstract", "concrete", "seed", "plans", "record_sha256", "code"):
        assert after[key] == before[key], key
    assert after["requirements"] == before["requirements"]
    assert after["replayed"]["same"] is True


def test_the_file_keeps_its_contract_and_says_what_ran(failed: pytest.Pytester) -> None:
    data = json.loads((failed.path / FILE).read_text(encoding="utf-8"))
    json_schema.REPLAY.validate(data)
    assert data["requirements"]["R2"]["verdict"] == "Failed"
    assert data["nodeid"] == f"test_lamps.py::test_lamps[{BRIGHT}]"
    assert set(data["code"]) == {"lamps/__init__.py", "lamps/guide.py", "lamps/messages.py"}
    assert str(failed.path) not in json.dumps(data)


@pytest.mark.slow
def test_a_crash_leaves_a_file_that_crashes_again(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "    return wish.level\n", "    raise OSError('no lamp')\n")
    lamps.runpytest_inprocess("--hri-suite=rl", "-k", BRIGHT).stdout.fnmatch_lines([f"*  pytest {REPLAY}"])
    again = lamps.runpytest_inprocess(REPLAY)
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines(["*OSError: no lamp", "*run it again:", f"*  pytest {REPLAY}"])
    assert report(lamps.path)["tests"][0]["outcome"] == "failed"
    assert report(lamps.path)["tests"][0]["replayed"]["same"]


@pytest.mark.slow
@plain_and_slowly_on_a_worker
def test_code_that_has_changed_is_told_and_run_when_asked_to(failed: pytest.Pytester, options: tuple[str, ...]) -> None:
    change(failed.path, "lamps/guide.py", "    return wish.level\n", "    return min(wish.level, GLARE)\n")
    told = refused(failed, REPLAY, "--hri-strict", *options)
    assert f"{FILE}: lamps/guide.py changed: its run need not be the same again" in told
    assert "add --hri-replay-force to run it anyway" in told
    again = failed.runpytest_inprocess("-vv", REPLAY, "--hri-strict", "--hri-replay-force", *options)
    assert again.ret == 0
    again.assert_outcomes(passed=1)
    again.stdout.fnmatch_lines(
        [
            f"{FILE}: lamps/guide.py changed: its run need not be the same again",
            f"replay of {BRIGHT}: differs from the recording: lamps/guide.py changed",
        ]
    )
    assert report(failed.path)["tests"][0]["replayed"]["changed"] == ["lamps/guide.py changed"]
    assert left(failed) == [f"{BRIGHT}.json"], "the file is evidence and stays"


@pytest.mark.slow
def test_another_run_without_a_reason_fails(failed: pytest.Pytester) -> None:
    change(failed.path, "conftest.py", "lamp.set(0.0)", "lamp.set(1.0)")
    again = failed.runpytest_inprocess("-vv", REPLAY)
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines(
        [
            f"this run differs from the one in {FILE}: *",
            f"replay of {BRIGHT}: differs from the recording; cause unknown: --hri-audit looks for it",
        ]
    )


@pytest.mark.slow
def test_files_and_folders_are_replayed_together_whatever_the_ini_says(lamps: pytest.Pytester) -> None:
    change(
        lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_suite = by-hand\nhri_fail_under = plans=100"
    )
    lamps.runpytest_inprocess("--hri-suite=rl,by-hand", "--hri-concretizations=2", "--hri-report=kept")
    bad = [path.stem for path in (lamps.path / "kept" / "failures").iterdir()]
    assert len(bad) > 2
    again = lamps.runpytest_inprocess("--hri-replay=kept/failures")
    assert again.ret == 0
    again.assert_outcomes(xfailed=len(bad))
    assert sorted(outcomes(lamps.path)) == sorted(bad)
    assert all(test["replayed"]["same"] for test in report(lamps.path)["tests"])
    one, other, *_ = sorted(bad)
    again = lamps.runpytest_inprocess(f"--hri-replay=kept/failures/{one}.json,kept/failures/{other}.json")
    assert sorted(outcomes(lamps.path)) == [one, other]


@plain_and_slowly_on_a_worker
@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"schema": "hricdv-replay/9"}, "expected schema 'hricdv-replay/2', found 'hricdv-replay/9'"),
        ({"test": 3}, "Expected `object`, got `int` - at `$.test`; expected a replay file"),
        ({"concrete": {"actions": [], "run": {"patience_s": 6.0}}}, "have different actions; was it edited?"),
        (
            {"concrete": {"actions": [{"command": "greet"}], "run": {}}},
            "missing required field `parameters` - at `$.concrete.actions[0]`",
        ),
    ],
)
def test_what_is_no_replay_file_is_refused(
    failed: pytest.Pytester, options: tuple[str, ...], changed: dict[str, Any], told: str
) -> None:
    edit(failed, **changed)
    assert told in refused(failed, REPLAY, *options)


def refused(lamps: pytest.Pytester, *options: str) -> str:
    """The message with which a run is refused."""
    result = lamps.runpytest_inprocess(*options)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    message = result.stderr.str().strip()
    assert message.count("ERROR") == 1
    assert "Traceback" not in message + result.stdout.str()
    return message
