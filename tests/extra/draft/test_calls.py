"""Code that hears nothing by itself: somebody outside calls its functions and methods."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.found.findings import Findings
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files
from tests.extra.draft import called_robots


def findings_of(tmp_path: Path, source: str) -> Findings:
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    return analyse("robot_code", tmp_path)


HEARD = {
    "CONDITION": {"RequestCup": {}, "TrayChanged": {"is_full": ()}, "Stop": {}},
    "GLOBAL_CLIENT": {"OnMessage": {"msg_payload": ("on",)}},
    "WEB": {"Status": {}, "Move": {"speed": ()}, "Stop": {}},
    "EVENTS": {"Request": {}, "Up": {}, "Passed": {}, "Down": {}, "Obstacle": {}},
    "TABLE_OF_METHODS": {"Execute": {"command": ("forward", "back", "grip", "release")}},
    "METHODS": {"Fetch": {"bottle": ()}, "HandOver": {}, "Cancel": {}},
    "BUTTONS": {"Pressed": {}, "Tripped": {}},
    "STEPPED": {"Step": {"object_seen": (), "distance": (), "grip_force": ()}},
    "DECORATED": {"TakeOrder": {}, "Taken": {}},
    "OWN_QUEUE": {"Submit": {"room": (), "item": ("linen", "meal")}},
    "TIMER": {"BreadIn": {}, "Cancel": {}, "BreadOut": {}},
}


@pytest.mark.parametrize("name", HEARD)
def test_what_somebody_outside_calls_is_heard_with_its_arguments(name: str, tmp_path: Path) -> None:
    findings = findings_of(tmp_path, getattr(called_robots, name))
    heard = {m.name: {p.name: tuple(v.text for v in p.values) for p in m.fields} for m in findings.heard}
    assert heard == HEARD[name]
    assert [calling.message for calling in findings.calls] == list(heard)
    assert any(message.form == "failure" for message in findings.said)
    for file, text in files(Draft(findings, "robot_code", "person", tmp_path)):
        if file.endswith(".py"):
            ast.parse(text)


def test_a_queue_that_what_is_called_fills_stays_the_robots_own(tmp_path: Path) -> None:
    """In its place stood one of the test, into which the method could not put."""
    findings = findings_of(tmp_path, called_robots.OWN_QUEUE)
    assert findings.channels == ()


def test_a_whole_number_and_a_truth_are_what_they_are_in_a_draft(tmp_path: Path) -> None:
    """The files were `room: int = 0.0`, and a requirement that compared truths, which no session could read."""
    findings = findings_of(tmp_path, called_robots.OWN_QUEUE)
    written = dict(files(Draft(findings, "robot_code", "person", tmp_path)))
    assert "    room: int = 0  #" in written["ports.py"]
    assert (
        "<= 1 | last(submit_text.text) & !submit_text.text | !last(submit_text.text) &" in written["requirements.toml"]
    )


STATES = {
    "CONDITION": ("made.state", ["idle", "filling", "waiting", "blocked", "serving"]),
    "GLOBAL_CLIENT": ('import_module("robot_code").mode', ["off", "on"]),
    "WEB": ('import_module("robot_code").robot["state"]', ["idle", "moving", "stopped"]),
    "EVENTS": ("made.current_state.id", ["closed", "opening", "opened", "closing"]),
    "BUTTONS": ('import_module("robot_code").state', ["off", "armed", "alarm"]),
}


@pytest.mark.parametrize("name", STATES)
def test_a_state_of_an_object_or_a_module_is_looked_at(name: str, tmp_path: Path) -> None:
    findings = findings_of(tmp_path, getattr(called_robots, name))
    read, states = STATES[name]
    message = next(message for message in findings.said if message.form == "state")
    assert message.channel == read
    assert [value.text for value in message.fields[0].values] == states


def test_what_is_called_gets_what_it_reads(tmp_path: Path) -> None:
    findings = findings_of(tmp_path, called_robots.GLOBAL_CLIENT)
    payload = "SimpleNamespace(payload=message.msg_payload.encode())"
    assert findings.calls[0].arguments == ("Anything()", "None", payload)
    web = findings_of(tmp_path, called_robots.WEB)
    assert next(calling for calling in web.calls if calling.message == "Move").arguments == (
        'request={"speed": message.speed}',
    )


def test_what_the_code_calls_itself_is_not_heard(tmp_path: Path) -> None:
    source = """
class Lamp:
    def __init__(self):
        self.is_on = False

    def press(self):
        self.toggle()

    def toggle(self):
        self.is_on = not self.is_on

    @property
    def colour(self):
        return "red" if self.is_on else "none"

    def _hidden(self):
        return None
"""
    findings = findings_of(tmp_path, source)
    assert [message.name for message in findings.heard] == ["Press"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["CONDITION", "GLOBAL_CLIENT", "WEB", "TABLE_OF_METHODS", "STEPPED", "DECORATED"])
def test_a_draft_of_code_that_is_called_is_green_at_once(name: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(called_robots, name), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "is not green" not in made.stdout
    has_global_state = name in ("GLOBAL_CLIENT", "WEB", "DECORATED")
    assert ("hri_isolate = true" in (tmp_path / "draft" / "pytest.ini").read_text(encoding="utf-8")) == has_global_state
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q"], cwd=tmp_path / "draft", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert "tests: 30 passed" in done.stdout


def test_nobody_hands_over_a_listener(tmp_path: Path) -> None:
    source = """
class Scale:
    def __init__(self):
        self._listeners = []

    def add_listener(self, listener):
        self._listeners.append(listener)

    def tare(self):
        for listener in self._listeners:
            listener("tared")
"""
    assert [message.name for message in findings_of(tmp_path, source).heard] == ["Tare"]
