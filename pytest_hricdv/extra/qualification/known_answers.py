"""The checks of `hricdv qualify`, whose answers are known (`KNOWN_ANSWERS`); the command runs each in a `Workshop`.

They are sessions of the skeleton's robot, with and without seeded bugs, and monitors with verdicts computed by hand.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from threading import Lock, Timer
from typing import Any

from pytest_hricdv.monitor.loading import parse_formula
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.logged import evaluate
from pytest_hricdv.monitor.requirement import Requirement
from pytest_hricdv.monitor.vocabulary import Vocabulary

SESSION_S = 120.0
"""Time limit (s) for a session, which takes some seconds."""

ROBOT = "my_robot.py"


class WrongAnswerError(Exception):
    """The answer is not the known one; the message has both."""


@dataclass(frozen=True)
class SessionEnd:
    """The exit status of a session and its report."""

    status: int
    report: Mapping[str, Any]

    def verdicts(self, requirement: str) -> set[str]:
        """The verdicts of all tests on a requirement."""
        return {test["requirements"][requirement]["verdict"] for test in self.report["tests"] if test["requirements"]}

    def records(self) -> dict[str, str]:
        """Test -> SHA-256 of its record."""
        return {test["nodeid"]: test["record_sha256"] for test in self.report["tests"]}


@dataclass
class Workshop:
    """A folder for the projects of sessions.

    Args:
        folder: empty.
    """

    folder: Path
    made: int = 0
    lock: Lock = field(default_factory=Lock)

    def project(self, edits: Sequence[tuple[str, str, str]] = ()) -> Path:
        """A project like that of `hricdv init`, with texts of files replaced: file, old text, new text."""
        with self.lock:
            self.made += 1
            target = self.folder / f"project{self.made}"
            first = self.folder / "project0"
            if not first.exists():
                subprocess.run(
                    [sys.executable, "-m", "pytest_hricdv", "init", str(first), "--robot=my_robot"],
                    capture_output=True,
                    check=True,
                    timeout=SESSION_S,
                )
        shutil.copytree(first, target)
        for name, old, new in edits:
            text = (target / name).read_text(encoding="utf-8")
            if old not in text:
                raise WrongAnswerError(f"{name} of the skeleton has no {old!r}")
            (target / name).write_text(text.replace(old, new), encoding="utf-8")
        return target

    def run(self, project: Path, *options: str, seed_of_hashes: str = "0") -> SessionEnd:
        """A session of four tests."""
        ended = subprocess.run(
            command(*options),
            cwd=project,
            env={**os.environ, "PYTHONHASHSEED": seed_of_hashes},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=SESSION_S,
            check=False,
        )
        report = project / "hri-report" / "report.json"
        if not report.is_file():
            said = ended.stdout.decode("utf-8", "replace").strip().splitlines()[-1:]
            raise WrongAnswerError(f"pytest ended with {ended.returncode} and no report: {''.join(said)}")
        return SessionEnd(ended.returncode, json.loads(report.read_text(encoding="utf-8")))


def command(*options: str) -> list[str]:
    """The command of a session of four tests."""
    usual = ("--hri-suite=rl", "--hri-tests=4", "--hri-seed=0", "--hri-diagnose=0", "-p", "no:cacheprovider", "-q")
    chosen = {option.partition("=")[0] for option in options}
    audit = () if "--hri-audit" in chosen else ("--hri-audit=off",)
    return [sys.executable, "-m", "pytest", *usual, *audit, *options]


def expect(got: object, wanted: object, what: str) -> None:
    """Raises WrongAnswerError if they differ."""
    if got != wanted:
        raise WrongAnswerError(f"{what}: expected {wanted!r}, found {got!r}")


def fails(requirement: str, *edits: tuple[str, str, str]) -> Callable[[Workshop], None]:
    """A seeded bug that violates this requirement and no other."""

    def check(workshop: Workshop) -> None:
        end = workshop.run(workshop.project(edits))
        expect(end.status, 1, "exit status")
        for name in ("R1", "R2"):
            expect("Failed" in end.verdicts(name), name == requirement, f"{name} failed in a test")

    return check


def passes(*edits: tuple[str, str, str]) -> Callable[[Workshop], None]:
    """A robot that is correct."""

    def check(workshop: Workshop) -> None:
        end = workshop.run(workshop.project(edits))
        expect(end.status, 0, "exit status")
        for name in ("R1", "R2"):
            expect(end.verdicts(name) - {"NC"}, {"Passed"}, f"verdicts of {name}")

    return check


def _raises(workshop: Workshop) -> None:
    end = workshop.run(workshop.project([(ROBOT, "moved_s = 0.0", "moved_s = 1 / 0")]))
    expect(end.status, 1, "exit status")
    told = all("ZeroDivisionError" in test["failure"] for test in end.report["tests"])
    expect(told, True, "each failure names the error")


def _never_triggers(workshop: Workshop) -> None:
    text = '[R3]\ntitle = "Never"\nformula = "always(person_near & not person_near -> arm_moves)"\n\n[R2]'
    end = workshop.run(workshop.project([("requirements.toml", "[R2]", text)]), "--hri-fail-on=nc")
    expect(end.verdicts("R3"), {"NC"}, "verdicts of R3")
    expect(end.status, 1, "exit status")


def _covers(workshop: Workshop) -> None:
    first = "    requests = bus.subscribe(Request)"
    project = workshop.project([(ROBOT, first, f"{first}\n    if patience_s < 0:\n        return")])
    (file,) = workshop.run(project).report["code_under_test"]["files"]
    lines = (project / ROBOT).read_text(encoding="utf-8").splitlines()
    expect([lines[line - 1].strip() for line in file["missing_lines"]], ["return"], "lines that no test covers")
    expect(file["statements"] - file["covered"], 1, "statements that no test covers")


def _repeats(workshop: Workshop) -> None:
    project = workshop.project()
    first = workshop.run(project, seed_of_hashes="1").records()
    for options, seed in (((), "2"), (("-n", "2"), "3")):
        expect(
            workshop.run(project, *options, seed_of_hashes=seed).records() == first, True, "all records are the same"
        )


def _is_flaky(workshop: Workshop) -> None:
    edits = [
        (ROBOT, "import time\n", "import os\nimport time\n"),
        (ROBOT, "time.sleep(LOOK_EVERY_S)", "time.sleep(LOOK_EVERY_S + os.getpid() % 997 / 10_000)"),
    ]
    end = workshop.run(workshop.project(edits), "--hri-audit=4")
    expect(end.status, 1, "exit status")
    expect(bool(end.report["audit"]), True, "the report has an audit")


def _is_killed(workshop: Workshop) -> None:
    project = workshop.project()
    with subprocess.Popen(
        command("--hri-concretizations=40", "-vv"),
        cwd=project,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as running:
        limit = Timer(SESSION_S, running.kill)
        limit.start()
        results = (line for line in running.stdout or () if b"PASSED" in line)
        ended = len([*islice(results, 4)])
        limit.cancel()
        running.kill()
    expect(ended, 4, "tests that ended")
    rebuilt = subprocess.run(
        [sys.executable, "-m", "pytest_hricdv", "report", "rebuild", "hri-report"],
        cwd=project,
        capture_output=True,
        timeout=SESSION_S,
        check=False,
    )
    expect(rebuilt.returncode, 1, "exit status of the rebuilt report")
    expect(b"have no result" in rebuilt.stdout, True, "tests without a result are counted")


@dataclass(frozen=True)
class MonitorCase:
    """A formula over a log, with the verdict and the margin that were computed by hand."""

    formula: str
    signals: Mapping[str, Sequence[tuple[float, object]]]
    verdict: str
    margin: float | None

    def __call__(self, workshop: Workshop) -> None:
        """Evaluates it."""
        kinds: dict[str, Any] = {name: type(values[0][1]) for name, values in self.signals.items()}
        columns: dict[str, Any] = {name: tuple(zip(*values, strict=True)) for name, values in self.signals.items()}
        with workshop.lock:
            formula = parse_formula(self.formula, Vocabulary(signals=kinds))
            (verdict,) = evaluate([Requirement("R", "", "", self.formula, formula)], Log(columns, (), 10.0))
        expect(verdict.verdict, self.verdict, f"verdict of {self.formula}")
        got = None if verdict.margin is None else round(verdict.margin, 6)
        expect(got, self.margin, f"margin of {self.formula}")


_DISTANCE = {"distance": ((0.0, 3.0), (2.0, 1.25), (4.0, 2.0)), "runs": ((0.0, True),)}
_WORK = "WORK_S, LOOK_EVERY_S = 2.0, 0.1"
_STOP = {"near": ((0.0, False), (2.0, True)), "moves": ((0.0, True), (2.5, False))}

KNOWN_ANSWERS: tuple[tuple[str, Callable[[Workshop], None]], ...] = (
    ("a correct robot passes", passes()),
    (
        "a correct robot that is slower passes",
        passes((ROBOT, "WORK_S, LOOK_EVERY_S = 2.0", "WORK_S, LOOK_EVERY_S = 4.0")),
    ),
    ("a robot that does not stop fails", fails("R2", (ROBOT, "moves = not arm.person_is_near()", "moves = True"))),
    ("a robot that stops too late fails", fails("R2", (ROBOT, _WORK, _WORK.replace("0.1", "0.5")))),
    ("a robot that never answers fails", fails("R1", (ROBOT, "        bus.publish(Done())", "        pass"))),
    (
        "a robot that answers too late fails",
        fails("R1", (ROBOT, "WORK_S, LOOK_EVERY_S = 2.0", "WORK_S, LOOK_EVERY_S = 40.0")),
    ),
    ("an error in the code fails, with its name", _raises),
    ("a requirement that is never triggered is not checked, not passed", _never_triggers),
    ("a statement that no test covers is named with its line", _covers),
    ("a session repeats bit for bit, with other hashes and on two workers", _repeats),
    ("code that does not repeat is detected", _is_flaky),
    ("a killed session lists the tests without a result", _is_killed),
    ("a bound that holds, with its margin", MonitorCase("always(runs -> distance > 1.0)", _DISTANCE, "Passed", 0.25)),
    (
        "a bound that is violated, with its margin",
        MonitorCase("always(runs -> distance > 1.5)", _DISTANCE, "Failed", -0.25),
    ),
    ("at a bound, < fails", MonitorCase("always(runs -> distance < 3.0)", _DISTANCE, "Failed", 0.0)),
    ("at a bound, <= passes", MonitorCase("always(runs -> distance <= 3.0)", _DISTANCE, "Passed", 0.0)),
    (
        "a deadline that is kept, with the time left",
        MonitorCase("always(rise(near) -> eventually[0:0.75](not moves))", _STOP, "Passed", 0.25),
    ),
    (
        "a deadline that is missed, with the time over",
        MonitorCase("always(rise(near) -> eventually[0:0.25](not moves))", _STOP, "Failed", -0.25),
    ),
    (
        "an antecedent that never holds is not checked",
        MonitorCase("always(near & fall(near) -> not moves)", _STOP, "NC", None),
    ),
    (
        "a deadline after the end of the run is undecided",
        MonitorCase("always(rise(near) -> eventually[0:20](distance > 5.0))", {**_STOP, **_DISTANCE}, "NC", None),
    ),
)
"""The facts that must hold, and their checks: 20 answers."""
