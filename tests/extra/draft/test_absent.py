"""Modules that are not installed: code runs without them, and what it does with them crosses its border."""

from __future__ import annotations

import subprocess
import sys
from abc import ABC
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.draft import ProgramPort, Replace, replace_modules
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.observe.observations import Observations, read_observations
from pytest_hricdv.extra.draft.observed_calls import absent_ports
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.stand_ins.border import OBSERVE, RunBorder
from pytest_hricdv.extra.draft.stand_ins.parts import cross_border
from pytest_hricdv.runtime import Bus, Kernel, Recorder

SCRIPT = """
from time import sleep

from rover_lib import Rover, RoverError


def main():
    rover = Rover()
    eyes = rover.open_eyes()
    while True:
        distance = eyes.read_mm()
        if rover.button.read():
            rover.light("red")
        if distance == 0:
            raise RoverError("no sensor")
        if distance < 150:
            rover.stop()
        else:
            rover.drive(distance / 10)
        sleep(0.1)
"""


@pytest.fixture(autouse=True)
def without_modules() -> Iterator[None]:
    """The stand-ins of one test only."""
    finders = [*sys.meta_path]
    yield
    sys.meta_path[:] = finders
    for name in [name for name in sys.modules if name.partition(".")[0] == "rover_lib"]:
        del sys.modules[name]


def run(body: Callable[[RunBorder], Any], senses: dict[str, Any] | None = None) -> RunBorder:
    """The border after a run in which a node does something."""
    kernel, recorder = Kernel(), Recorder()
    made: Any = SimpleNamespace(kernel=kernel, bus=Bus(kernel, [], recorder), recorder=recorder)
    border = RunBorder(made, frozenset(), {}, senses or {})
    kernel.spawn("robot", lambda: body(border))
    with cross_border(border):
        kernel.run(60.0)
    border.close()
    return border


def library() -> Any:
    replace_modules("rover_lib")
    import rover_lib  # type: ignore[import-not-found]  # it has a stand-in

    return rover_lib


def test_classes_can_be_derived_raised_and_asked_for_anything() -> None:
    lib = library()

    class Own(lib.Rover, ABC):  # type: ignore[name-defined,misc]
        def __init__(self) -> None:
            super().__init__(speed=2.0)
            self.gear = 3

    class Other(lib.tools.base):  # type: ignore[name-defined,misc]  # its name does not say that it is a class
        pass

    own = Own()
    assert (own.gear, own.speed, bool(own.motor.start(1))) == (3, 2.0, False)
    assert isinstance(own, lib.Rover)
    assert isinstance(Other(), Other)
    lib.Engine.init(None)
    with pytest.raises(lib.RoverError, match="empty"):
        raise lib.RoverError("empty")

    @lib.on("start")  # type: ignore[untyped-decorator]  # of an unknown library
    def begin() -> int:
        return 7

    assert begin() == 7


def test_an_object_that_is_passed_on_is_not_looked_into(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    lib = library()
    run(lambda _: lib.Rover().drive(lib.Place(1, 2)))
    assert not [key for key in read_observations(tmp_path / "seen.json").calls if "_fields" in key]


def test_what_code_calls_tests_and_compares_is_observed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    lib = library()
    early = lib.Rover()  # as code does that makes it while it is imported

    def body(_: RunBorder) -> None:
        distance = early.eyes().read_mm()
        assert not distance > 3
        assert distance == 0
        early.drive(2.5, "slowly")
        assert lib.input(4) != lib.HIGH or True
        assert not lib.scan()[0]["range_m"] > 1.5
        (x, (y, *rest)), z = early.position()
        assert (list(early.others()), rest) == ([], [])
        assert [x > 7, y > 8, z > 9] == [False, False, False]
        early.on_bump = body
        early.mode = "fast"

    border = run(body)
    seen = read_observations(tmp_path / "seen.json")
    assert seen.calls["Rover.eyes().read_mm()"].compared == [3.0, 0.0]
    assert seen.calls["Rover.eyes().read_mm"].location.startswith(f"{__file__}:")
    assert seen.calls["Rover.drive"].arguments["1"].texts == {"slowly": 1}
    assert seen.calls["Rover.set_mode"].count == 1
    positions = {key: site.compared for key, site in seen.calls.items() if key.startswith("Rover.position()")}
    assert positions == {
        "Rover.position()[0][0]": [7.0],
        "Rover.position()[0][1][0]": [8.0],
        "Rover.position()[1]": [9.0],
    }
    assert seen.calls["rover_lib.scan()[range_m]"].compared == [1.5]
    assert set(seen.calls["rover_lib.input(4)"].result.kinds) == {"bool"}
    assert [*border.callbacks] == ["Rover.on_bump"]
    assert {*seen.absent} == {"Rover", "rover_lib"}
    again = Observations()
    again.merge(seen)
    assert again.to_json() == seen.to_json()


def test_it_returns_what_a_person_sets() -> None:
    lib, taken = library(), []

    def body(_: RunBorder) -> None:
        rover = lib.Rover()
        taken.append((rover.eyes().read_mm() * 2, rover.button.pressed, rover.say("hello")))
        assert lib.scan()[0]["range_m"] == 0.5

    run(
        body,
        {
            "rover_lib.scan()[range_m]": 0.5,
            "Rover.eyes().read_mm()": 21.0,
            "Rover.button.pressed": True,
            "Rover.say()": "hi",
        },
    )
    assert taken == [(42.0, True, "hi")]


@pytest.mark.parametrize(("pins", "sensors"), [(1, [""]), (3, ["0", "1", "2"]), (9, [""])])
def test_few_numbers_or_names_that_a_call_is_given_are_sensors_of_their_own(
    pins: int, sensors: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    lib = library()

    def body(_: RunBorder) -> None:
        for pin in range(pins):
            assert lib.input(pin) or True

    run(body, {"rover_lib.input()": False} if pins == 3 else None)  # also where one sensor is known
    (port,) = absent_ports(read_observations(tmp_path / "seen.json"), tmp_path)
    assert [each.name for each in port.operations] == [f"input({text})" for text in sensors]

    def read(_: RunBorder) -> None:
        assert [lib.input(7), lib.input("left"), lib.input(lib.A1)] == [True, False, True]

    run(read, {"rover_lib.input(7)": True, "rover_lib.input(A1)": True})


def test_a_draft_has_sensors_and_calls_of_what_was_observed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    (tmp_path / "rover_code.py").write_text(SCRIPT, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    replace_modules("rover_lib")
    from rover_code import RoverError, main  # type: ignore[import-not-found]  # it was just written

    def body(_: RunBorder) -> None:
        with pytest.raises(RoverError):
            main()

    run(body)
    first = read_observations(tmp_path / "seen.json")
    model = CodeReader("rover_code", tmp_path).model(first)
    draft = Draft(model, "rover", "person", tmp_path.resolve() / "hri")
    assert [sensor.name for sensor in draft.sensors] == ["Rover_button.read", "Rover_open_eyes.read_mm"]
    (text,) = [text for name, text in files(draft) if name == "conftest.py"]
    # It is not what the code compares it with: that ended the code. So the next runs show more.
    assert '"Rover.open_eyes().read_mm()": 0.5,  # rover_code.py:14' in text
    assert 'replace_modules("rover_lib")' in text


def test_a_topic_that_is_told_is_no_method(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    (tmp_path / "rover_code.py").write_text(SCRIPT, encoding="utf-8")
    lib = library()

    def body(_: RunBorder) -> None:
        rover = lib.Rover()
        rover.on("start", body)
        rover.tell("moved", 3.0)

    run(body)
    model = CodeReader("rover_code", tmp_path).model(read_observations(tmp_path / "seen.json"))
    assert [(each.name, each.channel) for each in model.outputs] == [("Moved", "Rover.tell moved")]


SPEAKER = """
import subprocess
from os import system


def main():
    if system("amixer set PCM 100") != 0:
        print("no sound")
    done = subprocess.run(["espeak", "hello"])
    while done.returncode:
        done = subprocess.run(["espeak", "again"])
"""


def test_programs_that_the_code_starts_do_not_run_and_a_person_is_at_their_end(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv(OBSERVE, str(tmp_path / "seen.json"))
    (tmp_path / "speaker_code.py").write_text(SPEAKER, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    import speaker_code  # type: ignore[import-not-found]  # it was just written

    model = CodeReader("speaker_code", tmp_path).model()
    assert {port.made_from: port.annotation for port in model.inner} == {
        "speaker_code:system": "os.system",
        "speaker_code:subprocess.run": "subprocess.run",
    }

    def body(border: RunBorder) -> None:
        undo = [Replace(port.made_from, ProgramPort(port.annotation)).apply(border, port.name) for port in model.inner]
        speaker_code.main()
        for put_back in undo:
            put_back()

    run(body)
    seen = read_observations(tmp_path / "seen.json")
    assert seen.calls["os.system()"].compared == [0.0]
    assert set(seen.calls["subprocess.run().returncode"].result.kinds) == {"bool"}
    draft = Draft(CodeReader("speaker_code", tmp_path).model(seen), "speaker", "person", tmp_path.resolve() / "hri")
    assert [sensor.name for sensor in draft.sensors] == ["os_system", "subprocess_run.returncode"]
    (text,) = [text for name, text in files(draft) if name == "conftest.py"]
    assert 'Replace("speaker_code:subprocess.run", ProgramPort("subprocess.run"))' in text


@pytest.mark.slow
def test_a_script_without_its_library_gets_a_draft_that_reaches_it(tmp_path: Path) -> None:
    (tmp_path / "rover_code.py").write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "rover_code", "--budget", "16"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "first runs: rover_lib.RoverError: no sensor: run without the cause" in made.stdout  # at 0 mm
    assert "hollow" not in made.stdout
    text = (tmp_path / "draft" / "conftest.py").read_text(encoding="utf-8")
    assert '"set_rover_open_eyes_read_mm mid_value": {"value": Uniform(0, 150)}' in text
    session = [sys.executable, "-m", "pytest", "-q", "--hri-suite=rl", "--hri-audit=off", "--hri-tests=12"]
    done = subprocess.run(session, cwd=tmp_path / "draft", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_an_exception_that_is_not_installed_can_be_caught() -> None:
    replace_modules("absent_wire")
    wire: Any = import_module("absent_wire")

    def catch() -> None:
        try:
            raise KeyError
        except wire.ConnectionClosed:
            pytest.fail("it is another one")

    def catch_inner() -> None:
        try:
            raise KeyError
        except wire.exceptions.Closed:
            pytest.fail("it is another one")

    for function in (catch, catch_inner, catch):
        with pytest.raises(KeyError):
            function()
