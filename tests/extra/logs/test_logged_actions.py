"""Actions of people in logs become abstract tests."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_hricdv._base.message import InputError
from pytest_hricdv.extra.logs.log_map import read_map
from pytest_hricdv.extra.logs.logged_actions import LoggedActions
from pytest_hricdv.extra.logs.logged_run import LogReader
from pytest_hricdv.generate.concrete import Concretization
from pytest_hricdv.generate.sampler import Uniform
from pytest_hricdv.monitor import Vocabulary
from pytest_hricdv.recordings.recording import recording_readers
from tests.plugin import project
from tests.recordings.bags import Entry, write_mcap

ACTIONS = """
[actions.enter]
topic = "/door"
command = "enter {room}"
since = "pause_s"

[actions.greet]
topic = "/speech"
command = "greet"
only = { said = "hello" }
since = "pause_s"

[actions.wish]
topic = "/wish"
command = "set_lamp level = {percent}"
parameters.pause_s = { expression = "thought_ms / 1000" }
"""
FIELD_LOG: list[Entry] = [
    (0.0, "/door", {"room": "hall"}),
    (0.75, "/speech", {"said": "hello"}),
    (1.0, "/speech", {"said": "well"}),
    (4.0, "/wish", {"percent": 10.0, "thought_ms": 900.0}),
]


PAUSE = {"pause_s": Uniform(0.5, 1.0, "s")}
COMMANDS = Concretization(commands=dict.fromkeys(("enter hall", "greet", "set_lamp level = 10"), PAUSE))


def logged(folder: Path, made: Sequence[Entry], actions: str) -> LoggedActions:
    """The tests of a log."""
    file = write_mcap(folder / "field.mcap", made)
    (folder / "map.toml").write_text(actions)
    vocabulary = Vocabulary(signals={})
    tests = LoggedActions(COMMANDS, read_map(folder / "map.toml", vocabulary))
    (recording,) = recording_readers([file], lambda kind: None)
    tests.add(LogReader(recording, tests.made, vocabulary))
    return tests


def test_the_actions_of_a_log_are_a_test_that_runs(lamps: pytest.Pytester) -> None:
    write_mcap(lamps.path / "field.mcap", FIELD_LOG)
    (lamps.path / "map.toml").write_text(ACTIONS)
    command = [sys.executable, "-m", "pytest_hricdv", "check", "field.mcap", "--map=map.toml", "--to-tests=logged.txt"]
    done = subprocess.run(command, cwd=lamps.path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "1 test in logged.txt; now: pytest --hri-suite=logged.txt\n"), done
    assert done.stderr == (
        "note: field.mcap: action 1, enter hall: pause_s is drawn: 0 is outside of its range [0.5, 1] s\n"
    )
    text = (lamps.path / "logged.txt").read_text()
    assert "# values 2: pause_s 0.75\n# values 3: pause_s 0.9\nenter hall\ngreet\nset_lamp level = 10\n" in text
    assert lamps.runpytest_inprocess("--hri-suite=logged.txt", "-p", "no:xdist").ret == 0
    (test,) = project.report(lamps.path)["tests"]
    assert test["concrete"]["actions"][1]["parameters"]["pause_s"] == 0.75


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("{room}", "attic", "field.mcap: /door: the testbench has no command 'enter attic'; nearest: enter hall"),
        ("{room}", "{rom}", "/door: its messages have no field rom; nearest: room"),
        ('command = "greet"', 'command = "greet("', "/speech: 'greet\\(' is not a command; expected "),
        ("thought_ms / 1000", "thought", "expected numbers; its messages have no field thought; nearest: thought_ms"),
        ("parameters.pause_s", "parameters.paus_s", "has no parameter paus_s; nearest: pause_s"),
        ('{ expression = "thought_ms / 1000" }', '{ path = "thought_ms", unit = "ms" }', "its unit is not declared"),
    ],
)
def test_an_action_that_is_not_one_is_refused(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in ACTIONS
    with pytest.raises(InputError, match=told):
        logged(tmp_path, FIELD_LOG, ACTIONS.replace(old, new))


def test_a_log_without_actions_has_no_test(tmp_path: Path) -> None:
    tests = logged(tmp_path, FIELD_LOG[2:3], ACTIONS)
    assert (tests.drafts, tests.notes) == ([], ["field.mcap: has no action of the map"])
