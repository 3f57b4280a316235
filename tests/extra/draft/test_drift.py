"""What code has that its testbench lacks is told; what testbench and tests have is not."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.drift import Drift, drifts, models_of
from pytest_hricdv.extra.draft.feature import FEATURE
from pytest_hricdv.session.option import OptionReader
from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Run, StateField, Testbench
from tests.docs.page import blocks, write_files

CODE = """
from dataclasses import dataclass
from typing import Literal, cast
from transitions import Machine
SLOW_S = 2.0


@dataclass(frozen=True)
class Call:
    floor: int


@dataclass(frozen=True)
class State:
    name: Literal["Idle", "Moving", "Stuck"]


@dataclass(frozen=True)
class Alarm:
    why: str


TRANSITIONS = [("called", "Idle", "Moving"), ("there", "Moving", "Idle"), ("blocked", "Moving", "Stuck")]


class Lift:
    def __init__(self, bus, patience_s: float = 5.0):
        self._bus, self._patience_s = bus, patience_s; Machine(self, ["Idle", "Moving", "Stuck"], "Idle", TRANSITIONS)
        self._calls = bus.subscribe(Call)

    def serve(self):
        while self._calls.wait(self._patience_s) is not None:
            self._bus.publish(State("Moving"))
            self._bus.publish(Alarm("blocked"))
            self._bus.publish(State("Idle"))
"""


@dataclass(frozen=True)
class Call:
    """A person called the lift."""

    floor: int


@dataclass(frozen=True)
class State:
    """The lift's state."""

    name: Literal["Idle", "Moving", "Stuck"]


@dataclass(frozen=True)
class Alarm:
    """Something is wrong."""

    why: str


def _run(run: Run) -> Outcome:
    return Outcome("nothing")


def bench(folder: Path, *messages: type) -> Testbench:
    (folder / "lift.mas2j").write_text("MAS lift { agents: meta; human; }", encoding="utf-8")
    return Testbench(
        name="lift",
        model=Model(folder / "lift.mas2j"),
        beliefs=BeliefSpace(start=("a",), groups={}),
        concretization=Concretization({"call": {}}),
        requirements=folder / "requirements.toml",
        messages=messages,
        signals={},
        code=("lift",),
        run=_run,
        state=StateField("state.name", (("Idle", "Moving"), ("Moving", "Idle"), ("Stuck", "Idle"))),
    )


@pytest.fixture
def of_lift(tmp_path: Path) -> list[Drift]:
    (tmp_path / "lift.py").write_text(CODE, encoding="utf-8")
    model, problems = models_of(["lift"], [tmp_path])
    assert problems == []
    return drifts(model, bench(tmp_path, Call, State))


def test_a_new_message_is_told(of_lift: list[Drift]) -> None:
    keys = [drift.key for drift in of_lift]
    assert "message alarm" in keys
    assert not [key for key in keys if key in ("message call", "message state")]
    [message] = [drift for drift in of_lift if drift.kind == "message"]
    assert message.text == "the code publishes Alarm, which is not a message of the testbench"
    assert message.location.startswith("lift.py:")


def test_transitions_are_compared_both_ways(of_lift: list[Drift]) -> None:
    keys = [drift.key for drift in of_lift]
    assert "transition Moving->Stuck" in keys
    assert "gone Stuck->Idle" in keys
    assert "transition Idle->Moving" not in keys


def test_what_the_testbench_has_is_no_drift(tmp_path: Path) -> None:
    (tmp_path / "lift.py").write_text(CODE, encoding="utf-8")
    model, _ = models_of(["lift"], [tmp_path])
    made = drifts(model, bench(tmp_path, Call, State, Alarm))
    assert {drift.kind for drift in made} == {"transition", "gone"}


def test_a_package_that_is_not_there_is_said(tmp_path: Path) -> None:
    model, problems = models_of(["nowhere"], [tmp_path])
    assert model == []
    assert len(problems) == 1
    assert "nowhere" in problems[0]


def test_a_folder_that_is_not_there_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["update", str(tmp_path / "arm")]) == 2
    assert f"error: {tmp_path / 'arm'}: no such folder" in capsys.readouterr().err


@pytest.mark.slow
def test_the_vacuum_robot_says_something_new(tmp_path: Path) -> None:
    write_files(blocks("vacuum.md"), tmp_path)
    code = tmp_path / "vacuum.py"
    stuck = '@dataclass(frozen=True)\nclass Stuck:\n    """It cannot go on."""\n\n\nclass Vacuum:'
    says = "self._bus.publish(Docked())\n            else:\n                self._bus.publish(Stuck())"
    text = code.read_text(encoding="utf-8").replace("class Vacuum:", stuck)
    text = text.replace("self._bus.publish(Docked())", says)
    code.write_text(text, encoding="utf-8")

    command = [sys.executable, "-m", "pytest_hricdv", "update", str(tmp_path)]
    first = subprocess.run(command, capture_output=True, text=True, check=False)
    assert first.returncode == 1, first.stdout + first.stderr
    assert "the code publishes Stuck, which is not a message of the testbench  [message stuck]" in first.stdout
    with (tmp_path / "pytest.ini").open("a", encoding="utf-8") as file:
        file.write("hri_known_drift =\n    message stuck: of the next release\n    message bell: never\n")
    second = subprocess.run(command, capture_output=True, text=True, check=False)
    assert second.returncode == 0, second.stdout + second.stderr
    assert "known: message stuck" in second.stdout
    assert "hri_known_drift has 'message bell', which no longer exists" in second.stdout


def test_known_drift_of_no_kind_is_refused() -> None:
    class Reader:
        def texts(self, name: str) -> tuple[str, ...]:
            return ("settle_s: why",)

    with pytest.raises(
        pytest.UsageError, match="expected 'KIND NAME: reason', as 'message alarm: of the next release'"
    ):
        FEATURE.read(cast("OptionReader", Reader()))
