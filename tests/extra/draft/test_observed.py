"""What a draft sees of a robot: what its devices are told, what it does while sensors change, how its runs end."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.first_runs import TOO_LONG, FirstRuns
from pytest_hricdv.extra.draft.observe.observations import Observations
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.project.requirements import requirement_ids
from pytest_hricdv.extra.draft.settlement import MIN_TESTS
from pytest_hricdv.extra.draft.settling import settle
from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.driver import ActiveRobot, Driver
from pytest_hricdv.extra.draft.stand_ins.parts import Device, cross_border
from pytest_hricdv.extra.draft.stand_ins.visit import Visit
from pytest_hricdv.runtime import Bus, Kernel, Recorder
from tests.extra.draft import robots

MOWER = '''
from dataclasses import dataclass

SLOW_M_S = 0.2


@dataclass(frozen=True)
class Go:
    """Somebody wants the lawn to be mown."""


@dataclass(frozen=True)
class Done:
    metres: float


class Mower:
    def __init__(self, bus, base, clock):
        self._base, self._clock, self._bus = base, clock, bus
        self._goes = bus.subscribe(Go)

    def run(self, patience_s):
        while self._goes.wait(patience_s) is not None:
            self._base.blade = self._base.battery_v() > 11.0
            self._base.say("mowing")
            for _ in range(3):
                if self._base.is_lifted():
                    break
                self._base.drive(SLOW_M_S, 0.0)
                self._clock.sleep(0.1)
            self._base.drive(0.0, turn=0.0)
            self._base.blade = False
            self._bus.publish(Done(0.06))
'''


def drafted(tmp_path: Path, source: str, **changes: Any) -> tuple[Draft, dict[str, str]]:
    (tmp_path / "robot_code.py").write_text(source, encoding="utf-8")
    draft = Draft(analyse("robot_code", tmp_path), "robot_code", "person", tmp_path.resolve(), **changes)
    return draft, dict(files(draft))


@dataclass(frozen=True)
class Drive:
    speed_m_s: float
    turn: float


@dataclass(frozen=True)
class SetBlade:
    value: str


def test_a_call_that_comes_again_and_again_is_told_once_and_one_that_comes_twice_at_once_twice() -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [Drive, SetBlade], recorder)
    run: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    called = {"base.drive": Drive, "base.set_blade": SetBlade}
    border = RunBorder(run, frozenset(), called, {"base.is_lifted()": False})
    base = Device(senses=("is_lifted()",)).make(border, "base")
    heard, blades = bus.subscribe(Drive), bus.subscribe(SetBlade)

    def body() -> None:
        for _ in range(10):
            base.drive(0.2, turn=0.0)
            kernel.sleep(0.1)
        assert list(iter(heard.poll, None)) == [Drive(0.2, 0.0)]
        kernel.sleep(5.0)
        base.drive(0.2, turn=0.0)
        base.drive(0.2, turn=0.0)
        assert not base.is_lifted()
        border.sense("base.is_lifted()", True)
        assert base.is_lifted()
        base.blade = "on"

    kernel.spawn("robot", body)
    with cross_border(border):
        kernel.run(60.0)
    assert list(iter(heard.poll, None)) == [Drive(0.2, 0.0), Drive(0.2, 0.0)]
    assert list(iter(blades.poll, None)) == [SetBlade("on")]


@dataclass(frozen=True)
class Answer:
    event: str
    kg: float


def test_what_code_returns_is_told_with_its_names_and_what_a_topic_carries_is_its_message() -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [Answer, StateChanged], recorder)
    run: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    called = {"answer.load": Answer, "client.publish robot/state": StateChanged}
    border = RunBorder(run, frozenset(), called, {})
    client = Device().make(border, "client")
    answers, states = bus.subscribe(Answer), bus.subscribe(StateChanged)

    def body() -> None:
        border.tell_answer("load", {"event": "loaded", "kg": 3})
        border.tell_answer("load", True)  # nothing that has a name
        client.publish("robot/state", b'{"state": "up"}', qos=1)
        client.publish("robot/other", "{}")

    kernel.spawn("robot", body)
    with cross_border(border):
        kernel.run(1.0)
    assert list(iter(answers.poll, None)) == [Answer("loaded", 3.0)]
    assert list(iter(states.poll, None)) == [StateChanged("up")]


@dataclass(frozen=True)
class StateChanged:
    state: str


def test_to_watch_a_state_adds_nothing_to_a_registry_of_classes() -> None:
    registry: list[type] = []

    class Robot:
        mode = "idle"

        def __init_subclass__(cls) -> None:
            registry.append(cls)

    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, [StateChanged], recorder)
    run: Any = SimpleNamespace(kernel=kernel, bus=bus, recorder=recorder)
    border = RunBorder(run, frozenset({StateChanged}), {}, {})
    driver = Driver(Robot, state="mode", state_message=StateChanged)
    heard = bus.subscribe(StateChanged)
    robot = ActiveRobot(driver, border, Visit(run, {}, lambda say, numbers: None, (), (), driver.manners))
    kernel.spawn("robot", robot.work)
    kernel.run(1.0)
    assert (registry, next(message.state for message in iter(heard.poll, None))) == ([], "idle")


def test_a_draft_asks_for_the_transitions_of_the_code_and_for_no_stutter(tmp_path: Path) -> None:
    draft, texts = drafted(tmp_path, robots.TRANSITIONS)
    formulas = {each["title"]: each["formula"] for each in tomllib.loads(texts["requirements.toml"]).values()}
    (idle,) = (title for title in formulas if title.startswith("From moving "))
    assert idle == "From moving the robot goes to open, halted or idle only"
    state = draft.code.state
    topic = state.partition(".")[0]
    assert formulas[idle] == (
        f"always(on({topic}) & last({state}) == 'moving' -> {state} == 'moving' | {state} == 'open' | "
        f"{state} == 'halted' | {state} == 'idle')"
    )
    assert formulas["The robot does not publish status twice at one instant"] == (
        f"always(on({topic}) -> count[0:0](on({topic})) <= 1 | last({state}) != {state})"
    )


def scripted(monkeypatch: pytest.MonkeyPatch, script: Callable[[Draft, str, int | None], FirstRuns]) -> None:
    """Let first runs end as a test says, instead of in processes of their own."""

    def run(draft: Draft, suite: str, limit_s: float, tests: int | None = None) -> FirstRuns:
        return script(draft, suite, tests)

    monkeypatch.setattr("pytest_hricdv.extra.draft.settlement.run", run)


def test_a_requirement_that_few_tests_check_is_a_question(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)
    names = requirement_ids(draft)
    rare = {"rl": (), "closure": tuple(names.values())[:2]}
    scripted(monkeypatch, lambda draft, suite, tests: FirstRuns(8, 8, (), () if tests else rare[suite], ""))
    settled, _ = settle(draft)
    assert settled.dropped == tuple(names)[:2]


def test_runs_may_end_as_the_first_ones_did(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    draft, texts = drafted(tmp_path, MOWER)
    assert 'allowed_endings=("limit", "idle", "early", "cycle"),  # TODO' in texts["conftest.py"]
    assert "may_end=True" in texts["conftest.py"]
    asked: list[tuple[str, ...]] = []

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        asked.append(draft.allowed_endings)
        return FirstRuns(8, 8, (), (), "", ends=() if "idle" in draft.allowed_endings else ("idle",))

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert asked == [(), ("idle",), ("idle",), ("idle",)]
    text = dict(files(settled))["conftest.py"]
    assert 'allowed_endings=("idle",),  # TODO' in text
    assert "may_end" not in text  # that it returns is a fault of the run


@pytest.mark.parametrize("used_s", [1.0, 16.0])  # of 60 s: then only what is sure to help is done
def test_the_command_at_which_tests_raise_is_left_out_and_asked_for(
    used_s: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)
    (first, *others) = [command for thing in draft.inputs for command, _ in thing.commands]

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        if first in draft.left_out:
            return FirstRuns(8, 8, (), (), "")
        raising, calm = (frozenset({first, *others}),), (frozenset(others),)
        return FirstRuns(2, 1, (), (), "ValueError: no", raising=raising, calm=calm, used_s=used_s)

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert settled.left_out == (first,)
    assert not settled.isolates  # it was tried, and was not it
    assert settled.code.questions[0].text.startswith(f"`{first}`: ValueError: no: a bug in the code")


def test_what_cannot_be_run_at_all_is_taken_out_step_by_step(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        return FirstRuns(0, 0, (), (), "OSError: no device" if draft.code.entry is not None else "")

    scripted(monkeypatch, script)
    settled, (rl, closure) = settle(draft)
    assert settled.code.entry is None
    assert settled.declared.messages == draft.declared.messages
    assert not rl.error
    assert not closure.error
    compile(dict(files(settled))["conftest.py"], "conftest.py", "exec")


def test_what_was_observed_takes_nothing_away_that_the_code_declares(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(robots.TRANSITIONS + TWO_ROBOTS, encoding="utf-8")
    reader = CodeReader("robot_code:Radio", tmp_path)
    declared = reader.model()
    seen = Observations()
    entry = declared.entry
    assert entry is not None
    for message in declared.inputs:  # each was called by programs, as a control loop is, with other values
        site = seen.site(seen.methods, f"{entry.module}:{entry.name}.{message.channel}")
        assert site is not None
        for _ in range(20):
            site.add({part.name: 7.0 for part in message.fields}, "demo.py:3")
    now = reader.model(seen, frozenset(("time", "transitions", ".Radio")))
    assert {each.topic for each in declared.messages} <= {each.topic for each in now.messages}
    assert [each.states for each in declared.machines] == [each.states for each in now.machines]


def test_an_entry_that_nothing_reaches_makes_room_for_the_next_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "desk.py").write_text(TWO_ROBOTS, encoding="utf-8")
    reader = CodeReader("desk", tmp_path)
    draft = Draft(reader.model(), "desk", "person", tmp_path.resolve() / "hri")
    first = draft.entry

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        return FirstRuns(8, 8, (), (), "", problems=(UNREACHED,) if draft.entry == first and not draft.is_alone else ())

    scripted(monkeypatch, script)
    settled, _ = settle(draft, reader.model)
    assert settled.entry is not None
    assert first is not None
    assert {first.name, settled.entry.name} == {"Lamp", "Radio"}
    assert not settled.hollow
    assert settled.declared.questions[0].text.startswith(f"Does `{settled.entry.name}` run the robot")


TWO_ROBOTS = """
class Lamp:
    def __init__(self, bulb):
        self._bulb = bulb

    def press(self, is_long: bool) -> None:
        self._bulb.toggle(is_long)


class Radio:
    def __init__(self, speaker):
        self._speaker = speaker

    def tune(self, station: str) -> None:
        if station == "news":
            self._speaker.play(station)
"""

UNREACHED = "nothing that people, sensors or the world did reached the code under test in any of 8 runs: ..."


def test_who_reaches_nothing_only_is_there_and_the_draft_says_that_it_is_hollow(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        is_whole = tests is None  # one that runs a few tests only does not judge
        return FirstRuns(8, 8, (), (), "", problems=(UNREACHED,) if is_whole and not draft.is_alone else ())

    scripted(monkeypatch, script)
    settled, trials = settle(draft)
    assert settled.is_alone
    assert not any(trial.cause for trial in trials)
    texts = dict(files(settled))
    assert "+!round : stays_long <- stay(long)." in texts["models/person.asl"]
    assert re.search("How does `.*` get to the code\\? Nothing did", texts["QUESTIONS.md"])
    assert "**Hollow**: nothing that people do reaches the code" in texts["QUESTIONS.md"]
    assert not re.search(r"^ *[^# ].*Say\(", texts["conftest.py"], re.MULTILINE)
    for thing in draft.inputs:  # what the code declares stays, as a comment
        assert all(f'# "{command}": Say(' in texts["conftest.py"] for command, _ in thing.commands)
    assert settled.whole.inputs == draft.inputs


def test_a_test_that_does_not_repeat_is_a_question(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        return FirstRuns(8, 8, (), (), "", unrepeatable="clock: time.time_ns" if draft.audits and not tests else "")

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    texts = dict(files(settled))
    assert "hri_audit = off" in texts["pytest.ini"]
    assert "A test does not repeat: clock: time.time_ns" in texts["QUESTIONS.md"]
    assert settled.inputs


def test_what_fails_before_anybody_acts_is_no_matter_of_what_people_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)
    asked: list[Draft] = []

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        asked.append(draft)
        if draft.code.entry is None:
            return FirstRuns(1, 1, (), (), "")
        return FirstRuns(2, 0, (), (), "ValueError: no port", raising=(frozenset({"go"}),) * 2, last=("", ""))

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert len(asked) == 4  # as it is, only imported, and both suites
    assert settled.code.questions[0].text.startswith("The code could not be run as it is: ValueError: no port")


def test_code_that_lacks_a_file_ends_there_and_the_draft_asks_for_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        error = "" if draft.may_raise else "FileNotFoundError: [Errno 2] No such file or directory: 'map.png'"
        return FirstRuns(2, 2 if draft.may_raise else 0, (), (), error,
                         raising=() if draft.may_raise else (frozenset({"go"}),) * 2, last=("go", "go"))  # fmt: skip

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert (settled.may_raise, settled.inputs) == (("FileNotFoundError",), draft.inputs)
    assert settled.declared.questions[0].text.startswith("FileNotFoundError: [Errno 2] No such file")
    assert "may_raise=(FileNotFoundError,),  # TODO" in dict(files(settled))["conftest.py"]


def test_a_suite_of_which_no_test_ended_in_time_is_as_small_as_can_be(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        is_slow = suite == "closure"
        return FirstRuns(0 if is_slow else 8, 0 if is_slow else 8, (), (), TOO_LONG if is_slow else "",
                         is_ended=is_slow, used_s=100.0)  # fmt: skip

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert settled.sizes == {"closure": MIN_TESTS}


def test_requirements_that_did_not_hold_are_told_by_their_subjects(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Their ids are others once nobody says anything."""
    draft, _ = drafted(tmp_path, robots.MATCH)

    def script(draft: Draft, suite: str, tests: int | None) -> FirstRuns:
        if not draft.is_silent:
            return FirstRuns(8, 8, (), (), "", problems=(UNREACHED,))
        return FirstRuns(1, 1, ("R1",) if suite == "closure" else (), (), "")

    scripted(monkeypatch, script)
    settled, _ = settle(draft)
    assert settled.dropped == (next(iter(requirement_ids(settled))),)
    assert tomllib.loads(dict(files(settled))["requirements.toml"])


@pytest.mark.slow
def test_the_draft_of_a_robot_with_patience_is_green_at_a_seed_that_it_has_not_seen(tmp_path: Path) -> None:
    (tmp_path / "robot_code.py").write_text(MOWER, encoding="utf-8")
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code", "--budget", "16"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    session = [sys.executable, "-m", "pytest", "-q", "--hri-suite=rl,closure", "--hri-seed=1", "--hri-audit=off"]
    done = subprocess.run(session, cwd=tmp_path / "draft", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
