"""Code that makes a connection itself, or is called with one."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.drafted import Draft
from pytest_hricdv.extra.draft.project import files
from tests.extra.draft import connected_robots

READ = {
    "SERIAL": (("START", "STOP", "SPEED 1"), ("OK RUN", "OK IDLE", "ERR", "TIMEOUT")),
    "DATAGRAMS": (("takeoff", "land"), ("ok", "error")),
    "REPLIES": (("open", "close"), ("ok", "refused")),
    "SELECTED": (("on", "off"), ("light on", "light off", "what")),
    "WEBSOCKET": (("start", "stop"), ("running", "done", "idle")),
}


@pytest.mark.parametrize("name", READ)
def test_what_comes_and_goes_by_a_connection_is_read(name: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(connected_robots, name), encoding="utf-8")
    findings = analyse("robot_code", tmp_path)
    heard, said = READ[name]
    fields = {
        tuple(value.text.strip() for value in part.values)
        for message in findings.heard
        for part in message.fields
        if part.values
    }
    assert heard in fields
    texts = {value.text.strip() for message in findings.said for part in message.fields for value in part.values}
    assert set(said) <= texts
    assert len({message.name for message in findings.messages}) == len(findings.messages)
    for file, text in files(Draft(findings, "robot_code", "person", tmp_path)):
        if file.endswith(".py"):
            ast.parse(text)


def test_a_client_of_a_broker_says_what_it_publishes_and_hears_by_its_callback(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(connected_robots.CLIENT_OF_A_CLASS, encoding="utf-8")
    findings = analyse("robot_code", tmp_path)
    message = next(message for message in findings.heard if message.name == "OnMessage")
    values = {part.name: tuple(value.text for value in part.values) for part in message.fields}
    assert values["msg_topic"] == ("mower/cmd", "mower/rain")
    assert values["msg_payload_action"] == ("mow", "dock")
    assert findings.state == "client_json.state"
    assert not [question for question in findings.questions if "carries the topic" in question.text]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*READ, "CLIENT_OF_A_CLASS"])
def test_a_draft_of_code_with_a_connection_is_green_at_once(name: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(connected_robots, name), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "is not green" not in made.stdout
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q"], cwd=tmp_path / "draft", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout
