from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.bdi.__main__ import main as bdi
from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files, write
from pytest_hricdv.extra.draft.project.requirements import requirement_ids
from tests.extra.draft import robots


def drafted(tmp_path: Path, source: str) -> tuple[Draft, dict[str, str]]:
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    draft = Draft(analyse("robot_code", tmp_path), "robot_code", "person", tmp_path.resolve())
    return draft, dict(files(draft))


def test_the_linter_finds_nothing_in_a_drafted_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, texts = drafted(tmp_path, robots.MATCH)
    for file, text in texts.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(text, encoding="utf-8")
    assert bdi(["lint", str(tmp_path / "models" / "robot_code.mas2j")]) == 0
    assert "nothing found" in capsys.readouterr().err


def test_what_is_in_a_draft_has_the_place_that_it_comes_from(tmp_path: Path) -> None:
    _, texts = drafted(tmp_path, robots.MATCH)
    conftest = texts["conftest.py"]
    assert 'Say(Command, kind="fetch"),  # robot_code.py:17' in conftest
    assert '"command_lost": Drop("command")' in conftest
    for manner in ("in_time", "too_early", "too_late", "twice", "never"):
        assert f"@command_{manner} " in texts["models/person.asl"]
    assert "`gripper.close`" in texts["QUESTIONS.md"]


def test_a_file_that_exists_is_not_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robot_code.py").write_text(robots.MATCH, encoding="utf-8")
    (tmp_path / "drafted_messages.py").write_text("mine", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "--from", "robot_code", "--no-run"]) == 2
    assert "drafted_messages.py exists: nothing was written" in capsys.readouterr().err
    assert not (tmp_path / "conftest.py").exists()


def test_states_that_the_code_publishes_are_covered_and_no_disturbance_takes_one_away(tmp_path: Path) -> None:
    """The robot seemed to go from the state before to the one after, which a requirement forbids."""
    draft, texts = drafted(tmp_path, robots.TRANSITIONS)
    conftest = texts["conftest.py"]
    assert draft.code.state == "status.state"
    assert '    "moving",  # robot_code.py:' in conftest
    assert '            ("idle", "moving"),  # robot_code.py:' in conftest
    assert 'cross={"state and manner": CrossProduct({"state": STATES, "manner": tuple(TIMES)})}' in conftest
    assert "@be_open +!be_open" in texts["models/robot.asl"]
    assert "status_lost" not in conftest
    assert conftest.count(": Drop(") == len(draft.code.messages) - 1


ENDS = """
import time
from dataclasses import dataclass
from queue import Queue


@dataclass(frozen=True)
class Order:
    what: str


@dataclass(frozen=True)
class Answer:
    text: str


def work(orders: "Queue[Order]", answers: "Queue[Answer]") -> None:
    order = orders.get()
    if order.what == "fetch":
        answers.put(Answer("here it is"))
    elif order.what == "leave":
        time.sleep(0.1)
"""


def test_nobody_speaks_to_a_robot_that_has_ended_while_a_deadline_is_open(tmp_path: Path) -> None:
    """An order that is not answered keeps the run going: what was said to nobody counted as not answered, too."""
    (tmp_path / "robot_code.py").write_text(ENDS, encoding="utf-8")
    init = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code", "--no-run"]
    subprocess.run(init, cwd=tmp_path, capture_output=True, check=True)
    said = ("order_leave in_time", "order_fetch in_time", "order_leave twice")
    (tmp_path / "draft" / "ends.txt").write_text("\n".join(said) + "\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "--hri-suite=ends.txt", "--hri-audit=off", "--hri-diagnose=0"]
    subprocess.run(command, cwd=tmp_path / "draft", capture_output=True, check=False)  # an order is not answered
    report = json.loads((tmp_path / "draft" / "hri-report" / "report.json").read_text(encoding="utf-8"))
    (test,) = report["tests"]
    assert test["end_reason"] == "the robot has ended its work"
    assert test["sim_s"] > 60.0  # the first order's deadline was open until then
    assert sum("\torder\t" in line for line in test["timeline"]["messages"]) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "counted"),
    [
        ("MATCH", "2 messages received, "),
    ],
)
def test_a_draft_is_green_at_once_and_covers_the_code(name: str, counted: str, tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(getattr(robots, name), encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert counted in made.stdout
    command = [sys.executable, "-m", "pytest", "-q", "--hri-audit=off"]
    done = subprocess.run(command, cwd=tmp_path / "draft", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert re.search(r"^PASSED  \d\d passed ", done.stdout, re.MULTILINE)


def test_a_requirement_is_left_where_none_held_in_the_first_runs(tmp_path: Path) -> None:
    draft, texts = drafted(tmp_path, robots.MATCH)
    names = requirement_ids(draft)
    dropped = replace(draft, dropped=tuple(names), has_dropped_all=True)
    left = tomllib.loads(dict(files(dropped))["requirements.toml"])
    assert len(tomllib.loads(texts["requirements.toml"])) == len(names)
    assert [requirement["title"] for requirement in left.values()] == ["A visit ends within 900 s"]


REASONS = """
from dataclasses import dataclass

LATE = "too late"


@dataclass(frozen=True)
class Order:
    kind: str


@dataclass(frozen=True)
class Refused:
    reason: str
    told_by: str


def _reason_against(problem):
    return str(problem)


class Desk:
    def __init__(self, bus):
        self.bus = bus
        self.orders = bus.subscribe(Order)

    def _reason_against(self, order):
        return "unknown" if order.kind != "tea" else ""

    def run(self):
        while (order := self.orders.wait(60.0)) is not None:
            reason = self._reason_against(order)
            if reason:
                self.bus.publish(Refused(reason, "desk"))
            try:
                self.make(order)
            except OSError as problem:
                self.bus.publish(Refused(_reason_against(problem), "kitchen"))
            except ValueError:
                self.bus.publish(Refused(LATE, "kitchen"))
"""


def test_a_field_that_is_also_made_of_unknown_texts_is_not_declared_with_those_that_are_known(tmp_path: Path) -> None:
    (tmp_path / "desk.py").write_text(REASONS, encoding="utf-8")
    text = dict(files(Draft(analyse("desk", tmp_path), "desk", "person", tmp_path / "hri")))["conftest.py"]
    assert '# "refused.reason": Field(values=("unknown", "too late")),  # desk.py:28; TODO: which others?' in text
    assert '            "refused.told_by": Field(values=("desk", "kitchen")),' in text


def test_a_draft_of_long_names_is_sorted_as_ruff_sorts(tmp_path: Path) -> None:
    names = [f"MessageOfTheRobotNumber{number}" for number in range(6)]
    classes = "\n\n".join(f"@dataclass(frozen=True)\nclass {name}:\n    level: float" for name in names)
    said = "\n".join(f"        bus.publish({name}(1.0))" for name in names[1:])
    robot = f"def run(bus):\n    heard = bus.subscribe({names[0]})\n    while heard.wait(1.0):\n{said}\n"
    source = f"from dataclasses import dataclass\n\n\n{classes}\n\n\n{robot}"
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    folder = tmp_path.resolve() / "hri"
    write(Draft(analyse("robot_code", tmp_path), "robot_code", "person", folder), folder)
    assert "import (\n        MessageOfTheRobotNumber0,\n" in (folder / "conftest.py").read_text(encoding="utf-8")
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "I,F", "."]
    checked = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout
