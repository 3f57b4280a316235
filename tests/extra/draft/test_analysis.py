from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import CodeModel, StateMachine
from pytest_hricdv.extra.draft.first_runs import sentence_of
from tests.extra.draft import robots

ROOT = Path(__file__).parents[3]


def read(tmp_path: Path, source: str, name: str = "robot_code") -> CodeModel:
    """The model of a module with this source."""
    (tmp_path / f"{name}.py").write_text(source, encoding="utf-8")
    return analyse(name, tmp_path)


def moves(machine: StateMachine) -> set[str]:
    return {f"{move.source}>{move.target}" for move in machine.transitions}


STATES = {
    "TRANSITIONS": (
        "idle moving open halted",
        "idle>moving moving>open open>idle moving>halted open>halted idle>idle moving>idle halted>idle",
    ),
    "STATEMACHINE": (
        "closed opening opened broken",
        "closed>opening opening>opened opened>closed opening>closed opening>broken opened>broken",
    ),
}


@pytest.mark.parametrize("name", STATES)
def test_states_and_transitions_are_those_of_the_source(name: str, tmp_path: Path) -> None:
    states, transitions = STATES[name]
    machine = read(tmp_path, getattr(robots, name)).machines[0]
    assert [state.name for state in machine.states] == states.split()
    assert moves(machine) == set(transitions.split())


def test_messages_have_their_direction_their_fields_and_their_values(tmp_path: Path) -> None:
    model = read(tmp_path, robots.MATCH)
    directions = {message.name: message.direction for message in model.messages}
    assert directions == {"Command": "received", "Taken": "received", "ModeChanged": "published"}
    command = model.inputs[0]
    assert [value.text for value in command.fields[0].values] == ["fetch", "abort"]
    assert command.fields[0].by_type
    assert str(command.location) == "robot_code.py:16"


def test_how_it_waits_and_its_numbers_have_their_places(tmp_path: Path) -> None:
    model = read(tmp_path, robots.MATCH)
    assert {seconds for seconds, _ in model.time_outs} == {5.0, 1.0, 2.0}


@pytest.mark.parametrize("source", ["def f(:\n", "X = " + " + ".join(["1"] * 9_000) + "\n"], ids=["syntax", "depth"])
def test_a_file_that_cannot_be_read_is_said_and_the_rest_is_read(source: str, tmp_path: Path) -> None:
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "__init__.py").write_text("", encoding="utf-8")
    (tmp_path / "pack" / "broken.py").write_text(source, encoding="utf-8")
    (tmp_path / "pack" / "robot.py").write_text(robots.MATCH, encoding="utf-8")
    model = analyse("pack", tmp_path)
    assert [str(problem.location) for problem in model.problems] == ["pack/broken.py:1"]
    assert len(model.messages) == 3


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("robot_cod", "no module 'robot_cod'"),
        ("robot code", "expected PACKAGE"),
        ("robot_code:Fetch", "no function or class 'Fetch'; nearest: Fetcher"),
        ("robot_code:Fetcher.rum", "Fetcher has no method 'rum'; nearest: run"),
    ],
)
def test_what_does_not_exist_is_one_sentence(tmp_path: Path, asked: str, said: str) -> None:
    (tmp_path / "robot_code.py").write_text(robots.MATCH, encoding="utf-8")
    with pytest.raises(DraftError, match=said):
        analyse(asked, tmp_path)


def test_states_of_an_enumeration_are_told_as_the_record_calls_them(tmp_path: Path) -> None:
    source = """
from enum import Enum
from transitions import Machine


class Phase(Enum):
    IDLE = "idle"
    BUSY = "busy"


class Robot:
    def __init__(self):
        self.machine = Machine(self, states=Phase, initial=Phase.IDLE, transitions=[["go", Phase.IDLE, Phase.BUSY]])
"""
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    machine = analyse("robot_code", tmp_path).machines[0]
    assert [state.name for state in machine.states] == ["idle", "busy"]
    assert [(move.source, move.target) for move in machine.transitions] == [("idle", "busy")]


def test_a_machine_of_a_class_that_derives_from_the_librarys_is_read(tmp_path: Path) -> None:
    source = """
from transitions import Machine
from transitions.extensions.states import Timeout, add_state_features

@add_state_features(Timeout)
class TimedMachine(Machine):
    pass

class Bar:
    def __init__(self):
        self.machine = TimedMachine(model=self, states=["idle", {"name": "busy", "timeout": 9, "on_timeout": "end"}],
                                    transitions=[["go", "idle", "busy"], ["end", "busy", "idle"]], initial="idle")
"""
    (machine,) = read(tmp_path, source).machines
    assert ([state.name for state in machine.states], moves(machine)) == (["idle", "busy"], {"idle>busy", "busy>idle"})


HALL = """
import queue
from dataclasses import dataclass
from typing import Protocol

PLACES = {"hall": 1, "desk": 2}


@dataclass(frozen=True)
class Pose:
    x: float
    seen: tuple[float, ...]


@dataclass(frozen=True)
class Goal:
    where: str
    level: float
    near: Pose


@dataclass(frozen=True)
class Done:
    text: str


class Base(Protocol):
    lights: bool

    def pose(self) -> Pose: ...

    def is_blocked(self) -> bool: ...

    def drive(self, speed: float) -> None: ...


class Guide:
    def __init__(self, goals: queue.Queue, publish, base: Base, patience_s: float):
        self.goals, self._publish, self.base = goals, publish, base

    def run(self):
        while True:
            goal = self.goals.get()
            if isinstance(goal, Goal) and goal.where in PLACES and goal.level < 0.5:
                self.guide()

    def guide(self):
        self.base.lights = True
        if not self.base.is_blocked():
            self.base.drive(0.2 if self.base.pose().x else 0.1)
        self._publish(Done("here"))
"""


def test_the_entry_and_its_ports_are_found(tmp_path: Path) -> None:
    entry = read(tmp_path, HALL).entry
    assert entry is not None
    assert (entry.name, entry.method, entry.is_certain) == ("Guide", "run", True)
    assert {port.name: (port.role, port.direction) for port in entry.ports} == {
        "goals": ("queue", "received"),
        "publish": ("publish", ""),
        "base": ("device", ""),
        "patience_s": ("parameter", ""),
    }
    operations = {o.name: (o.is_method, o.returns, o.neutral) for o in entry.ports[2].operations}
    assert operations == {
        "lights": (False, "bool", "False"),
        "is_blocked": (True, "bool", "False"),
        "drive": (True, "None", "None"),
        "pose": (True, "Pose", "Pose(x=0.0, seen=(10.0,) * 36)"),
    }


def test_fields_have_the_texts_and_numbers_that_the_code_compares(tmp_path: Path) -> None:
    model = read(tmp_path, HALL)
    (goal,) = model.inputs
    where, level, near = goal.fields
    assert [value.text for value in where.values] == ["hall", "desk"]
    assert level.compared == (0.5,)
    assert near.neutral == "Pose(x=0.0, seen=(10.0,) * 36)"
    (done,) = model.outputs
    assert [value.text for value in done.fields[0].values] == ["here"]


def test_what_the_code_leaves_open_is_a_question_with_its_location(tmp_path: Path) -> None:
    questions = {question.about: str(question.location) for question in read(tmp_path, HALL).questions}
    assert questions == {
        "goal.level": "robot_code.py:18",
        "state": "None",
        "patience_s": "robot_code.py:38",
        "base": "robot_code.py:38",
    }


@pytest.mark.parametrize(
    ("source", "guard"),
    [
        ("import nowhere_lib\n", False),
        ("try:\n    import nowhere_lib\nexcept KeyError:\n    pass\n", False),
        ("if True:\n    import nowhere_lib\n", False),
        *(
            (f"try:\n    from nowhere_lib.part import it\nexcept {caught}:\n    it = None\n", True)
            for caught in ("ImportError", "(ModuleNotFoundError, OSError)", "Exception as error")
        ),
        ("try:\n    import nowhere_lib\nexcept:\n    pass\n", True),
        ("import contextlib\nwith contextlib.suppress(ImportError):\n    import nowhere_lib\n", True),
        ("import typing\nif typing.TYPE_CHECKING:\n    import nowhere_lib\n", True),
    ],
)
def test_a_module_that_is_not_installed_gets_a_stand_in_unless_its_import_is_guarded(
    source: str, guard: bool, tmp_path: Path
) -> None:
    problems = read(tmp_path, source + robots.MATCH).problems
    assert [problem.kind for problem in problems] == ([] if guard else ["missing module"])


def test_values_of_the_home_care_robot_are_found() -> None:
    model = analyse("carebot", ROOT / "examples" / "home_care")
    values = {f"{m.topic}.{f.name}": {v.text for v in f.values} for m in model.messages for f in m.fields}
    assert values["order.kind"] == {"fridge", "sink", "feed", "clean", "ended"}
    assert {message.name for message in model.outputs} == {
        "State", "Accepted", "Refused", "Completed", "Idle", "Docked", "Food",
    }  # fmt: skip


@pytest.mark.parametrize("has_init", [True, False])
def test_scripts_that_import_each_other_by_their_bare_names_are_one_code(tmp_path: Path, has_init: bool) -> None:
    folder = tmp_path / "rover"
    (folder / "auto").mkdir(parents=True)
    if has_init:
        (folder / "__init__.py").write_text("", encoding="utf-8")
    (folder / "messages.py").write_text(robots.MATCH, encoding="utf-8")
    (folder / "auto" / "steps.py").write_text("FAST = 1\n", encoding="utf-8")
    (folder / "main.py").write_text("from auto.steps import FAST\nfrom messages import Fetcher\n", encoding="utf-8")
    model = analyse("rover/", tmp_path)
    assert (Path(model.root), model.problems) == (folder, ())
    assert set(model.modules) == {"main", "messages", "auto"}


def test_a_package_whose_module_has_the_name_of_a_library_stays_a_package(tmp_path: Path) -> None:
    folder = tmp_path / "rover"
    folder.mkdir()
    (folder / "__init__.py").write_text("", encoding="utf-8")
    (folder / "logging.py").write_text("FAST = 1\n", encoding="utf-8")
    (folder / "main.py").write_text("import logging\n\nlogging.info('here')\n", encoding="utf-8")
    assert Path(analyse("rover", tmp_path).root) == tmp_path


@pytest.mark.parametrize(
    ("failure", "said"),
    [
        (">   raise ValueError(1)\nE   ValueError: 1\n\nrobot.py:3: ValueError", "ValueError: 1"),
        (
            'Traceback (most recent call last):\n  File "a.py", line 1, in f\nKeyError: 2\n\n'
            "During handling of the above exception, another exception occurred:\n\n"
            'Traceback (most recent call last):\n  File "a.py", line 3, in f\nOSError: no camera\n',
            "OSError: no camera",
        ),
        (
            "StateChanged.state: 'lost' is none of its values\n\nended:   after 3 s",
            "StateChanged.state: 'lost' is none of its values",
        ),
    ],
)
def test_what_was_raised_is_the_last_exception(failure: str, said: str) -> None:
    assert sentence_of(failure) == said
