from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.code_model import Message
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.observe.observations import read_observations
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.record import record
from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.driver import ActiveRobot, Driver
from pytest_hricdv.extra.draft.stand_ins.parts import Device, cross_border
from pytest_hricdv.extra.draft.stand_ins.visit import Visit
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from tests.extra.draft import appliances


def coffee(folder: Path) -> Path:
    """The package of the coffee maker, with its demo."""
    (folder / "coffee").mkdir()
    (folder / "coffee" / "__init__.py").write_text("", encoding="utf-8")
    (folder / "coffee" / "robot.py").write_text(appliances.COFFEE, encoding="utf-8")
    (folder / "coffee" / "demo.py").write_text(appliances.DEMO, encoding="utf-8")
    return folder


def module(folder: Path, source: str) -> tuple[dict[str, Message], str]:
    """The messages of a module that are received, by their topics, and its testbench."""
    (folder / "robot_code.py").write_text(source, encoding="utf-8")
    model = CodeReader("robot_code", folder).model()
    draft = Draft(model, "robot_code", "person", folder.resolve() / "hri")
    return {message.topic: message for message in model.inputs}, dict(files(draft))["conftest.py"]


def texts(message: Message, field: str) -> list[str]:
    return [value.text for part in message.fields if part.name == field for value in part.values]


def test_methods_and_callbacks_are_what_people_do(tmp_path: Path) -> None:
    model = CodeReader("coffee", coffee(tmp_path)).model()
    inputs = {message.topic: message for message in model.inputs}
    assert set(inputs) == {"press", "fault"}  # neither the getter nor the control loop nor what is private
    assert texts(inputs["press"], "button") == ["start", "stop", "reset"]
    assert inputs["fault"].delivery == "MethodCall('_pump_fault', lambda m: (m.code,))"
    assert model.entry is not None
    assert (model.entry.name, model.entry.method, model.entry.period_s) == ("CoffeeMaker", "tick", 0.1)
    assert model.state == "state_changed.state"
    assert model.machine is not None
    assert {state.name for state in model.machine.states} == {"idle", "brewing", "error"}


def test_what_the_code_compares_of_a_device_is_set_by_a_person(tmp_path: Path) -> None:
    model = CodeReader("coffee", coffee(tmp_path)).model()
    draft = Draft(model, "coffee", "person", tmp_path / "hri")
    (sensor,) = draft.sensors
    assert (sensor.name, sensor.field.kind, sensor.field.compared) == ("tank_level_ml", "float", (100.0,))
    told = [message.channel for message in model.outputs if message.form == "called"]
    assert told == ["pump.on", "pump.off", "display.show"]  # to hand over a callback is no output


def test_dicts_and_json_are_messages_with_their_keys(tmp_path: Path) -> None:
    inputs, conftest = module(tmp_path, appliances.GUIDE)
    tour, message = inputs["tour"], inputs["on_message"]
    assert [(part.name, part.type) for part in tour.fields] == [("minutes", "int")]  # as its default is
    assert "Home: lambda m: {'kind': 'home'}" in conftest  # which has no minutes
    assert "Tour: lambda m: {'kind': 'tour', 'minutes': m.minutes}" in conftest
    assert texts(message, "topic") == ["museum/stop"]
    assert texts(message, "who") == ["guard"]
    assert "Neutral(topic=m.topic, payload=json.dumps({'who': m.who}).encode())" in conftest


WATCHER = """
class Watcher:
    def __init__(self, door, lamp):
        self.door, self.lamp = door, lamp

    def tick(self):
        if self.door.is_open():
            self.lamp.on()


def main(door, lamp):
    watcher = Watcher(door, lamp)
    while True:
        watcher.tick()
"""


def test_each_command_of_who_only_sets_sensors_is_declared(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(WATCHER, encoding="utf-8")
    model = CodeReader("robot_code:Watcher", tmp_path).model()
    texts = dict(files(Draft(model, "watcher", "person", tmp_path / "hri")))
    assert "set_door_is_open(yes)" in texts["models/person.asl"]
    assert "wait_quiet" in texts["models/person.asl"]
    assert '"wait_quiet": {},' in texts["conftest.py"]


def run_session(folder: Path, *options: str) -> dict[str, object]:
    """A session of a project, and its report."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--hri-audit=off", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    report = folder / "hri-report" / "report.json"
    assert report.exists(), done.stdout + done.stderr
    content: dict[str, object] = json.loads(report.read_text(encoding="utf-8"))
    return content | {"status": done.returncode, "text": done.stdout}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["COFFEE", "GUIDE"])
def test_a_draft_of_code_without_messages_passes_and_reaches_it(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "COFFEE":
        package = coffee(tmp_path).name and "coffee"
    else:
        package = "robot_code"
        (tmp_path / "robot_code.py").write_text(getattr(appliances, name), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", "--from", package, "--budget", "16"]) == 0
    report = run_session(tmp_path / "hri")
    assert report["status"] == 0, report["text"]
    (shares,) = [file for file in report["code_under_test"]["files"]  # type: ignore[index]
                 if file["file"].endswith(("robot.py", "robot_code.py"))]  # fmt: skip
    assert shares["covered"] >= 0.75 * shares["statements"]


@pytest.mark.slow
def test_a_draft_of_code_that_cannot_be_imported_runs_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robot_code.py").write_text(
        "raise SystemExit(3)\n\n\nclass Arm:\n    def go(self, to: str):\n        self.at = to\n"
    )
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", "--from", "robot_code", "--budget", "10"]) == 0
    report = run_session(tmp_path / "hri")
    assert {test["outcome"] for test in report["tests"]} == {"passed"}  # type: ignore[attr-defined]
    assert report["status"] == 0 or "nothing that people" in str(report["text"])  # no more is known of it
    assert "SystemExit: 3" in (tmp_path / "hri" / "QUESTIONS.md").read_text(encoding="utf-8")


# --- recordings


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What crosses the border of the coffee maker in its demo."""
    folder = coffee(tmp_path_factory.mktemp("recorded"))
    before = Path.cwd()
    os.chdir(folder)
    try:
        lines = list(record("coffee", ["python", "-m", "coffee.demo"], folder / "seen.json", 60.0))
    finally:
        os.chdir(before)
    assert "status 0" in lines[1]
    return folder / "seen.json"


def test_a_recording_has_calls_across_the_border(recording: Path) -> None:
    seen = read_observations(recording)
    maker = "coffee.robot:CoffeeMaker"
    assert set(seen.methods) == {f"{maker}.{name}" for name in ("press", "tick", "_pump_fault")}
    assert seen.methods[f"{maker}.tick"].count == 60
    assert seen.methods[f"{maker}.press"].arguments["button"].texts == {"start": 2, "reset": 1}
    level = seen.calls["CoffeeMaker.tank.level_ml"].result
    assert (level.low, level.high) == (50.0, 500.0)
    assert seen.states[f"{maker}.mode"] == {"idle": 1, "idle -> brewing": 1, "brewing -> idle": 1, "idle -> error": 1,
                                            "error -> idle": 1}  # fmt: skip
    assert seen.calls["CoffeeMaker.display.show"].arguments["password"].texts == {"***": 2}
    assert "5678" not in recording.read_text(encoding="utf-8")  # of an attribute


def test_a_recording_has_no_result_of_what_is_named_as_a_secret(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "vault.py").write_text("def get_token():\n    return 'x-9012'\n\n\ndef name():\n    return 'front'\n")
    monkeypatch.chdir(tmp_path)
    program = ["python", "-c", "import vault; vault.get_token(); vault.name()"]
    assert "status 0" in list(record("vault", program, tmp_path / "seen.json", 60.0))[1]
    seen = read_observations(tmp_path / "seen.json").methods
    assert (seen["vault:get_token"].result.texts, seen["vault:name"].result.texts) == ({"***": 1}, {"front": 1})


def test_a_recording_of_another_package_is_refused(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robot_code.py").write_text("class Arm:\n    def go(self, to: str):\n        self.at = to\n")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", "--from", "robot_code", "--recording", str(recording), "--no-run"]) == 2
    assert "--recording: it is of coffee, and has nothing of robot_code" in capsys.readouterr().err


def test_a_draft_has_what_a_recording_has_seen(recording: Path, tmp_path: Path) -> None:
    folder = coffee(tmp_path)
    (folder / "coffee" / "demo.py").unlink()  # nothing but the recording tells what is called in a loop
    model = CodeReader("coffee", folder).model(read_observations(recording))
    draft = Draft(model, "coffee", "person", tmp_path / "hri")
    assert model.entry is not None
    assert (model.entry.method, model.entry.period_s) == ("tick", 0.1)
    (fault,) = [message for message in model.inputs if message.topic == "fault"]
    assert fault.fields[0].observed == (3.0, 3.0)
    assert draft.sensors[0].field.compared == (100.0,)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("{}", "expected version 2 of a recording of `hricdv record`"),
        ('{"format": "hricdv-recording", "version": 2}', "the file lacks 'states'"),
        ('{"format": ', "Expecting value"),
        (
            '{"format": "hricdv-recording", "version": 2, "states": {}, "made": {}, "calls": {}, "methods": {"p:f": '
            '{"count": 1, "location": "", "result": {}, "arguments": {"x": {"count": 1, "kinds": {}, "high": 1'
            + "0" * 400
            + "}}}}}",
            "expected numbers of a recording of `hricdv record`: int too large",
        ),
    ],
)
def test_a_file_that_is_no_recording_is_one_sentence(
    content: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (coffee(tmp_path) / "seen.json").write_text(content, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", "--from", "coffee", "--recording", "seen.json"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: init: --recording=seen.json: ")
    assert sentence in line
    assert not (tmp_path / "hri").exists()


def test_a_program_that_does_not_use_the_package_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(coffee(tmp_path))
    assert main(["record", "--package", "coffee", "--", "python", "-c", "print(1)"]) == 2
    assert "made no call from outside into coffee" in capsys.readouterr().err
    assert main(["record", "--package", "coffee", "--"]) == 2
    assert "expected a program" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("program", "status", "said"),
    [
        ("raise SystemExit(3)", 1, "the program ended with status 3: the recording has what"),
        ("open('began', 'w'); vault.wait()", 0, "the program was stopped: the recording has what it did until then"),
    ],
)
def test_a_recording_says_that_the_program_failed_or_was_stopped(
    program: str, status: int, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    code = "import threading\n\n\ndef name():\n    return 'front'\n\n\ndef wait():\n    threading.Event().wait()\n"
    (tmp_path / "vault.py").write_text(code)
    monkeypatch.chdir(tmp_path)
    real_wait = subprocess.Popen.wait

    def wait(process: subprocess.Popen[bytes], timeout: float | None = None) -> int:
        """The time limit is over once the program waits, however long its start took."""
        while timeout == 60.0 and not Path("began").exists():
            with suppress(subprocess.TimeoutExpired):
                return real_wait(process, 0.05)
        return real_wait(process, 0.05 if timeout == 60.0 else timeout)

    monkeypatch.setattr(subprocess.Popen, "wait", wait)
    command = ["record", "--package", "vault", "--timeout", "60", "--", "python", "-c"]
    assert main([*command, f"import vault; vault.name(); {program}"]) == status
    assert said in capsys.readouterr().out
    assert "vault:name" in read_observations(tmp_path / "hricdv-recording.json").methods


def test_a_forked_process_records_its_own_calls_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "vault.py").write_text("def store(number):\n    pass\n")
    monkeypatch.chdir(tmp_path)
    program = "import os, vault; vault.store(10**400); os.fork() and os.wait(); vault.store(1)"
    assert main(["record", "--package", "vault", "--", "python", "-c", program]) == 0
    (store,) = read_observations(tmp_path / "hricdv-recording.json").methods.values()
    assert (store.count, store.arguments["number"].high) == (3, 1.0)


def test_a_list_of_a_stand_in_has_all_that_has_come_since() -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [Pressed], recorder)
    run: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    border = RunBorder(run, frozenset({Pressed}), {}, {})
    made = Device(inboxes={"presses": {Pressed: lambda m: m.button}}).make(border, "inputs")
    with cross_border(border):
        assert made.presses == []
        for button in ("start", "stop"):
            bus.publish("person", Pressed(button))
        assert made.presses == ["start", "stop"]
        assert made.presses == []


def test_what_comes_between_two_steps_of_a_loop_is_for_the_next_one() -> None:
    got: list[str] = []

    class Loop:
        def update(self, inputs: Any) -> None:
            got.extend(inputs.presses)

    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [Pressed], recorder)
    run: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    border = RunBorder(run, frozenset({Pressed}), {}, {})
    port = Device(inboxes={"presses": {Pressed: lambda m: m.button}})
    driver = Driver(Loop, method="update", method_ports={"inputs": port}, period_s=0.1)

    def press() -> None:
        kernel.sleep(0.25)
        bus.publish("person", Pressed("start"))

    visit = Visit(run, {}, lambda say, numbers: None, (), (), driver.manners)
    kernel.spawn("robot", ActiveRobot(driver, border, visit).work)
    kernel.spawn("person", press)
    with cross_border(border):
        kernel.run(1.0)
    assert got == ["start"]


@dataclass(frozen=True)
class Pressed:
    button: str


def test_an_enumeration_that_any_object_holds_is_declared_without_a_field(tmp_path: Path) -> None:
    source = """
from enum import Enum


class Phase(Enum):
    WAITING = 1
    DONE = 2


class Job:
    def __init__(self):
        self.phase = Phase.WAITING

    def finish(self):
        self.phase = Phase.DONE


class Robot:
    def __init__(self, jobs):
        self._jobs = jobs

    def take(self, name: str):
        self._jobs.append(Job())
        self._jobs[0].finish()
"""
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    model = CodeReader("robot_code:Robot", tmp_path).model()
    draft = Draft(model, "robot_code", "person", tmp_path.resolve() / "hri")
    assert (draft.states, draft.code.state) == (("WAITING", "DONE"), "")
    assert "@be_waiting +!be_waiting <- enter(waiting)." in dict(files(draft))["models/robot.asl"]
