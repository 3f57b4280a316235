"""A function for each class of messages: what the code hears is the classes of its table."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.found.findings import Findings, Message
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files
from tests.extra.draft import handled_robots


@pytest.fixture
def findings(request: pytest.FixtureRequest, tmp_path: Path) -> Findings:
    source: str = getattr(handled_robots, request.param)
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    return analyse("robot_code", tmp_path)


def message(findings: Findings, name: str) -> Message:
    return next(message for message in findings.messages if message.name == name)


def moves(findings: Findings) -> set[tuple[str, str]]:
    return {(move.source, move.target) for machine in findings.machines for move in machine.transitions}


@pytest.mark.parametrize("findings", ["TABLE"], indirect=True)
def test_the_classes_of_a_table_are_heard_and_nothing_else_is(findings: Findings) -> None:
    directions = {message.name: message.direction for message in findings.messages}
    assert directions == dict.fromkeys(("Fetch", "Cancel", "Range", "Reset"), "heard") | {"Changed": "said"}
    assert not [question for question in findings.questions if "What comes through" in question.text]


@pytest.mark.parametrize("findings", ["TABLE"], indirect=True)
def test_the_functions_of_a_table_say_what_fields_can_be(findings: Findings) -> None:
    fields = {(name, part.name): part for name in ("Fetch", "Cancel", "Range", "Reset")
              for part in message(findings, name).fields}  # fmt: skip
    assert [value.text for value in fields["Cancel", "reason"].values] == ["wrong book", "too late"]
    assert fields["Fetch", "level"].compared == (0.0, 4.0)
    assert fields["Reset", "code"].compared == (7.0, 9.0)
    assert fields["Range", "metres"].compared == (0.5,)  # a default of `Limits`, by way of `self.limits`


@pytest.mark.parametrize("findings", ["TABLE"], indirect=True)
def test_the_functions_of_a_table_move_between_states(findings: Findings) -> None:
    assert moves(findings) == {("IDLE", "BUSY"), ("BUSY", "IDLE"), ("BUSY", "STOPPED"), ("STOPPED", "IDLE")}


@pytest.mark.parametrize("findings", ["DISPATCH"], indirect=True)
def test_single_dispatch_says_what_is_heard(findings: Findings) -> None:
    directions = {message.name: message.direction for message in findings.messages}
    assert directions == {"Fetch": "heard", "Cancel": "heard", "Changed": "said"}
    assert [value.text for part in message(findings, "Cancel").fields for value in part.values] == ["wrong book"]
    assert moves(findings) == {("IDLE", "BUSY"), ("BUSY", "IDLE")}


@pytest.mark.parametrize("findings", ["TABLE"], indirect=True)
def test_a_class_of_the_code_may_have_a_name_of_the_testbench(findings: Findings, tmp_path: Path) -> None:
    text = dict(files(Draft(findings, "robot_code", "person", tmp_path.resolve())))["conftest.py"]
    assert '"after_s": testbench.Range(0.5, 2.0, "s")' in text
    assert 'return Range(metres=numbers["metres"])' in text
    assert "from robot_code import Cancel, Changed, Fetch, Range, Reset" in text


def test_a_line_whose_bytes_are_unpacked_gets_bytes(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(handled_robots.GAUGE, encoding="utf-8")
    text = dict(files(Draft(analyse("robot_code", tmp_path), "robot_code", "person", tmp_path.resolve())))[
        "conftest.py"
    ]
    assert "is_text=False" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", ["TABLE", "DISPATCH"])
def test_a_draft_of_such_a_robot_is_green(name: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(handled_robots, name), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "is not green" not in made.stdout
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--hri-suite=rl,closure"],
        cwd=tmp_path / "draft", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
