from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.first_runs.transitions import with_transitions
from pytest_hricdv.extra.draft.found.findings import Findings, Machine
from pytest_hricdv.extra.draft.reading.sources import DraftError
from tests.extra.draft import robots

ROOT = Path(__file__).parents[3]


def read(tmp_path: Path, source: str, name: str = "robot_code") -> Findings:
    """The findings of a module with this source."""
    (tmp_path / f"{name}.py").write_text(source, encoding="utf-8")
    return analyse(name, tmp_path)


def moves(machine: Machine) -> set[str]:
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
    "SMACH": ("FIND GRASP HAND_OVER", "FIND>GRASP GRASP>HAND_OVER GRASP>FIND HAND_OVER>FIND"),
    "YASMIN": ("IDLE WORK", "IDLE>WORK WORK>IDLE"),
    "MATCH": (
        "idle fetching offering fault",
        "idle>fetching fetching>fault fetching>offering offering>fault offering>idle fault>idle",
    ),
    "CHAIN": ("idle drive turn", "idle>drive drive>turn drive>idle turn>drive"),
    "DISPATCH": ("home serving clearing", "home>serving serving>clearing serving>home clearing>home"),
    "TABLE": ("WAIT PICK PLACE", "WAIT>PICK PICK>PLACE PICK>WAIT PLACE>WAIT"),
    "CLASSES": ("Idle Driving HandOver", "Idle>Driving Driving>HandOver HandOver>Idle"),
    "CONTEXT": ("Closed Opening", "Closed>Opening Opening>Closed"),
    "GUARDS": ("off on locked", "off>on on>off off>locked on>locked locked>off"),
}


@pytest.mark.parametrize("name", STATES)
def test_states_and_transitions_are_those_of_the_source(name: str, tmp_path: Path) -> None:
    states, transitions = STATES[name]
    machine = read(tmp_path, getattr(robots, name)).machines[0]
    assert [state.name for state in machine.states] == states.split()
    assert moves(machine) == set(transitions.split())


def test_what_states_of_their_own_take_from_the_robot_is_heard(tmp_path: Path) -> None:
    """What `cart` is, only the method says that these override."""
    findings = read(tmp_path, robots.CLASSES)
    assert [message.topic for message in findings.heard] == ["order", "handed"]
    assert findings.machines[0].told == "cart_state.name"
    assert [message.channel for message in findings.said if message.topic == "cart_state"] == [
        "type(made.state).__name__"
    ]


def test_what_a_parameter_is_without_an_annotation_say_its_calls(tmp_path: Path) -> None:
    source = robots.CLASSES.replace("cart: Cart", "cart")
    assert [message.topic for message in read(tmp_path, source).heard] == ["order", "handed"]


def test_behaviours_of_a_tree_are_its_states(tmp_path: Path) -> None:
    machine = read(tmp_path, robots.TREE).machines[0]
    assert [state.name for state in machine.states] == ["Reach", "Grasp cup", "Say done"]
    assert machine.kind == "py_trees"


def test_messages_have_their_direction_their_fields_and_their_values(tmp_path: Path) -> None:
    findings = read(tmp_path, robots.MATCH)
    directions = {message.name: message.direction for message in findings.messages}
    assert directions == {"Command": "heard", "Taken": "heard", "ModeChanged": "said"}
    command = findings.heard[0]
    assert [value.text for value in command.fields[0].values] == ["fetch", "abort"]
    assert command.fields[0].by_type
    assert str(command.place) == "robot_code.py:16"
    assert findings.state == "mode_changed.mode"


def test_values_are_followed_through_parameters_tables_and_loops() -> None:
    findings = analyse("carebot", ROOT / "examples" / "home_care")
    values = {f"{m.topic}.{f.name}": {v.text for v in f.values} for m in findings.messages for f in m.fields}
    assert values["order.kind"] == {"fridge", "sink", "feed", "clean", "ended"}
    states = "Ready Off Fridge Sink Grab Human Drop Recharge Charging"
    assert values["state.name"] == set(states.split())
    assert {message.name for message in findings.said} == {
        "State", "Accepted", "Refused", "Completed", "Idle", "Docked", "Food",
    }  # fmt: skip


def test_the_entry_and_its_ports_are_found(tmp_path: Path) -> None:
    entry = read(tmp_path, robots.CHAIN).entry
    assert entry is not None
    assert (entry.name, entry.method, entry.certainty) == ("Rover", "run", "certain")
    roles = {port.name: (port.role, port.direction) for port in entry.ports}
    assert roles == {"commands": ("queue", "heard"), "reports": ("queue", "said"), "motors": ("device", "")}
    operations = {operation.name: operation.returns for operation in entry.ports[2].operations}
    assert operations == {"drive": "", "bumped": "bool", "turn": ""}


def test_how_it_waits_and_its_numbers_have_their_places(tmp_path: Path) -> None:
    findings = read(tmp_path, robots.MATCH)
    assert findings.virtual == ("time",)
    assert [(wait.call, wait.seconds) for wait in findings.waits if wait.kind == "time"] == [
        ("time.sleep", 1.0), ("time.sleep", 2.0),
    ]  # fmt: skip
    assert [(constant.name, constant.value, constant.unit) for constant in findings.constants] == [
        ("OFFER_S", 5.0, "s")
    ]


def test_nothing_is_imported_or_run(tmp_path: Path) -> None:
    source = (
        f"open({str(tmp_path / 'effect')!r}, 'w').write('x')\nimport RPi.GPIO as GPIO\nGPIO.setup(4, 1)\n"
        + robots.MATCH
    )
    findings = read(tmp_path, source)
    assert not (tmp_path / "effect").exists()
    said = {(problem.kind, str(problem.place)) for problem in findings.problems}
    assert said == {
        ("side effect", "robot_code.py:1"), ("hardware", "robot_code.py:2"), ("side effect", "robot_code.py:3"),
    }  # fmt: skip
    assert findings.heard


def test_a_file_with_a_syntax_error_is_said_and_the_rest_is_read(tmp_path: Path) -> None:
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "__init__.py").write_text("", encoding="utf-8")
    (tmp_path / "pack" / "broken.py").write_text("def f(:\n", encoding="utf-8")
    (tmp_path / "pack" / "robot.py").write_text(robots.MATCH, encoding="utf-8")
    findings = analyse("pack", tmp_path)
    assert [str(problem.place) for problem in findings.problems] == ["pack/broken.py:1"]
    assert len(findings.messages) == 3


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


@pytest.mark.slow
def test_transitions_that_a_function_computes_are_those_that_it_returns() -> None:
    findings = with_transitions(analyse("carebot", ROOT / "examples" / "home_care"))
    machine = findings.machines[0]
    assert {"Ready>Fridge", "Fridge>Grab", "Recharge>Charging", "Ready>Off"} <= moves(machine)
    assert len(machine.transitions) == 17
    assert {move.how for move in machine.transitions} == {"run"}


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


def test_transitions_have_the_order_of_the_code(tmp_path: Path) -> None:
    machine = read(tmp_path, robots.MATCH).machines[0]
    assert [move.place for move in machine.transitions] == sorted(move.place for move in machine.transitions)


GIVES_UP = """
import time
from dataclasses import dataclass, field

BAYS = {1: (2.0, 0.0), 2: (2.0, 3.0), 3: (-1.0, 4.0)}


@dataclass
class Config:
    tray: dict = field(default_factory=lambda: {"bolt": 1, "nut": 2})


@dataclass
class Job:
    bay: int
    part: str


@dataclass
class Status:
    phase: str
    detail: str = ""


def run(bus, config: Config):
    jobs = bus.subscribe(Job)
    begin = time.monotonic()
    deadline = time.time() + 5.0
    while time.time() < deadline:
        job = jobs.get()
        where = BAYS[job.bay]
        known = job.part in config.tray
        bus.publish(Status("parked" if known else "lost", "unknown" if known else "late"))
        now = time.monotonic()
        if now - begin > 40.0:
            bus.publish(Status("off"))
"""


def test_times_after_which_the_code_gives_up_and_what_is_looked_up_in_tables(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(GIVES_UP, encoding="utf-8")
    findings = analyse("robot_code", tmp_path)
    assert {(wait.call, wait.seconds) for wait in findings.waits if wait.kind == "time-out"} == {
        ("time.time() + 5.0", 5.0), ("now - begin", 40.0),
    }  # fmt: skip
    bay, part = next(message for message in findings.messages if message.name == "Job").fields
    assert bay.compared == (1.0, 2.0, 3.0)
    assert [value.text for value in part.values] == ["bolt", "nut"]
    asked = [question.text for question in findings.questions if question.about == "transitions"]
    assert asked == ["Which state of `Status` follows which?"]  # its detail is no second machine of states
    assert findings.state == "status.phase"
