"""What first runs show of code that its source does not say: sensors, topics of brokers, connections, states."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.observe.observations import Observations, Site, read_observations
from pytest_hricdv.extra.draft.observe.tracer import state_text, texts_of
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.record import record
from pytest_hricdv.extra.draft.stand_ins.border import OBSERVE, RunBorder
from pytest_hricdv.extra.draft.stand_ins.connections import ConnectionPort
from pytest_hricdv.extra.draft.stand_ins.parts import Device, cross_border
from pytest_hricdv.runtime import Bus, Kernel, Recorder

GATE = """
class Gate:
    def __init__(self, driver, hall):
        self._driver, self._hall = driver, hall

    def press(self):
        name, most = "is_blocked", len("abc")
        if not getattr(self._driver, name)() and self._hall.visitors(2) < most:
            self._driver.move("open")
"""

DESK = """
import asyncio

STATIONS = ("desk", "lab")


class Runner:
    def __init__(self, port=9099):
        self.port = port
        self.place = "desk"
        self.clients = []

    async def run(self):
        server = await asyncio.start_server(self._client, "localhost", self.port)
        async with server:
            await server.serve_forever()

    async def _client(self, reader, writer):
        while line := await reader.readline():
            writer.write(self._command(line.decode().strip()).encode())

    def _command(self, text: str) -> str:
        verb, *words = text.split()
        if verb == "GO":
            if words[0] not in STATIONS:
                return "ERR"
            self._enter("lab")
            return "OK"
        if verb == "PAUSE":
            self._enter("desk")
            return "OK"
        return "ERR"

    def _enter(self, place):
        self.place = place
"""

LIFT = """
class State:
    name = "?"

    def __init__(self, lift: "Lift"):
        self.lift = lift

    def call(self):
        pass


class Parked(State):
    name = "parked"

    def call(self):
        self.lift.travel(0.1)
        self.lift.motor.drive("call")
        self.lift.change(Moving)


class Moving(State):
    pass


class Lift:
    def __init__(self, motor):
        self.motor = motor
        self.position_m = 0.0
        self.state = Parked(self)

    def change(self, kind: type[State]):
        self.state = kind(self)

    def call(self):
        self.state.call()

    def travel(self, metres):
        self.position_m += metres
"""


@dataclass(frozen=True)
class Order:
    text: str


@dataclass(frozen=True)
class Told:
    text: str


def run(body: Callable[[RunBorder], None], called: dict[str, type[Any]]) -> list[Told]:
    """What is told while a node works at a border."""
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [Order, Told], recorder)
    made: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    border, heard = RunBorder(made, frozenset(), called, {}), bus.subscribe(Told)
    kernel.spawn("robot", lambda: body(border))
    with cross_border(border):
        kernel.run(60.0)
    border.close()
    return list(iter(heard.poll, None))


def read(tmp_path: Path, source: str, seen: Observations | None = None) -> CodeModel:
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    return CodeReader("robot_code", tmp_path).model(seen)


def observe(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, body: Callable[[RunBorder], None]) -> Observations:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    run(body, {})
    return read_observations(tmp_path / "seen.json")


def test_an_answer_that_the_code_tests_or_compares_is_a_sensor_of_the_next_draft(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def body(border: RunBorder) -> None:
        driver, hall = Device().make(border, "driver"), Device().make(border, "hall")
        assert not driver.is_blocked()
        assert hall.visitors(2) < 3
        assert driver.move("open") is not None  # nobody looks at what it returns

    seen = observe(monkeypatch, tmp_path, body)
    draft = Draft(read(tmp_path, GATE, seen), "gate", "person", tmp_path.resolve() / "hri")
    sensors = {sensor.name: sensor for sensor in draft.sensors}
    assert {name: sensor.field.kind for name, sensor in sensors.items()} == {
        "driver_is_blocked": "bool",
        "hall_visitors": "float",
    }
    assert sensors["hall_visitors"].levels == (
        ("high_value", "Uniform(3.75, 6)"),
        ("low_value", "Uniform(0, 2.25)"),
        ("at_3_value", "Uniform(3, 3)"),
    )
    assert [message.channel for message in draft.code.outputs] == ["driver.move"]


HOST = """
class Host:
    def __init__(self, camera, gain):
        self.camera, self.gain = camera, gain

    def step(self):
        person = self.camera.nearest()
        if person and person.distance < 2.5:
            self.camera.greet(self.gain * 2)
"""


def test_the_parts_of_an_answer_are_sensors_and_the_answer_has_them(tmp_path: Path) -> None:
    draft = Draft(read(tmp_path, HOST), "host", "person", tmp_path.resolve() / "hri")
    assert [(sensor.name, sensor.field.kind) for sensor in draft.sensors] == [("camera_nearest.distance", "float")]

    def body(border: RunBorder) -> None:
        camera = Device(senses=("nearest()", "nearest().distance")).make(border, "camera")
        border.senses |= {"camera.nearest()": True, "camera.nearest().distance": 1.5}
        person = camera.nearest()
        assert person
        assert person.distance < 2.5
        border.senses["camera.nearest()"] = False
        assert not camera.nearest()

    run(body, {})


def test_an_attribute_that_the_code_tests_is_read_and_not_called(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def body(border: RunBorder) -> None:
        assert not Device().make(border, "driver").is_down

    seen = observe(monkeypatch, tmp_path, body)
    model = read(tmp_path, GATE, seen)
    assert model.entry is not None
    down = {each.name: each for port in model.entry.ports for each in port.operations}["is_down"]
    assert (down.is_method, down.result is not None and down.result.kind) == (False, "bool")


def test_the_first_text_for_a_broker_with_functions_of_the_code_is_a_topic() -> None:
    def body(border: RunBorder) -> None:
        broker, lamp = Device().make(border, "broker"), Device().make(border, "lamp")
        broker.on("order", lambda payload: None)
        broker.send("done", text="tea")
        broker.send("other", text="?")
        lamp.show("red")

    assert run(body, {"broker.send done": Told, "lamp.show": Told}) == [Told("tea"), Told("red")]


def test_a_socket_has_a_person_at_the_other_end() -> None:
    heard: list[object] = []

    def body(border: RunBorder) -> None:
        border.run.kernel.spawn("person", lambda: border.run.bus.port("person").publish(Order("tea")))
        server: Any = ConnectionPort(kinds={Order: lambda m: m.text}).make(border, "server")
        server.bind(("localhost", 1))
        connection, _ = server.accept()
        heard.append(connection.makefile().readline())
        connection.settimeout(2.0)
        with pytest.raises(socket.timeout):
            connection.recv(10)
        heard.append(border.run.kernel.now_s)
        connection.sendall(b"ready")

    assert run(body, {"server.sendall": Told}) == [Told("ready")]
    assert heard == [b"tea\n", 2.0]


def test_commands_of_a_line_are_messages_and_setters_are_none(tmp_path: Path) -> None:
    model = read(tmp_path, DESK)
    delivered = {message.topic: message.delivery for message in model.inputs}
    assert delivered == {
        "go": "MethodCall('_command', lambda m: ('GO' + ' ' + m.words,))",
        "pause": "MethodCall('_command', lambda m: ('PAUSE',))",
    }
    conftest = dict(files(Draft(model, "desk", "person", tmp_path.resolve() / "hri")))["conftest.py"]
    assert 'Replace("robot_code:asyncio.start_server", ConnectionPort("start_server"))' in conftest


def test_objects_are_states(tmp_path: Path) -> None:
    steps = {"parked": 1, "parked -> Moving": 1, "Moving -> parked": 1}
    model = read(tmp_path, LIFT, Observations(states={"robot_code:Lift.state": steps}))
    assert model.machine is not None
    assert [state.name for state in model.machine.states] == ["parked", "Moving"]
    assert [message.channel for message in model.outputs if message.form == "called"] == ["motor.drive"]


def test_the_text_of_a_state_is_its_name() -> None:
    class Moving:
        pass

    class Tree:
        def tip(self) -> Any:
            return SimpleNamespace(name="go home")

    assert [state_text(value) for value in ("up", Moving(), Tree(), None)] == ["up", "Moving", "go home", None]


PROGRAM = """
import threading
from unittest.mock import Mock
from robot_code import Gate

gate = Gate(Mock(is_blocked=Mock(return_value=False)), Mock(visitors=Mock(return_value=1)))
gate.press()
thread = threading.Thread(target=gate.step)
thread.start()
thread.join()
"""


def test_a_recording_has_what_mocks_are_called_with_and_not_what_threads_call(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    source = GATE + "\n    def step(self):\n        self._driver.move('closed')\n"
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    (tmp_path / "demo.py").write_text(PROGRAM, encoding="utf-8")
    list(record("robot_code", ["python", "demo.py"], tmp_path / "seen.json", 60.0))
    seen = read_observations(tmp_path / "seen.json")
    assert seen.calls["Gate.driver.move"].arguments["0"].texts == {"open": 1, "closed": 1}
    assert seen.methods["robot_code:Gate.step"].location == "library"
    model = read(tmp_path, source, seen)
    (move,) = (message for message in model.outputs if message.channel == "driver.move")
    assert {value.text for value in move.fields[0].values} == {"open", "closed"}


def test_what_was_observed_is_of_the_entry_that_ran(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(
        "class Gate:\n    def __init__(self, driver):\n        driver.on_button(self._pressed)\n\n"
        "    def _pressed(self, name):\n        return name == 'open'\n\n\n"
        "def main():\n    Gate(None)\n\n\nif __name__ == '__main__':\n    main()\n",
        encoding="utf-8",
    )
    reader = CodeReader("robot_code", tmp_path)
    first = reader.model()
    seen = Observations()
    seen.methods["callback driver.on_button"] = Site(1, f"{tmp_path / 'robot_code.py'}:9")
    again = reader.model(seen)
    assert first.entry is not None
    assert again.entry is not None
    assert (first.entry.name, again.entry.name) == ("Gate", "Gate")


WORKER = """
import threading
import time


class Worker:
    def __init__(self, jobs, lamp):
        self.jobs, self.lamp = jobs, lamp

    def start(self):
        threading.Thread(target=self._work, daemon=True).start()

    def _work(self):
        while True:
            if self.jobs.get() == "light":
                time.sleep(1.0)
                self.lamp.show("green")
"""


@pytest.mark.slow
def test_code_whose_threads_work_on_has_not_ended(tmp_path: Path) -> None:
    (tmp_path / "worker.py").write_text(WORKER, encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "hri", "--from", "worker"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert 'allowed_endings=("early"' not in (tmp_path / "hri" / "conftest.py").read_text(encoding="utf-8")


class Asleep:
    """A state that keeps nothing."""


class Sleeper:
    def __init__(self) -> None:
        self.state = Asleep()


def test_an_object_without_attributes_is_a_state_too() -> None:
    assert texts_of(Sleeper()) == {"state": "Asleep"}
