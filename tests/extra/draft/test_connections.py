"""Code that makes a connection itself, or is called with one."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files
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


def test_what_a_client_is_handed_over_to_says_by_keywords(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(connected_robots.CLIENT_THAT_IS_HANDED_OVER, encoding="utf-8")
    findings = analyse("robot_code", tmp_path)
    values = {
        (message.name, part.name): {value.text for value in part.values}
        for message in findings.messages
        for part in message.fields
    }
    assert values["InboxTuple", "topic"] == {"courier/stop", "courier/order", "courier/parcel"}
    assert values["InboxTuple", "item_1_room"] == {"kitchen", "lab", "office"}
    assert values["ClientJson", "name"] == {"parked", "loading", "driving", "handing", "fault"}
    assert values["ClientJson", "room"] == set()
    assert not [problem for problem in findings.problems if problem.kind == "entry"]


@pytest.mark.parametrize(
    "payload", ["fields", '{**fields, "at": 1.0}', "dict(fields)", "dict(fields, at=1.0)", '{"at": 1.0} | fields']
)
def test_keywords_that_are_handed_on_are_keys(payload: str, tmp_path: Path) -> None:
    code = connected_robots.CLIENT_THAT_IS_HANDED_OVER.replace("json.dumps(fields)", f"json.dumps({payload})")
    (tmp_path / "robot_code.py").write_text(code, encoding="utf-8")
    (said,) = (message for message in analyse("robot_code", tmp_path).messages if message.name == "ClientJson")
    assert {"name", "room"} <= {part.name for part in said.fields}
    assert ("at" in payload) == ("at" in {part.name for part in said.fields})


def test_a_function_that_hears_nothing_is_said_to_make_what_does(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(connected_robots.CLIENT_THAT_IS_HANDED_OVER, encoding="utf-8")
    (problem,) = (problem for problem in analyse("robot_code:main", tmp_path).problems if problem.kind == "entry")
    assert problem.text == (
        "nothing was found that `main` hears; `Courier`, which it may make, hears `inbox_tuple`: to draft that, "
        "`--from robot_code`"
    )


def test_events_that_go_by_a_client_of_a_library_are_said_to_be_unseen(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(connected_robots.HANDLERS_OF_A_LIBRARY, encoding="utf-8")
    (problem,) = (problem for problem in analyse("robot_code", tmp_path).problems if problem.kind == "unseen")
    assert problem.text == (
        "`sio` of `socketio` hears 'order', 'obstacle' and says 'phase', 'hello', 'refused', 'served': the draft sees "
        "none of it, as `sio` is no parameter of what runs the robot. Hand it over, and draft again"
    )


@pytest.mark.slow
def test_a_fault_that_the_first_runs_find_is_taken_for_one(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(connected_robots.CLIENT_THAT_IS_HANDED_OVER, encoding="utf-8")
    made = subprocess.run(
        [sys.executable, "-m", "pytest_hricdv", "init", "hri", "--from", "robot_code"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "InterruptedError: the draft is not green; " in made.stdout
    assert " tests end so: a fault of the code, for what it hears in them (`pytest` shows it)?" in made.stdout


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
