"""Sessions of code that does not repeat: what the audit says of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from tests import json_schema
from tests.plugin import project, state

pytestmark = pytest.mark.slow  # each test is a session or several

RUN = ("--hri-suite=bdi-random", "--hri-tests=3", "-p", "no:cacheprovider", "--hri-no-cov")
ONE = (*RUN, "--hri-audit=1")
"""Finding the cause of one test takes a second or two."""

NUMBER_FILE = (
    "from pathlib import Path\nCOUNT = Path(__file__).with_name('count.txt')\ndef count():\n"
    "    number = int(COUNT.read_text()) if COUNT.exists() else 0\n    COUNT.write_text(str(number + 1))\n"
    "    return number\n"
)
SET = "''.join({'1', '2', '3', '4', '5', '6', '7', '8'})"
FILE_TIME = "import os\nMARK = __file__ + '.mark'\ndef touched():\n    open(MARK, 'w').close()\n"

CAUSES = {
    "a set of strings": (SET, "", "hash order", "PYTHONHASHSEED"),
    "a file": ("count()", NUMBER_FILE, "file left behind: count.txt", "count.txt"),
    "the time of a file": (
        "(touched(), os.stat(MARK).st_mtime_ns % 1e9)[1]",
        FILE_TIME,
        "times of files",
        "guide.py.mark at lamps/guide.py",
    ),
    "bytes of the system": (
        "open('/dev/urandom', 'rb').read(1)[0]",
        "",
        "files",
        "open of /dev/urandom at lamps/guide.py",
    ),
}
"""What the guide says -> the cause that is found, and a part of the detail."""


@pytest.fixture
def audited(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps, whose sessions are audited."""
    project.change(lamps.path, "pytest.ini", "hri_audit = off\n", "")
    return lamps


def marks(audited: pytest.Pytester) -> list[dict[str, Any]]:
    """What the report says of tests that came otherwise."""
    written = project.report(audited.path)
    json_schema.REPORT.validate(written)
    return [test["unrepeatable"] for test in written["tests"] if "unrepeatable" in test]


def problems(result: pytest.RunResult) -> list[str]:
    """What the terminal says of them."""
    return [line for line in result.outlines if line.startswith("FAILED ") and "is not repeatable" in line]


@project.in_each_mode
def test_code_that_repeats_gets_no_word(audited: pytest.Pytester, options: Sequence[str]) -> None:
    result = audited.runpytest_subprocess(*RUN, *options)
    assert result.ret == 0
    said = [line for line in result.outlines if not line.startswith("hricdv: rerunning ")]  # on a slow machine
    assert "repeatable" not in "\n".join(said)
    audit = project.report(audited.path)["audit"]
    assert (len(audit["tests"]), audit.get("differing", [])) == (3, [])
    assert audit["hash_seed"] != audit["session_hash_seed"]


@pytest.mark.parametrize(
    "way", [pytest.param(way, marks=() if way == "list of a module" else pytest.mark.slow) for way in state.WAYS]
)
def test_state_is_traced_to_the_test_that_left_it(audited: pytest.Pytester, way: str) -> None:
    state.leave(audited, way)
    result = audited.runpytest_subprocess(*ONE)
    assert result.ret == 1
    for mark in marks(audited):
        assert mark["cause"] == f"state that {mark['left_by']} leaves"
        assert mark["in_session"].startswith("0 s: guide switched")
        assert mark["alone"].startswith("0 s: guide switched")
    assert len(problems(result)) == len(marks(audited)) > 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", CAUSES)
def test_other_causes_have_their_names(audited: pytest.Pytester, kind: str) -> None:
    said, module, cause, detail = CAUSES[kind]
    state.say(audited, said, module=module)
    assert audited.runpytest_subprocess(*ONE).ret == 1
    assert marks(audited)
    for mark in marks(audited):
        assert mark["cause"] == cause
        assert detail in mark["detail"]


@pytest.mark.slow
def test_the_clock_on_the_wall_is_told_apart(audited: pytest.Pytester) -> None:
    project.change(audited.path, "conftest.py", "    lamp.set(0.0)\n", "    lamp.set(time.time() % 1.0)\n")
    path = audited.path / "conftest.py"
    path.write_text(f"import time\n{path.read_text(encoding='utf-8')}", encoding="utf-8")
    assert audited.runpytest_subprocess(*ONE).ret == 1
    for mark in marks(audited):
        assert mark["cause"] == "wall clock"
        assert "time.time at conftest.py" in mark["detail"]


def test_a_failure_that_is_none_alone_is_no_violation(audited: pytest.Pytester) -> None:
    state.say(audited, "0", module="SERVED = []\n", function="    SERVED.append(1)\n")
    project.change(audited.path, "lamps/guide.py", "clock.sleep(SWITCHING_S)", "clock.sleep(len(SERVED) - 0.5)")
    result = audited.runpytest_subprocess(*RUN)
    assert result.ret == 1
    written = project.report(audited.path)
    assert "failed" not in project.outcomes(audited.path).values()
    assert written["suites"][0]["requirements"]["R1"]["failed"] == 0
    assert all(mark["is_violation_unconfirmed"] for mark in marks(audited))
    result.stdout.fnmatch_lines(["FAILED * is not repeatable: passes alone; cause: state that * leaves*"])


def test_a_test_that_kills_its_process_alone_is_named(audited: pytest.Pytester) -> None:
    state.say(
        audited, "0 if os.environ.get('PYTHONHASHSEED') != '1' else os.kill(os.getpid(), 9)", module="import os\n"
    )
    result = audited.runpytest_subprocess(*ONE)
    assert result.ret == 1
    (mark,) = marks(audited)
    assert mark["outcome_alone"] == "none"
    assert "ended by SIGKILL" in mark["alone"]


def test_it_can_be_switched_off_and_bounded(audited: pytest.Pytester) -> None:
    state.leave(audited, "list of a module")
    assert audited.runpytest_subprocess(*RUN, "--hri-audit=off").ret == 0
    assert "audit" not in project.report(audited.path)
    audited.runpytest_subprocess(*ONE)
    assert len(project.report(audited.path)["audit"]["tests"]) == 1
    result = audited.runpytest_subprocess(*RUN, "--hri-audit=some")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-audit=some: expected a whole number, or off"])


def test_a_fresh_process_that_does_not_start_is_said_and_fails_nothing(audited: pytest.Pytester) -> None:
    conftest = "import os, sys\nif 'audit.process' in ' '.join(sys.orig_argv):\n    raise RuntimeError('no licence')\n"
    path = audited.path / "conftest.py"
    path.write_text(conftest + path.read_text(encoding="utf-8"), encoding="utf-8")
    result = audited.runpytest_subprocess(*RUN)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["the audit could not run tests again in a fresh process: *"])
