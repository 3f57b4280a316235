"""What an IDE does: find the tests with nothing on the command line, run and debug one by its node id."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.plugin.ide import Client, under_an_ide
from tests.plugin.project import change, nodeids, report

DEFAULT = ("hri_known_violations =", "hri_suite = by-hand\nhri_known_violations =")


@pytest.fixture
def default(lamps: pytest.Pytester) -> pytest.Pytester:
    """The lamps project with a default suite in its ini."""
    change(lamps.path, "pytest.ini", *DEFAULT)
    return lamps


@pytest.mark.slow
def test_a_node_id_found_is_a_node_id_that_runs_and_nothing_is_generated_twice(default: pytest.Pytester) -> None:
    first, *_others, own = nodeids(default.runpytest_inprocess("--collect-only", "-q"))
    assert first == "test_lamps.py::test_lamps[by-hand-hall-polite-5a5e8c87]"  # the suite and the aim can be read
    assert own == "test_lamps.py::test_of_their_own"
    for selection in (first, str(default.path / first)):
        default.runpytest_inprocess(selection)
        saved = report(default.path)
        assert [test["nodeid"] for test in saved["tests"]] == [first]
        assert saved["suites"]


BDB = '''
"""A debugger as the standard library has it: sets a trace function, and stops at a line."""

import bdb
import os
import sys
import threading

import pytest


class Debugger(bdb.Bdb):
    def user_line(self, frame):
        if self.break_here(frame):
            stops.append(f"stopped in {frame.f_code.co_name}: {frame.f_locals.get('level')}")
        self.set_continue()

    def set_continue(self):
        self._set_stopinfo(self.botframe, None, -1)


stops = []
debugger = Debugger()
debugger.set_break(os.path.abspath(sys.argv[1]), int(sys.argv[2]))
debugger.reset()
threading.settrace(debugger.trace_dispatch)
sys.settrace(debugger.trace_dispatch)
code = pytest.main(sys.argv[3:])
sys.settrace(None)
for stop in stops:
    print(stop)
sys.exit(code)
'''


def line_of(folder: Path, name: str, text: str) -> int:
    """The number of the only line with this text."""
    (number,) = [n for n, line in enumerate((folder / name).read_text().splitlines(), 1) if line.strip() == text]
    return number


@pytest.mark.slow
def test_breakpoints_stop_in_the_controller_and_measuring_says_that_it_stood_aside(lamps: pytest.Pytester) -> None:
    script = lamps.makepyfile(debugger=BDB)
    line = line_of(lamps.path, "lamps/guide.py", "lamp.set(level)")
    result = lamps.run(sys.executable, script, "lamps/guide.py", str(line), "--hri-suite=by-hand", "--hri-tests=2")
    assert result.ret == 0
    assert [each for each in result.outlines if each.startswith("stopped")] == [
        "stopped in serve: 100.0",
        "stopped in serve: 10.0",
    ]
    result.stdout.fnmatch_lines(["  code unmeasured: a debugger holds the trace function"])
    assert [test["outcome"] for test in report(lamps.path)["tests"]].count("error") == 0


@pytest.mark.slow
def test_an_ides_debugger_stops_in_the_controller(lamps: pytest.Pytester, tmp_path: Path) -> None:
    pytest.importorskip("debugpy")
    stops: list[tuple[str, int]] = []

    def converse(client: Client) -> None:
        stops.extend(_stops(client, lamps.path / "lamps" / "guide.py", 19))

    run = ("-m", "pytest", "--hri-suite=by-hand", "--hri-tests=2")
    text = under_an_ide(run, lamps.path, tmp_path / "endpoints.json", converse)
    assert stops == [("serve", 19), ("serve", 19)]
    assert "unmeasured: the IDE's debugger (pydevd) is attached" in text


def _stops(client: Client, file: Path, line: int) -> list[tuple[str, int]]:
    client.ask("initialize", adapterID="tests", pathFormat="path", linesStartAt1=True)
    client.ask("attach", justMyCode=True)
    stops = []
    for message in client.told():
        assert message.get("success", True), message
        kind, body = message.get("event") or message.get("command"), message.get("body") or {}
        if kind == "initialized":
            client.ask("setBreakpoints", source={"path": str(file)}, breakpoints=[{"line": line}])
            client.ask("configurationDone")
        elif kind == "stopped":
            thread = body["threadId"]
            client.ask("stackTrace", threadId=thread)
        elif kind == "stackTrace":
            top = body["stackFrames"][0]
            stops.append((top["name"], top["line"]))
            client.ask("continue", threadId=thread)
        elif kind == "terminated":
            break
    return stops
