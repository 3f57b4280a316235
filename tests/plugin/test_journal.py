"""However a session ends, no finished result is lost: the journal has it, and a report can be made."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import json_schema
from tests.plugin.killed_session import SUITE, dimmed, run
from tests.plugin.project import (
    change,
    command,
    in_each_mode,
    report,
)

ORDERLY = {
    "SIGTERM": '__import__("interrupting").begin(15, times=1)',
    "SIGINT": '__import__("os").kill(__import__("os").getpid(), 2)',
    "many SIGINT": '__import__("interrupting").begin(2, times=100)',
}


INTERRUPTING = """
import os, threading, time

def begin(number, times):
    threading.Thread(target=interrupt, args=(number, times), daemon=True).start()
    while True:  # it does not come to its end: this is what is interrupted
        pass

def interrupt(number, times):
    for _ in range(times):
        os.kill(os.getpid(), number)
        time.sleep(0.002)  # one signal in each step of what ends the session, and not all in the first
"""


@pytest.fixture(autouse=True)
def _interruptible() -> Iterator[None]:
    """What a shell starts in the background ignores Ctrl-C, and so would the sessions that tests start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def journal(lamps: pytest.Pytester) -> Path:
    return lamps.path / "hri-report" / "journal.jsonl"


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("-p", "no:xdist")], ids=["plain", "without xdist"])
def test_a_killed_session_leaves_its_journal_of_which_a_report_is_rebuilt(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    dimmed(lamps, '__import__("os").kill(__import__("os").getpid(), 9)')
    assert run(lamps, *options).ret == -9
    refused = command("gate", "hri-report")
    assert refused.returncode == 2
    assert "its process died" in refused.stderr
    rebuilt = command("rebuild", "hri-report")
    assert rebuilt.returncode == 1
    written = report(lamps.path)
    json_schema.REPORT.validate(written)
    assert written["selected"] == 4
    assert written["reported"] >= 1
    assert written["reported"] + written["not_run"] == 4
    assert f"{written['reported']} of 4 tests that have a result" in rebuilt.stdout
    for tally in written["suites"][0]["requirements"].values():
        assert tally["passed"] + tally["failed"] + tally["nc"] == written["reported"]
    assert command("gate", "hri-report").returncode == 1  # tests are missing


@pytest.mark.slow
@pytest.mark.parametrize("end", ORDERLY)
def test_a_session_that_is_ended_leaves_its_report_and_does_not_exit_with_0(lamps: pytest.Pytester, end: str) -> None:
    dimmed(lamps, ORDERLY[end])
    (lamps.path / "interrupting.py").write_text(INTERRUPTING, encoding="utf-8")
    result = run(lamps)
    assert result.ret not in (0, -15)
    written = report(lamps.path)
    assert written["selected"] == 4
    assert 1 <= written["reported"] < 4
    assert command("gate", "hri-report").returncode == 1


@pytest.mark.slow
@in_each_mode
def test_the_journal_has_all_of_the_report(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    lamps.runpytest_inprocess(SUITE, *options)
    written = report(lamps.path)
    (lamps.path / "hri-report" / "report.json").unlink()
    rebuilt = command("rebuild", "hri-report")
    assert rebuilt.returncode == 0
    for timed in (written, again := report(lamps.path)):
        del timed["wall_s"]
    del written["gates"]  # they need all of the session
    assert again == written


@pytest.mark.slow
def test_the_next_session_says_that_the_one_before_died_and_keeps_its_journal(lamps: pytest.Pytester) -> None:
    killed = '__import__("os").kill(__import__("os").getpid(), 9)'
    dimmed(lamps, killed)
    assert run(lamps).ret == -signal.SIGKILL  # nothing in the process can tell; the journal does
    assert command("gate", "hri-report").returncode == 2
    change(lamps.path, "lamps/guide.py", killed, "return 10.0")
    result = run(lamps, "-q")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["hricdv: the session that began at * did not come to its end: * --hri-resume *"])
    assert command("rebuild", "hri-report/earlier").returncode == 1
    assert command("gate", "hri-report").returncode == 0


@pytest.mark.slow
def test_two_sessions_do_not_write_into_one_folder(lamps: pytest.Pytester) -> None:
    second = '__import__("subprocess").run(["{}", "-m", "pytest", "{}", "-q"], stderr=2).returncode'
    begins = "def test_lamps(hri_case):\n"
    once = f"    if 'set_lamp level = 10' in hri_case.abstract.lines:\n        {second.format(sys.executable, SUITE)}\n"
    change(lamps.path, "test_lamps.py", begins, begins + once)
    result = run(lamps, "-s")
    assert result.ret == 0
    result.stderr.fnmatch_lines(["ERROR: --hri-report=*: another session writes its report there (process *): *"])
    assert report(lamps.path)["reported"] == 4


@pytest.mark.slow
def test_on_a_full_disk_nothing_is_lost_that_it_could_hold(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(SUITE)  # whatever else a session writes is there
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({0}, resource.RLIM_INFINITY))"
    began, declared, first, second, *_ = journal(lamps).read_bytes().splitlines(keepends=True)
    room = len(began + declared + first + second) + len(second) // 2
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n{full.format(room)}\n")
    result = run(lamps, "-p", "no:cacheprovider")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        ["results are missing in the journal: *journal.jsonl: *", "FAILED cannot write the rep*"]
    )
    assert command("gate", "hri-report").returncode == 2
    assert command("rebuild", "hri-report").returncode == 1
    assert report(lamps.path)["reported"] == 2


@pytest.mark.slow
def test_a_session_that_died_before_its_first_result_leaves_the_earlier_report_in_its_place(
    lamps: pytest.Pytester,
) -> None:
    lamps.runpytest_inprocess(SUITE)
    kill = "if __import__('os').path.exists('armed'):\n        __import__('os')._exit(9)"
    hook = f"\n\ndef pytest_collection_finish():\n    {kill}\n"
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n{hook}")
    (lamps.path / "armed").touch()
    assert run(lamps).ret == run(lamps).ret == 9
    assert not (lamps.path / "hri-report" / "report.json").exists()
    assert command("gate", "hri-report/earlier").returncode == 0
    (lamps.path / "armed").unlink()
    result = lamps.runpytest_inprocess(SUITE)
    result.stdout.fnmatch_lines(["hricdv: the session that began at * did not come to its end, and had no result"])
