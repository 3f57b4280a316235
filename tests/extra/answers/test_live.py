"""What runs now is shown while it runs: to those who look, on this machine only."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.extra.answers.live_server import HOST, LiveServer, LiveSource
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.folder_files import PROGRESS_FILE, LoopProgress, remove_progress, write_progress
from pytest_hricdv.results.journal import NAME
from tests.extra.campaign import conftest as campaigns
from tests.plugin import project as lamps_project
from tests.report.conftest import chromium

LOOP = LoopProgress(
    done=30,
    most=90,
    workers=2,
    wall_s=10.0,
    verdicts=(("R1", 20, 2, 8),),
    causes=("R1: enter hall; <b>greet</b>",),
    open=("1 statement", "12 bins"),
)


def journal_of(folder: Path, lamps: pytest.Pytester) -> list[bytes]:
    """The lines of the journal of a session: that it began, what it runs, four results, and its end."""
    lamps.runpytest_inprocess("--hri-suite=by-hand", "-p", "no:cacheprovider", "-p", "no:xdist", "--hri-diagnose=0")
    folder.mkdir()
    return (lamps.path / "hri-report" / NAME).read_bytes().splitlines(keepends=True)


def append(folder: Path, lines: list[bytes]) -> None:
    with (folder / NAME).open("ab") as file:
        file.writelines(lines)


def told(source: LiveSource) -> dict[str, Any]:
    """What a source says, whenever it looked last."""
    source._next_s = 0.0
    state = source.state()
    assert state is not None
    return state.data()


@contextmanager
def source_of(path: Path) -> Iterator[LiveSource]:
    source = LiveSource(path)
    try:
        yield source
    finally:
        source.close()


@contextmanager
def serving(path: Path) -> Iterator[LiveServer]:
    with source_of(path) as source, LiveServer(source, 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


def test_a_session_is_shown_as_far_as_its_journal_goes(lamps: pytest.Pytester, tmp_path: Path) -> None:
    lines = journal_of(tmp_path / "live", lamps)
    results = [place for place, line in enumerate(lines) if b'"record":"finished"' in line]
    with source_of(tmp_path / "live") as source:
        assert source.state() is None
        append(tmp_path / "live", lines[: results[2] + 1])
        state = told(source)
        assert (state["what"], state["over"], state["done"], state["total"]) == ("session", False, 3, 4)
        assert state["left"] != ""
        assert {name: passed + failed + nc for name, passed, failed, nc in state["verdicts"]} == {
            "R1": 3,
            "R2": 3,
            "R3": 3,
        }
        assert "3 of 4" in (page := source.files()["index.html"])
        assert "did not come to its end" not in page
        before = source.version
        append(tmp_path / "live", lines[results[2] + 1 :])
        state = told(source)
        assert (state["over"], state["done"], source.version) == (True, 4, before + 1)


def test_a_loop_is_shown_while_it_runs(tmp_path: Path) -> None:
    write_progress(tmp_path, LOOP)
    with source_of(tmp_path) as source:
        state = told(source)
        assert (state["what"], state["done"], state["total"], state["left"]) == ("loop", 30, 90, "about 20 s left")
        assert state["verdicts"] == [("R1", 20, 2, 8)]
        assert state["causes"] == ["R1: enter hall; <b>greet</b>"]
        assert (state["open"], state["has_page"], source.files()) == (["1 statement", "12 bins"], False, {})
        remove_progress(tmp_path)
        remove_progress(tmp_path)
        source._next_s = 0.0
        assert source.state() is None


def test_a_session_after_a_loop_that_was_killed_is_shown(lamps: pytest.Pytester, tmp_path: Path) -> None:
    lines = journal_of(tmp_path / "live", lamps)
    write_progress(tmp_path / "live", LOOP)
    append(tmp_path / "live", lines[:3])
    os.utime(tmp_path / "live" / PROGRESS_FILE, (0, 0))
    with source_of(tmp_path / "live") as source:
        assert told(source)["what"] == "session"


def test_a_file_that_is_no_campaign_is_said(tmp_path: Path) -> None:
    (tmp_path / "a.db").write_text("no database")
    with source_of(tmp_path / "a.db") as source, pytest.raises(ReportError, match=r"a\.db"):
        source.state()


@pytest.mark.slow
def test_a_campaign_is_shown(tmp_path: Path) -> None:
    project = tmp_path / "project"
    project.mkdir()
    lamps_project.write(project)
    assert campaigns.command(project, *campaigns.RUN).returncode in (0, 1)
    with source_of(project / "a.db") as source:
        state = told(source)
        assert (state["what"], state["over"], state["done"], state["total"]) == ("campaign", True, 20, 20)
        assert "index.html" in source.files()


def test_it_leaves_nothing_behind_when_it_is_ended(tmp_path: Path) -> None:
    report, scratch = tmp_path / "report", tmp_path / "scratch"
    report.mkdir()
    scratch.mkdir()
    command = [sys.executable, "-m", "pytest_hricdv", "report", "live", str(report), "--port=0"]
    with subprocess.Popen(command, env={**os.environ, "TMPDIR": str(scratch)}, stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        assert b"http://127.0.0.1:" in server.stdout.readline()
        assert [*scratch.iterdir()]
        server.terminate()
    assert (server.returncode, [*scratch.iterdir()]) == (0, [])


def test_only_this_machine_is_answered_and_no_page_of_another_site(tmp_path: Path) -> None:
    write_progress(tmp_path, LOOP)
    with serving(tmp_path) as server:
        port = server.server_address[1]
        assert server.server_address[0] == HOST == "127.0.0.1"

        def get(path: str, host: str = f"127.0.0.1:{port}") -> tuple[int, bytes]:
            connection = HTTPConnection(HOST, port)
            connection.request("GET", path, headers={"Host": host})
            answer = connection.getresponse()
            return answer.status, answer.read()

        assert get("/status", "evil.example")[0] == 403
        status, text = get("/status")
        assert (status, json.loads(text)["done"]) == (200, 30)
        assert [get(path)[0] for path in ("/", "/live.js", "/live.css")] == [200, 200, 200]
        outside = ("/report/index.html", "/report/../../etc/passwd", "/etc/passwd", "/live.html", "/report/%2e%2e/a")
        assert {get(path)[0] for path in outside} == {404}


def test_a_browser_follows_a_session_to_its_end(lamps: pytest.Pytester, tmp_path: Path) -> None:
    lines = journal_of(tmp_path / "live", lamps)
    results = [place for place, line in enumerate(lines) if b'"record":"finished"' in line]
    write_progress(tmp_path / "live", LOOP)
    with chromium() as browser, serving(tmp_path / "live") as server:
        page = browser.new_page()
        said: list[str] = []
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("console", lambda message: said.append(message.text))
        page.goto(server.address)
        page.get_by_text("loop: 30 of 90 runs").wait_for()
        page.get_by_text("R1: enter hall; <b>greet</b>").wait_for()
        remove_progress(tmp_path / "live")
        append(tmp_path / "live", lines[: results[1] + 1])
        page.get_by_text("session: 2 of 4 tests").wait_for()
        frame = page.frame_locator("#page")
        frame.get_by_role("heading", name="lamps", exact=True).wait_for()
        append(tmp_path / "live", lines[results[1] + 1 :])
        page.get_by_text("Ended: session: 4 of 4 tests").wait_for()
        frame.get_by_text("4 of 4").first.wait_for()
        assert said == []
        page.close()
