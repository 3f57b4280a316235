"""A race between a robot's threads, found, replayed and explained; its repaired twin never fails."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

ARM = '''"""An arm that a watchdog stops."""

import threading
import time


class Arm:
    def __init__(self, motor, stops, is_safe):
        self.motor, self.stops, self.stopped = motor, stops, False
        self.lock = threading.Lock() if is_safe else threading.Semaphore(99)

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            with self.lock:
                if not self.stopped:
                    self.motor.move(True)
            time.sleep(0.1)

    def watch(self):
        while self.stops.wait(100.0) is not None:
            with self.lock:
                self.stopped = True
                self.motor.move(False)
'''
CONFTEST = '''
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.testbench import (
    BeliefSpace, Concretization, Model, Outcome, Testbench, Timing, Uniform, VirtualTime
)

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Stop:
    """A person pressed the button."""


class Motor:
    def __init__(self, run):
        self.run = run
        self.move(False)

    def move(self, on):
        self.run.recorder.signal(self.run.kernel.now_s, "moving", on)


def pytest_hricdv_testbench(config):
    return Testbench(
        name="arm",
        model=Model(HERE / "arm.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("go",), groups={"times": ("once", "twice")}, id_groups=("times",)),
        concretization=Concretization(commands={"stop": {"pause_s": Uniform(0.2, 3.0, "s")}}),
        requirements=HERE / "requirements.toml",
        messages=(Stop,),
        signals={"moving": bool},
        code=("arm",),
        run=run,
        time=VirtualTime(apis=("time", "threading")),
        timing=Timing(slowest_s=SLOWEST),
    )


def run(run):
    from arm import Arm

    arm = Arm(Motor(run), run.bus.port("arm").subscribe(Stop), IS_SAFE)

    def person():
        bus = run.bus.port("person")
        for action in run.actions():
            run.kernel.sleep(action.parameters["pause_s"])
            bus.publish(Stop())
        run.kernel.sleep(2.0)
        run.kernel.stop("over")

    run.kernel.spawn("person", person)
    run.kernel.spawn("arm", run.measured(arm.work))
    return Outcome(run.go(limit_s=60.0))
'''
FILES = {
    "arm.py": ARM,
    "arm.mas2j": "MAS arm { agents: meta; person; }\n",
    "meta.asl": "// lint: percepts chosen\n!steer.\n+!steer <- for (chosen(B)) { .send(person, tell, B) }; "
    ".send(person, achieve, go).\n",
    "person.asl": "@go +!go : go <- !stops.\n@once +!stops : once <- stop.\n@twice +!stops : twice <- stop; stop.\n",
    "requirements.toml": '[R1]\ntitle = "It does not move after a stop"\n'
    'formula = "always(on(stop) -> always[0.5:1.5](not moving))"\n',
    "test_arm.py": "def test_arm(hri_case):\n    hri_case.check(hri_case.run())\n",
    "pytest.ini": "[pytest]\npythonpath = .\nhri_suite = rl\n",
}
OPTIONS = ("--hri-tests=4", "-p", "no:cacheprovider")


def project(pytester: pytest.Pytester, *, is_safe: bool, slowest_s: float | None = None) -> Path:
    for name, text in FILES.items():
        (pytester.path / name).write_text(text, encoding="utf-8")
    conftest = CONFTEST.replace("IS_SAFE", str(is_safe)).replace("=SLOWEST", f"={slowest_s}")
    (pytester.path / "conftest.py").write_text(conftest, encoding="utf-8")
    return pytester.path


def written(folder: Path, report: str = "hri-report") -> dict[str, Any]:
    made: dict[str, Any] = json.loads((folder / report / "report.json").read_text(encoding="utf-8"))
    return made


@pytest.mark.slow
def test_a_race_is_found_repeated_and_explained(pytester: pytest.Pytester) -> None:
    folder = project(pytester, is_safe=False)
    result = pytester.runpytest_subprocess(*OPTIONS, "--hri-schedules=20")
    assert result.ret == 1
    schedules = written(folder)["schedules"]
    (race,) = schedules["races"]
    assert (race["requirement"], race["failure_kind"], race["is_counted"]) == ("R1", "wrong-order", True)
    assert race["words"].startswith("arm waits before arm.py:17 for 0.0")
    assert "while arm: Thread-1 (watch) executes arm.py:22, arm.py:23, arm.py:24" in race["words"]
    assert schedules["runs"] == 20
    again = pytester.runpytest_subprocess(
        f"--hri-replay={race['replay']}", "--hri-report=again", "-p", "no:cacheprovider"
    )
    again.assert_outcomes(failed=1)
    again.stdout.fnmatch_lines(["*the same run, bit for bit*"])
    again.stdout.no_fnmatch_line("*one thread order was tested*")  # it was another one
    (decision,) = race["schedule"]["decisions"]
    assert {**decision, "kind": "", "occurrence": 0, "delay_s": 0.0} == {
        "kind": "",
        "file": "arm.py",
        "line": 17,
        "node": "arm",
        "occurrence": 0,
        "delay_s": 0.0,
    }
    (test,) = written(folder, "again")["tests"]
    assert (test["failure_kind"], test["concrete"]["schedule"]) == ("wrong-order", race["schedule"])
    (cause,) = written(folder, "again")["causes"]
    assert cause["deciding_change"] == "passes without the wait before arm.py:17"
    assert cause["schedule"] == race["schedule"]


@pytest.mark.slow
def test_tests_that_violate_what_is_known_are_searched_too(pytester: pytest.Pytester) -> None:
    folder = project(pytester, is_safe=False)
    with (folder / "requirements.toml").open("a", encoding="utf-8") as file:
        file.write('[R2]\ntitle = "It goes on"\nformula = "always(on(stop) -> moving)"\n')
    with (folder / "pytest.ini").open("a", encoding="utf-8") as file:
        file.write("hri_known_violations = R2: people stop it\n")
    pytester.runpytest_subprocess(*OPTIONS, "--hri-schedules=20")
    assert "R1" in {race["requirement"] for race in written(folder)["schedules"]["races"]}


WRITTEN = {
    "sets.toml": '[[belief_set]]\nname = "a stop"\nbeliefs = ["go", "once"]\n',
    "tests.txt": "stop\n",
}
CUSTOM = """
from pytest_hricdv.run import ConcreteAction, ConcreteTest, ScheduleDecision

STOPS = tuple(ConcreteAction(**action) for action in {actions!r})
SCHEDULE = (ScheduleDecision("{kind}", "{file}:{line}", {occurrence}, {delay_s}),)


def test_it_stops_whatever_comes_in_between(hri_run):
    hri_run.check(hri_run(ConcreteTest("stop", "mine", 0, STOPS)))
    hri_run.check(hri_run(ConcreteTest("stop", "mine", 0, STOPS, schedule=SCHEDULE)))
"""


@pytest.mark.slow
@pytest.mark.parametrize("suite", [*WRITTEN, "closure"])
def test_a_race_is_found_in_tests_of_other_suites_and_a_custom_test_repeats_it(
    pytester: pytest.Pytester, suite: str
) -> None:
    folder = project(pytester, is_safe=False)
    for name, text in WRITTEN.items():
        (folder / name).write_text(text, encoding="utf-8")
    options = (f"--hri-suite={suite}", "--hri-close-runs=8", "--hri-schedules=20", "-p", "no:cacheprovider")
    pytester.runpytest_subprocess(*options)
    (race,) = written(folder)["schedules"]["races"]
    assert (race["requirement"], race["failure_kind"]) == ("R1", "wrong-order")
    concrete = json.loads((folder / race["replay"]).read_text(encoding="utf-8"))["concrete"]
    (decision,) = concrete["schedule"]["decisions"]
    text = CUSTOM.format(actions=concrete["actions"], **decision)
    (folder / "test_custom.py").write_text(text, encoding="utf-8")
    custom = pytester.runpytest_subprocess("test_custom.py", "-p", "no:cacheprovider", "-o", "hri_suite=")
    custom.assert_outcomes(failed=1)
    custom.stdout.fnmatch_lines(["R1 Passed (*", "R1 Failed (*"])


@pytest.mark.parametrize(
    ("kind", "line", "delay_s", "told"),
    [
        ("preemption", 99, 0.05, "has a preemption at arm.py:99, where nothing can wait"),
        ("delay", 1, 0.05, "has a delay at arm.py:1, where nothing can wait"),
        ("preemtion", 17, 0.05, "is 'preemtion'; expected preemption, delay, order, delivery"),
        ("delay", 17, -1.0, "delay_s is -1.0; expected a finite number, at least 0"),
    ],
)
def test_a_decision_that_would_change_nothing_is_refused(
    pytester: pytest.Pytester, kind: str, line: int, delay_s: float, told: str
) -> None:
    folder = project(pytester, is_safe=True)
    actions = [{"command": "stop", "parameters": {"pause_s": 1.0}}]
    text = CUSTOM.format(actions=actions, kind=kind, file="arm.py", line=line, occurrence=1, delay_s=delay_s)
    (folder / "test_custom.py").write_text(text, encoding="utf-8")
    result = pytester.runpytest_subprocess("test_custom.py", "-p", "no:cacheprovider", "-o", "hri_suite=")
    result.stdout.fnmatch_lines([f"*{told}*"])
    assert result.ret != 0


@pytest.mark.slow
def test_a_fault_that_removes_a_lock_is_noticed_under_a_schedule(pytester: pytest.Pytester) -> None:
    folder = project(pytester, is_safe=True)
    (folder / "arm.py").write_text(ARM.replace(" if is_safe else threading.Semaphore(99)", ""), encoding="utf-8")
    pytester.runpytest_subprocess(*OPTIONS, "--hri-schedules=40", "--hri-mutate")
    mutants = written(folder)["mutation"]["mutants"]
    removed = {mutant["line"]: mutant["status"] for mutant in mutants if mutant["operator"] == "lock removed"}
    assert removed == {15: "killed", 22: "killed"}


@pytest.mark.slow
def test_a_replay_shows_switches_and_stops_at_the_statement_that_waits(pytester: pytest.Pytester) -> None:
    folder = project(pytester, is_safe=False)
    pytester.runpytest_subprocess(*OPTIONS, "--hri-schedules=20")
    replay = f"--hri-replay={written(folder)['schedules']['races'][0]['replay']}"
    pytester.runpytest_subprocess(replay, "--hri-report=again", "-p", "no:cacheprovider")
    (test,) = written(folder, "again")["tests"]
    arm, watch = test["lanes"]
    assert (arm["node"], watch["node"]) == ("arm", "arm: Thread-1 (watch)")
    assert [place for *_, place in arm["held"]] == ["arm.py:17"]
    (decision,) = test["concrete"]["schedule"]["decisions"]
    assert "arm.py:22" in [place for _, place in watch["switches"]]
    command = (sys.executable, "-m", "pytest", replay, "--pdb", "--hri-report=third", "-p", "no:cacheprovider")
    stopped = pytester.run(*command, stdin=b"p self.stopped\nc\nq\n")
    stopped.stdout.fnmatch_lines(
        [f"*arm waits before arm.py:17 ({decision['kind']})*", "*self.motor.move(True)", "*False"]
    )


BRAKES = """
import time


class Arm:
    def __init__(self, motor, stops, is_safe):
        self.motor, self.stops = motor, stops

    def work(self):
        self.motor.move(True)
        self.stops.wait(100.0)
BODY
"""
BUDGETS = {
    "halt": ("        self.halt()\n", "    def halt(self):\n        self.motor.move(False)\n", 0.4),
    "brake": (
        "        for _ in range(3):\n            self.brake()\n        self.motor.move(False)\n",
        "    def brake(self):\n        time.sleep(0.05)\n",
        (0.4 - 0.15) / 3,
    ),
    "look": (
        "        self.look()\n        time.sleep(0.1)\n        self.look()\n        self.motor.move(False)\n",
        "    def look(self):\n        self.seen = True\n",
        (0.4 - 0.1) / 2,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BUDGETS)
def test_a_budget_is_exact_to_a_millisecond(pytester: pytest.Pytester, name: str) -> None:
    work, function, expected_s = BUDGETS[name]
    folder = project(pytester, is_safe=True)
    (folder / "arm.py").write_text(BRAKES.replace("BODY", f"{work}\n{function}"), encoding="utf-8")
    requirement = '[R1]\ntitle = "It stops"\nformula = "always(on(stop) -> always[0.4:1.5](not moving))"\n'
    (folder / "requirements.toml").write_text(requirement, encoding="utf-8")
    (folder / "conftest.py").write_text(
        (folder / "conftest.py")
        .read_text(encoding="utf-8")
        .replace("VirtualTime(", 'VirtualTime(allowed_endings=("early",), '),
        encoding="utf-8",
    )
    measured = pytester.run(sys.executable, "-m", "pytest_hricdv", "budgets", "--tests=2", "--", *OPTIONS)
    budgets = {budget["name"]: budget for budget in written(folder)["budgets"] if "other" not in budget}
    budget = budgets[f"Arm.{name}"]
    assert (budget["requirement"], abs(budget["budget_s"] - expected_s) <= 0.001) == ("R1", True), budgets
    (printed,) = (line.split()[0] for line in measured.outlines if f" Arm.{name} (" in line and ", and " not in line)
    assert verdict_with(pytester, budget["replay"], float(printed) + 0.001) == "Failed"
    assert verdict_with(pytester, budget["replay"], float(printed) - 0.001) == "Passed"


def verdict_with(pytester: pytest.Pytester, replay: str, delay_s: float) -> str:
    """What a replay file shows once its delay is another one; as it is, it is the same run."""
    file = pytester.path / replay
    test = json.loads(file.read_text(encoding="utf-8"))
    (decision,) = test["concrete"]["schedule"]["decisions"]
    is_edited = abs(decision["delay_s"] - delay_s) > 1e-9
    decision["delay_s"] = delay_s if is_edited else decision["delay_s"]
    file.write_text(json.dumps(test), encoding="utf-8")
    again = pytester.runpytest_subprocess(f"--hri-replay={replay}", "--hri-report=again", "-p", "no:cacheprovider")
    again.stdout.fnmatch_lines(["*the test was edited*" if is_edited else "*the same run, bit for bit*"])
    (run,) = written(pytester.path, "again")["tests"]
    verdict = str(run["requirements"]["R1"]["verdict"])
    assert run["outcome"] == {"Passed": "passed", "Failed": "failed"}[verdict]
    return verdict
