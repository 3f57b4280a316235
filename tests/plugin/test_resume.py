"""`--hri-resume`: what had not ended runs, and the report is that of a session that nobody killed."""

from __future__ import annotations

import msgspec
import pytest

from pytest_hricdv.results import journal as journals
from tests.plugin.killed_session import KILLING, SUITE, dimmed, run
from tests.plugin.project import change, plain_and_slowly_on_a_worker, report


def resumed_report(lamps: pytest.Pytester) -> dict[str, object]:
    """The report, but for times, and for the command, of which a resumed session has its own."""
    written = report(lamps.path)
    assert written.pop("origin")["began"]
    for timed in (written, *written["tests"], *(suite["generation"] for suite in written["suites"])):
        del timed["wall_s"]
        timed.pop("cached", None)
    return written


@pytest.mark.slow
@plain_and_slowly_on_a_worker
def test_a_resumed_session_runs_the_rest_and_reports_what_an_unkilled_one_does(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    ran = "\n\ndef pytest_runtest_setup(item):\n    open('ran.txt', 'a').write(item.name + '\\n')\n"
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n{ran}")
    me = "ppid" if "-n" in options else "pid"
    (lamps.path / "killing.py").write_text(KILLING.format(me), encoding="utf-8")
    dimmed(lamps, 'return (__import__("sys").modules.pop("killing", 0), __import__("killing"), 10.0)[2]')
    run(lamps, "--hri-strict", *options)
    unkilled, ran_before = resumed_report(lamps), (lamps.path / "ran.txt").read_text().splitlines()
    (lamps.path / "ran.txt").unlink()
    (lamps.path / "armed").touch()
    assert run(lamps, "--hri-strict", *options).ret == -9
    ran_first = (lamps.path / "ran.txt").read_text().splitlines()
    (lamps.path / "ran.txt").unlink()
    result = run(lamps, "--hri-strict", "--hri-resume", "-v", *options)
    assert result.ret == 1  # a requirement was violated before the kill
    ran_now = (lamps.path / "ran.txt").read_text().splitlines()
    cut_off = 2 if options == ("-n", "2") else 1
    assert len(ran_first) + len(ran_now) <= len(ran_before) + cut_off  # only what had not ended ran twice
    assert resumed_report(lamps) == unkilled
    result.stdout.fnmatch_lines(["hricdv: resuming the session that began at *", "*(done before)*", "resumed: *"])


STOPPING = """

_ended = set()

def pytest_runtest_logreport(report):
    _ended.update([report.nodeid] if report.when == "teardown" else [])
    if len(_ended) == 4 and os.path.exists("armed"):
        raise KeyboardInterrupt
"""


@pytest.mark.slow
@plain_and_slowly_on_a_worker
def test_a_session_that_is_stopped_after_its_last_result_judges_no_gates_and_a_resumed_one_does(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", f"LIMIT_S = 60.0\n\nimport os{STOPPING}")
    (lamps.path / "armed").touch()
    assert run(lamps, *options).ret == pytest.ExitCode.INTERRUPTED
    stopped = report(lamps.path)
    assert (stopped["reported"], stopped["not_run"]) == (4, 0)
    assert "gates" not in stopped
    (lamps.path / "armed").unlink()
    assert run(lamps, "--hri-resume", *options).ret == 0
    assert report(lamps.path)["gates"] == {"failed": [], "improved": []}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (("lamps/guide.py", "GLARE = 80.0", "GLARE = 90.0"), "lamps/guide.py changed"),
        (("conftest.py", "LIMIT_S = 60.0", "LIMIT_S = 61.0"), "conftest.py changed"),
        (("requirements.toml", "0:1", "0:2"), "requirements.toml changed"),
    ],
    ids=["code", "testbench", "requirements"],
)
def test_only_the_same_code_and_testbench_are_resumed(
    lamps: pytest.Pytester, changed: tuple[str, str, str], told: str
) -> None:
    lamps.runpytest_inprocess(SUITE, "-x", "--hri-strict")
    change(lamps.path, *changed)
    before = report(lamps.path)
    result = lamps.runpytest_inprocess(SUITE, "-x", "--hri-strict", "--hri-resume")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(
        [f"ERROR: --hri-resume: the journal in * belongs to another session: {told}; without *"]
    )
    assert report(lamps.path) == before


@plain_and_slowly_on_a_worker
def test_only_the_same_options_and_selection_are_resumed(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    lamps.runpytest_inprocess(SUITE, *options)
    before = report(lamps.path)
    other = lamps.runpytest_inprocess(SUITE, "--hri-seed=1", "--hri-resume", *options)
    other.stderr.fnmatch_lines(["ERROR: --hri-resume: * --hri-seed 0, now 1*"])
    fewer = lamps.runpytest_inprocess(SUITE, "-k", "curt", "--hri-resume", *options)
    fewer.stderr.fnmatch_lines(["ERROR: --hri-resume: 4 tests were selected, and 2 are now; *"])
    assert other.ret == fewer.ret == pytest.ExitCode.USAGE_ERROR
    assert report(lamps.path) == before


@pytest.mark.slow
def test_a_journal_that_somebody_doctored_is_not_resumed(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(SUITE)
    path = lamps.path / "hri-report" / journals.NAME
    records = journals.records(path)
    last = max(number for number, record in enumerate(records) if isinstance(record, journals.ResultRecord))
    done = records[last]
    assert isinstance(done, journals.ResultRecord)
    evil = bytes(done.result).replace(b'"id":"by-hand-', b'"id":"../../by-hand-')
    records[last] = journals.ResultRecord(done.nodeid, done.at_s, msgspec.Raw(evil))
    path.write_bytes(b"".join(map(journals.line, records)))
    result = lamps.runpytest_inprocess(SUITE, "--hri-resume")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --hri-resume: the journal in * cannot be resumed: Expected `str`*"])
    path.unlink()
    path.symlink_to(lamps.path / "requirements.toml")
    before = (lamps.path / "requirements.toml").read_text()
    result = lamps.runpytest_inprocess(SUITE, "--hri-resume")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *a symbolic link, which is not followed here: remove it*"])
    assert (lamps.path / "requirements.toml").read_text() == before
